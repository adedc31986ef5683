// Which problems were answered, and when they are due again, stored in this browser.

import { storeText, storedJson } from "../storage.js";
import { type Attempted, type Progress, WAITS } from "./choice.js";

const KEY = "qdot-progress";

/** Return the stored progress; empty if the browser stores nothing, or something invalid. */
export const storedProgress = (storage: Storage | null): Progress => storedJson(storage, KEY, checkProgress);

export const storeProgress = (storage: Storage | null, progress: Progress): void =>
  storeText(storage, KEY, JSON.stringify(progress));

/** Merge two progresses; of an item in both, the one in the higher box is kept. */
export function mergeProgress(mine: Progress, other: Progress): Progress {
  const merged: Record<string, Attempted> = { ...mine };
  for (const [name, attempt] of Object.entries(other)) {
    const progressAfter = merged[name];
    if (!progressAfter || attempt.box > progressAfter.box) merged[name] = attempt;
  }
  return merged;
}

/** Return the valid entries of a progress file. */
export function checkProgress(content: unknown): Progress {
  const found: Record<string, Attempted> = {};
  for (const [name, entry] of Object.entries(content ?? {})) {
    if (isAttempted(entry)) {
      const missed = entry.missed === true ? { missed: true } : {};
      found[name] = { right: entry.right, ...missed, box: entry.box, due: entry.due };
    }
  }
  return found;
}

function isAttempted(entry: unknown): entry is Attempted {
  if (typeof entry !== "object" || entry === null) return false;
  const { right, box, due } = entry as Partial<Record<keyof Attempted, unknown>>;
  return typeof right === "boolean" && WAITS[box as number] !== undefined && Number.isFinite(due);
}
