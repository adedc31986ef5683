// The stored state of a student's work, in the browser or in a file: answered questions and progress in lessons.

import { useState } from "preact/hooks";

import { resultOrNull, storage, loadJson, storeText } from "../storage.js";
import type { Progress } from "./choice.js";
import { checkProgress, mergeProgress } from "./progress.js";
import { checkSkills, mergeSkills, type Skills } from "./skills.js";

export type StoredState = { readonly progress: Progress; readonly lessons: Skills };

export const EMPTY_STATE: StoredState = { progress: {}, lessons: {} };

const KEYS = { progress: "qdot-progress", lessons: "qdot-lessons" } as const;

/** Return the stored state; a part is empty if the browser stores nothing there, or something invalid. */
export const loadState = (storage: Storage | null): StoredState => ({
  progress: loadJson(storage, KEYS.progress, checkProgress),
  lessons: loadJson(storage, KEYS.lessons, checkSkills),
});

/** Store the parts of the state that have changed. */
export function storeState(storage: Storage | null, changes: Partial<StoredState>): void {
  for (const part of ["progress", "lessons"] as const)
    if (changes[part]) storeText(storage, KEYS[part], JSON.stringify(changes[part]));
}

/** Return the stored state, and a function that changes parts of it and stores them. */
export function useStoredState(): [StoredState, (changes: Partial<StoredState>) => void] {
  const [state, setState] = useState(() => loadState(storage));
  const change = (changes: Partial<StoredState>): void => {
    setState({ ...state, ...changes });
    storeState(storage, changes);
  };
  return [state, change];
}

export function writeFile(state: StoredState): string {
  return `${JSON.stringify({ qdot: "progress", version: 2, ...state }, null, 1)}\n`;
}

/** Return the content of a file, which has no lessons in version 1; null if it is no such file. */
export function parseFile(text: string): StoredState | null {
  const content = resultOrNull(() => JSON.parse(text) as unknown);
  if (typeof content !== "object" || content === null || !("qdot" in content) || !("progress" in content)) return null;
  const { progress, lessons } = content as Partial<Record<keyof StoredState, unknown>>;
  return { progress: checkProgress(progress), lessons: checkSkills(lessons) };
}

/** Merge two states; of each item and lesson, the one with more progress is kept. */
export function mergeStates(mine: StoredState, other: StoredState): StoredState {
  return { progress: mergeProgress(mine.progress, other.progress), lessons: mergeSkills(mine.lessons, other.lessons) };
}
