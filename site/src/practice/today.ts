// Today's arm: by the date in UTC the same for everybody who practises on this site, with a score of tries to share.

import type { Index } from "../bank.js";
import { keepText, keptJson } from "../storage.js";
import { ANYTHING, type Item, items, nameOf, numbers } from "./choice.js";

const KEY = "qdot-today";
const DAY = 24 * 3600 * 1000;
/** Arms of a higher difficulty are too long for a day's question. */
const HARDEST = 3;

/** What was done on a day: each try, right or not, whether there was help, and the row of days that were solved. */
export interface Day {
  readonly day: string;
  readonly item: string;
  readonly tries: readonly boolean[];
  readonly helped: boolean;
  /** So many days one after the other were solved, up to the last of them. */
  readonly row: number;
  readonly last: string;
}

/** The date in UTC, as 2026-11-25. */
export const dayOf = (now: number): string => new Date(now).toISOString().slice(0, 10);

/** The question of a day, by a hash of the day and each family, then each item: a new problem rarely changes it. */
export function itemOf(index: Index, day: string): Item | null {
  const easy = index.families.map((family) => ({
    ...family,
    problems: family.problems.filter(({ difficulty }) => difficulty <= HARDEST),
  }));
  const all = items({ ...index, families: easy }, ANYTHING);
  const pool = all.length > 0 ? all : items(index, ANYTHING);
  const family = first([...new Set(pool.map((item) => item.family))], (name) => `${day} ${name}`);
  return first(
    pool.filter((item) => item.family === family),
    (item) => `${day} ${nameOf(item)}`,
  );
}

function first<T>(all: readonly T[], called: (each: T) => string): T | null {
  let best: T | null = null;
  let least = Infinity;
  for (const each of all) {
    const lot = numbers(called(each))();
    if (lot < least) [best, least] = [each, lot];
  }
  return best;
}

export const isSolved = ({ tries }: Day): boolean => tries.at(-1) === true;

/** What is known of a day, of what was kept: nothing done yet where that is of another day, or of another question. */
export function onDay(kept: Day | null, day: string, item: Item): Day {
  if (kept?.day === day && kept.item === nameOf(item)) return kept;
  const [row, last] = kept ? [kept.row, kept.last] : [0, ""];
  return { day, item: nameOf(item), tries: [], helped: false, row, last };
}

/** The day after a try; what is solved stays as it is. */
export function tried(now: Day, right: boolean, helped: boolean): Day {
  if (isSolved(now)) return now;
  const next = { ...now, tries: [...now.tries, right], helped: now.helped || helped };
  if (!right) return next;
  const yesterday = dayOf(Date.parse(now.day) - DAY);
  return { ...next, row: now.last === yesterday ? now.row + 1 : 1, last: now.day };
}

export const checkedDay = (found: unknown): Day | null => (isDay(found) ? found : null);

export const keptDay = (storage: Storage | null): Day | null => keptJson(storage, KEY, checkedDay);

export const keepDay = (storage: Storage | null, day: Day | null): void => keepText(storage, KEY, JSON.stringify(day));

/** Of two the later; of the same day that which has more tries, unless it is the first that is solved. */
export function laterDay(mine: Day | null, other: Day | null): Day | null {
  if (!mine || !other) return mine ?? other;
  if (mine.day !== other.day) return mine.day > other.day ? mine : other;
  if (isSolved(mine) !== isSolved(other)) return isSolved(mine) ? mine : other;
  return other.tries.length > mine.tries.length ? other : mine;
}

function isDay(found: unknown): found is Day {
  if (typeof found !== "object" || found === null) return false;
  const { day, item, tries, helped, row, last } = found as Partial<Record<keyof Day, unknown>>;
  return (
    [day, item, last].every((text) => typeof text === "string") &&
    Array.isArray(tries) &&
    tries.every((right) => typeof right === "boolean") &&
    typeof helped === "boolean" &&
    Number.isInteger(row)
  );
}

/** The tries as signs. */
export const marks = ({ tries }: Day): string => tries.map((right) => (right ? "✓" : "✗")).join(" ");
