// All stored progress of a student, also as a file: answered problems and progress in lessons.

import type { Progress } from "./choice.js";
import { checkProgress, mergeProgress, storeProgress } from "./progress.js";
import { checkSkills, storeSkills, mergeSkills, type Skills } from "./skills.js";

export type StoredState = { readonly progress: Progress; readonly lessons: Skills };

export const EMPTY_STATE: StoredState = { progress: {}, lessons: {} };

export function storeAll(storage: Storage | null, { progress, lessons }: StoredState): void {
  storeProgress(storage, progress);
  storeSkills(storage, lessons);
}

export function asFile(all: StoredState): string {
  return `${JSON.stringify({ qdot: "progress", version: 2, ...all }, null, 1)}\n`;
}

/** Return the content of a file, which has no lessons in version 1; null if it is no such file. */
export function fromFile(text: string): StoredState | null {
  try {
    const content: unknown = JSON.parse(text);
    if (typeof content !== "object" || content === null || !("qdot" in content) || !("progress" in content))
      return null;
    const { progress, lessons } = content as Partial<Record<keyof StoredState, unknown>>;
    return { progress: checkProgress(progress), lessons: checkSkills(lessons) };
  } catch {
    return null;
  }
}

/** Merge two states; of each item and lesson, the one with more progress is kept. */
export function mergeStates(mine: StoredState, other: StoredState): StoredState {
  return { progress: mergeProgress(mine.progress, other.progress), lessons: mergeSkills(mine.lessons, other.lessons) };
}
