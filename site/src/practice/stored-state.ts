// The stored state of a student's work, in the browser or in a file: answered questions and progress in lessons.

import { useState } from "preact/hooks";

import { resultOrNull, storage, loadJson, storeText } from "../storage.js";
import { BOX_DELAYS, type ItemState, type Progress } from "./choice.js";
import { checkSkills, mergeSkill, type Skills } from "./skills.js";

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
    const isDeletion = changes === EMPTY_STATE; // deletes what other tabs have stored, too
    const newState = isDeletion ? EMPTY_STATE : keepOtherChanges(state, { ...state, ...changes }, loadState(storage));
    setState(newState);
    storeState(storage, newState);
  };
  return [state, change];
}

/** Return this tab's new state with what other tabs have stored since; of each item and lesson, the last change counts. */
export function keepOtherChanges(before: StoredState, after: StoredState, stored: StoredState): StoredState {
  const keep = <T>(...[old, changed, kept]: readonly Readonly<Record<string, T>>[]): Record<string, T> => ({
    ...changed,
    ...Object.fromEntries(Object.entries(kept!).filter(([name]) => changed![name] === old![name])),
  });
  return {
    progress: keep(before.progress, after.progress, stored.progress),
    lessons: keep(before.lessons, after.lessons, stored.lessons),
  };
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
  const higherBox = (myState: ItemState, state: ItemState): ItemState => (state.box > myState.box ? state : myState);
  return {
    progress: mergeRecords(mine.progress, other.progress, higherBox),
    lessons: mergeRecords(mine.lessons, other.lessons, mergeSkill),
  };
}

/** Merge two records; if both have an entry, `mergeEntries` returns the merged one. */
function mergeRecords<T>(
  mine: Readonly<Record<string, T>>,
  other: Readonly<Record<string, T>>,
  mergeEntries: (mine: T, other: T) => T,
): Record<string, T> {
  const merged: Record<string, T> = { ...mine };
  for (const [name, entry] of Object.entries(other))
    merged[name] = Object.hasOwn(mine, name) ? mergeEntries(mine[name]!, entry) : entry;
  return merged;
}

/** Return the valid item states in parsed JSON. */
export function checkProgress(content: unknown): Progress {
  const validStates: Record<string, ItemState> = {};
  for (const [name, entry] of Object.entries(content ?? {})) {
    if (isItemState(entry)) {
      const missed = entry.missed === true ? { missed: true } : {};
      validStates[name] = { right: entry.right, ...missed, box: entry.box, due: entry.due };
    }
  }
  return validStates;
}

function isItemState(entry: unknown): entry is ItemState {
  if (typeof entry !== "object" || entry === null) return false;
  const { right, box, due } = entry as Partial<Record<keyof ItemState, unknown>>;
  return typeof right === "boolean" && BOX_DELAYS[box as number] !== undefined && Number.isFinite(due);
}
