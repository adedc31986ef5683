// What went wrong in numbers: a known mistake of the problem, the way in which they are written, or both.

import type { NumbersKey } from "../bank.js";
import { message, type Message, type TextKey } from "../text/text.js";
import { fewest } from "./slips.js";
import type { Slip } from "./verdict.js";

/** Below this tolerance numbers are whole ones, or due exactly: there is nothing to say of digits. */
export const EXACT = 1e-5;
/** Share by which a mistake's number, which is kept with six digits, may differ beside what the answer may. */
const KEPT = 1e-5;
/** Numbers are taken to have so many digits, if they seem to have fewer. */
const FEWEST_DIGITS = 3;
/** Share of wrong answers that one of the pairs may give by chance, as in ../../../grader/pairs.py. */
const BY_CHANCE = 0.01;
/** Share by which numbers are close to what is expected, also of the tenth part of the largest. */
const CLOSE = 0.03;
/** A number that may be off so little is hardly met by another mistake, as in ../../../grader/numbers.py. */
const PRECISE = 1e-4;
const DEGREES = 180 / Math.PI;

/** What is named: the index of what is said of a mistake, or slips, or nothing. */
export type Named = { readonly mistake?: number; readonly slips?: readonly Slip[] };

/** Some numbers as they were typed, NaN where one is blank, with what they may be off at the most. */
interface Typed {
  readonly mine: readonly number[];
  readonly right: readonly boolean[];
  readonly key: NumbersKey;
  readonly relative: number;
}

type Numbers = readonly number[];

/** What went wrong in `mine`, of which some are `right`; `text` is how they were typed. */
export function slipsInNumbers(mine: Numbers, right: readonly boolean[], key: NumbersKey, text: string): Named {
  const typed = { mine, right, key, relative: roomOf(text, key) };
  const isMeasured = key.tolerance >= EXACT;
  if (isMeasured && isToFewDigits(typed)) return { slips: [rounding("slip.rounded", key)] };
  const alone = mistakeBehind(typed);
  if (alone !== undefined) return { mistake: alone };
  if (!isMeasured) return {};
  const slips = writtenOtherwise(typed) ?? mistakeAndMore(typed);
  if (slips) return { slips };
  return isClose(typed) ? { slips: [rounding("slip.close", key)] } : {};
}

const rounding = (says: TextKey, { tolerance }: NumbersKey): Message => message(says, { percent: 100 * tolerance });

// --- mistakes of the problem ---

/** The share by which numbers that were typed may be off what they come from: half of the last digit. */
function roomOf(text: string, { tolerance }: NumbersKey): number {
  const decimals = text.match(/\d*[.,]\d+/g) ?? [];
  const digits = decimals.map((each) => each.replace(/^[0.,]+|[.,]/g, "").length);
  const most = Math.max(FEWEST_DIGITS, ...digits);
  return Math.max(Math.min(tolerance, 0.6 * 10 ** (1 - most)), EXACT);
}

function areNear(mine: Numbers, theirs: Numbers, { tolerance, floor }: NumbersKey, relative: number): boolean {
  const least = floor * (tolerance > 0 ? relative / tolerance : 1);
  return theirs.every((value, i) => Math.abs(mine[i]! - value) <= Math.max((relative + KEPT) * Math.abs(value), least));
}

/** The likeliest mistake that gives all digits of the numbers; else, of several numbers, the nearest in tolerance. */
function mistakeBehind({ mine, key, relative }: Typed): number | undefined {
  const known = relative <= PRECISE ? [...key.mistakes, ...(key.precise ?? [])] : key.mistakes;
  const within = (room: number) => known.filter(([, ...theirs]) => areNear(mine, theirs, key, room));
  const [exactly] = within(relative);
  if (exactly || mine.length < 2) return exactly?.[0];
  const off = ([, ...theirs]: readonly number[]) =>
    Math.max(...theirs.map((value, i) => Math.abs(mine[i]! - value) / Math.max(Math.abs(value), key.floor)));
  return within(key.tolerance).sort((a, b) => off(a) - off(b))[0]?.[0];
}

/** A mistake that gives the numbers once they are written as is expected. */
function mistakeAndMore({ mine, key, relative }: Typed): Slip[] | null {
  if (mine.length < 2) return null; // which some pair gives by chance
  const share = mine.map((value) => 2 * (relative + (key.floor * relative) / key.tolerance / Math.abs(value)));
  let tries = BY_CHANCE / share.reduce((product, each) => product * Math.min(1, each), 1);
  for (const way of WAYS) {
    const factors = key.units.map((unit) => way.factor(unit));
    if (factors.every((factor) => factor === 1)) continue;
    for (const [index, ...theirs] of key.mistakes) {
      tries -= 1;
      if (tries < 0) return null;
      const given = theirs.map((value, i) => value * factors[i]!);
      if (areNear(mine, given, key, relative)) return [{ mistake: index as number }, way.says(message("slip.answer"))];
    }
  }
  return null;
}

// --- how they are written ---

/** A way in which a number with a unit may be written as another one: times a factor. */
type Way = { readonly factor: (unit: string) => number; readonly says: (where: Message) => Message };

const isTurning = (unit: string): boolean => unit === "rad/s";

/** The power of metres in a unit: 1 of m/s, 2 of m^2, 0 of rad/s. */
const metresIn = (unit: string): number => {
  const [, power = "1"] = /^m(?:\^(\d))?(?![a-z])/.exec(unit) ?? [null, "0"];
  return Number(power);
};

/** The likelier ways first. */
const WAYS: readonly Way[] = [
  { factor: (unit) => (isTurning(unit) ? DEGREES : 1), says: (where) => message("slip.per-degree", { where }) },
  { factor: () => -1, says: (where) => message("slip.whole-sign", { where }) },
  { factor: (unit) => (isTurning(unit) ? 1 / DEGREES : 1), says: (where) => message("slip.radians-twice", { where }) },
  ...[1000, 100, 1 / 100, 1 / 1000].map((metre) => ({
    factor: (unit: string) => metre ** metresIn(unit),
    says: (where: Message) => message(metre > 1 ? "slip.metres-large" : "slip.metres-small", { where }),
  })),
  ...[10, 100, 1000, 1 / 10, 1 / 100, 1 / 1000].map((factor) => ({
    factor: () => factor,
    says: (where: Message) =>
      factor > 1
        ? message("slip.times-ten", { where, factor })
        : message("slip.over-ten", { where, factor: Math.round(1 / factor) }),
  })),
];

/** What is said of wrong numbers of which each is the right one, written otherwise; null where one is not. */
function writtenOtherwise(typed: Typed): Slip[] | null {
  const { mine, right, key, relative } = typed;
  const wrong = mine.flatMap((_, i) => (right[i] ? [] : [i]));
  const fits = (way: Way) =>
    wrong.filter((i) => {
      const due = key.right[i]!;
      const factor = way.factor(key.units[i] ?? "");
      const isZero = Math.abs(due) <= key.floor;
      return factor !== 1 && !isZero && Math.abs(mine[i]! - factor * due) <= (relative + KEPT) * Math.abs(factor * due);
    });
  const { told, open } = fewest(
    WAYS.map((way) => ({ ...way, places: fits(way) })),
    wrong,
  );
  return open.length > 0 ? null : told.map(({ says, places }) => says(whereOf(places, mine.length)));
}

function whereOf(places: readonly number[], count: number): Message {
  if (places.length === count) return message("slip.answer");
  const numbers = places.map((i) => i + 1);
  return places.length === 1
    ? message("slip.row", { row: numbers[0]! })
    : message("slip.entries", { entries: numbers.join(", ") });
}

// --- rounding ---

/** Whether all numbers are right to one or two digits, and one to two, as in ../../../grader/rounded.py. */
function isToFewDigits({ mine, right, key }: Typed): boolean {
  const toTwo = mine.map((value, i) => right[i]! || isTo(2, value, key.right[i]!));
  return mine.every((value, i) => toTwo[i]! || isTo(1, value, key.right[i]!)) && toTwo.some(Boolean);
}

/** Whether a number is the one that is expected, rounded to digits, or cut off after two. */
function isTo(digits: number, given: number, due: number): boolean {
  const step = 10 ** (Math.floor(Math.log10(Math.abs(due))) + 1 - digits);
  const ways = [Math.round(due / step) * step, ...(digits === 2 ? [Math.trunc(due / step) * step] : [])];
  return ways.some((way) => Math.abs(given - way) <= 1e-9 * Math.abs(due));
}

function isClose({ mine, key }: Typed): boolean {
  const largest = Math.max(...key.right.map(Math.abs));
  return mine.every((value, i) => {
    const due = key.right[i]!;
    return Math.abs(value - due) <= CLOSE * Math.max(Math.abs(due), largest / 10);
  });
}
