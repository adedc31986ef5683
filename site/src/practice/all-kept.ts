// All that is kept of a student, also as a file to take along: answered problems, progress in lessons, today's arm.

import type { Progress } from "./choice.js";
import { checkedProgress, keep, mergedProgress } from "./progress.js";
import { checkedSkills, keepSkills, mergedSkills, type Skills } from "./skills.js";
import { checkedDay, type Day, keepDay, laterDay } from "./today.js";

export type AllKept = { readonly progress: Progress; readonly lessons: Skills; readonly today: Day | null };

export const NOTHING_KEPT: AllKept = { progress: {}, lessons: {}, today: null };

export function keepAll(storage: Storage | null, { progress, lessons, today }: AllKept): void {
  keep(storage, progress);
  keepSkills(storage, lessons);
  keepDay(storage, today);
}

export function asFile(all: AllKept): string {
  return `${JSON.stringify({ qdot: "progress", version: 2, ...all }, null, 1)}\n`;
}

/** What is in a file, one of version 1 having progress alone; null where it is none. */
export function fromFile(text: string): AllKept | null {
  try {
    const content: unknown = JSON.parse(text);
    if (typeof content !== "object" || content === null || !("qdot" in content) || !("progress" in content))
      return null;
    const { progress, lessons, today } = content as Partial<Record<keyof AllKept, unknown>>;
    return { progress: checkedProgress(progress), lessons: checkedSkills(lessons), today: checkedDay(today) };
  } catch {
    return null;
  }
}

/** Both together, of each thing the one that is further. */
export function merged(mine: AllKept, other: AllKept): AllKept {
  return {
    progress: mergedProgress(mine.progress, other.progress),
    lessons: mergedSkills(mine.lessons, other.lessons),
    today: laterDay(mine.today, other.today),
  };
}
