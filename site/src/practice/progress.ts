// Which problems were answered, and when they come again, kept in this browser.

import { keepText, keptJson } from "../storage.js";
import { type Attempted, type Progress, WAITS } from "./choice.js";

const KEY = "qdot-progress";

/** What is kept; nothing where the browser keeps nothing, or something else stands there. */
export const kept = (storage: Storage | null): Progress => keptJson(storage, KEY, checkedProgress);

export const keep = (storage: Storage | null, progress: Progress): void =>
  keepText(storage, KEY, JSON.stringify(progress));

/** Both together; of an item in both, the attempt of the higher box. */
export function mergedProgress(mine: Progress, other: Progress): Progress {
  const found: Record<string, Attempted> = { ...mine };
  for (const [name, attempt] of Object.entries(other)) {
    const own = found[name];
    if (!own || attempt.box > own.box) found[name] = attempt;
  }
  return found;
}

/** What of it is progress. */
export function checkedProgress(content: unknown): Progress {
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
