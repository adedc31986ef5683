// Check and merge stored progress: which problems were answered, and when they are due again.

import { type ItemState, type Progress, BOX_DELAYS } from "./choice.js";

/** Merge two progresses; of an item in both, the state with the higher box is kept. */
export function mergeProgress(mine: Progress, other: Progress): Progress {
  const merged: Record<string, ItemState> = { ...mine };
  for (const [name, state] of Object.entries(other)) {
    const myState = merged[name];
    if (!myState || state.box > myState.box) merged[name] = state;
  }
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
