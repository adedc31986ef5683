// Check and merge stored progress: which problems were answered, and when they are due again.

import { type ItemState, type Progress, WAITS } from "./choice.js";

/** Merge two progresses; of an item in both, the one in the higher box is kept. */
export function mergeProgress(mine: Progress, other: Progress): Progress {
  const merged: Record<string, ItemState> = { ...mine };
  for (const [name, attempt] of Object.entries(other)) {
    const myAttempt = merged[name];
    if (!myAttempt || attempt.box > myAttempt.box) merged[name] = attempt;
  }
  return merged;
}

/** Return the valid entries of a progress file. */
export function checkProgress(content: unknown): Progress {
  const valid: Record<string, ItemState> = {};
  for (const [name, entry] of Object.entries(content ?? {})) {
    if (isAttempted(entry)) {
      const missed = entry.missed === true ? { missed: true } : {};
      valid[name] = { right: entry.right, ...missed, box: entry.box, due: entry.due };
    }
  }
  return valid;
}

function isAttempted(entry: unknown): entry is ItemState {
  if (typeof entry !== "object" || entry === null) return false;
  const { right, box, due } = entry as Partial<Record<keyof ItemState, unknown>>;
  return typeof right === "boolean" && WAITS[box as number] !== undefined && Number.isFinite(due);
}
