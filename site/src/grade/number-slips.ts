// Find what went wrong in numbers: a known mistake of the problem, the way in which they are written, or both.

import type { NumbersKey } from "../bank.js";
import { message, type Message, type TextKey } from "../text/text.js";
import { coverPlaces } from "./slips.js";
import type { Slip } from "./verdict.js";

/** Below this tolerance, numbers must be whole or exact, so digits need no comment. */
export const EXACT = 1e-5;
/** Relative tolerance for a mistake's number, stored with six digits, in addition to the answer's. */
const STORED = 1e-5;
/** Numbers are assumed to have at least this many digits. */
const FEWEST_DIGITS = 3;
/** Highest accepted probability that some pair explains a wrong answer by chance, as in ../../../grader/pairs.py. */
const BY_CHANCE = 0.01;
/** Relative tolerance for numbers that are close, of the number or of a tenth of the largest. */
const CLOSE = 0.03;
/** With at most this relative tolerance, another mistake hardly matches by chance, as in ../../../grader/numbers.py. */
const PRECISE = 1e-4;
const DEGREES = 180 / Math.PI;

/** What is reported: the index of a known mistake, or slips, or nothing. */
export type Explanation = { readonly mistake?: number; readonly slips?: readonly Slip[] };

/** Typed numbers (NaN for a blank), which of them are right, the key, and their relative tolerance. */
interface TypedNumbers {
  readonly values: readonly number[];
  readonly right: readonly boolean[];
  readonly key: NumbersKey;
  readonly relative: number;
}

type Numbers = readonly number[];

/** Return what went wrong in `values`, of which some are `right`; `text` is the typed answer. */
export function slipsInNumbers(values: Numbers, right: readonly boolean[], key: NumbersKey, text: string): Explanation {
  const typed = { values, right, key, relative: toleranceOf(text, key) };
  const isMeasured = key.tolerance >= EXACT;
  if (isMeasured && isToFewDigits(typed)) return { slips: [roundingMessage("slip.rounded", key)] };
  const mistake = findMistake(typed);
  if (mistake !== undefined) return { mistake };
  if (!isMeasured) return {};
  const slips = findWays(typed) ?? findMistakeAndWay(typed);
  if (slips) return { slips };
  return isClose(typed) ? { slips: [roundingMessage("slip.close", key)] } : {};
}

const roundingMessage = (key: TextKey, { tolerance }: NumbersKey): Message =>
  message(key, { percent: 100 * tolerance });

/** Return the relative tolerance of typed numbers: half a unit of the last digit. */
function toleranceOf(text: string, { tolerance }: NumbersKey): number {
  const decimals = text.match(/\d*[.,]\d+/g) ?? [];
  const digits = decimals.map((number) => number.replace(/^[0.,]+|[.,]/g, "").length);
  const maxDigits = Math.max(FEWEST_DIGITS, ...digits);
  return Math.max(Math.min(tolerance, 0.6 * 10 ** (1 - maxDigits)), EXACT);
}

function areNear(values: Numbers, mistaken: Numbers, { tolerance, floor }: NumbersKey, relative: number): boolean {
  const least = floor * (tolerance > 0 ? relative / tolerance : 1);
  return mistaken.every(
    (value, i) => Math.abs(values[i]! - value) <= Math.max((relative + STORED) * Math.abs(value), least),
  );
}

/** Return the likeliest mistake that gives the typed digits; of several numbers, else the nearest within tolerance. */
function findMistake({ values, key, relative }: TypedNumbers): number | undefined {
  const known = relative <= PRECISE ? [...key.mistakes, ...(key.precise ?? [])] : key.mistakes;
  const within = (tolerance: number) => known.filter(([, ...mistaken]) => areNear(values, mistaken, key, tolerance));
  const [exactly] = within(relative);
  if (exactly || values.length < 2) return exactly?.[0];
  const distance = ([, ...mistaken]: readonly number[]) =>
    Math.max(...mistaken.map((value, i) => Math.abs(values[i]! - value) / Math.max(Math.abs(value), key.floor)));
  return within(key.tolerance).sort((a, b) => distance(a) - distance(b))[0]?.[0];
}

/** Return a mistake, and a way of writing numbers that turns the mistake's numbers into the typed ones. */
function findMistakeAndWay({ values, key, relative }: TypedNumbers): Slip[] | null {
  if (values.length < 2) return null; // some pair would match by chance
  const chanceByNumber = values.map(
    (value) => 2 * (relative + (key.floor * relative) / key.tolerance / Math.abs(value)),
  );
  let tries = BY_CHANCE / chanceByNumber.reduce((product, probability) => product * Math.min(1, probability), 1);
  for (const way of WAYS) {
    const factors = key.units.map((unit) => way.factor(unit));
    if (factors.every((factor) => factor === 1)) continue;
    for (const [index, ...mistaken] of key.mistakes) {
      tries -= 1;
      if (tries < 0) return null;
      const written = mistaken.map((value, i) => value * factors[i]!);
      if (areNear(values, written, key, relative))
        return [{ mistake: index as number }, way.report(message("slip.answer"))];
    }
  }
  return null;
}

/** A way of writing a number with another unit or sign: its factor, and the message that reports it. */
type Way = { readonly factor: (unit: string) => number; readonly report: (where: Message) => Message };

const isAngularRate = (unit: string): boolean => unit === "rad/s";

/** Return the power of metres in a unit: 1 for m/s, 2 for m^2, 0 for rad/s. */
function metresIn(unit: string): number {
  const [, power = "1"] = /^m(?:\^(\d))?(?![a-z])/.exec(unit) ?? [null, "0"];
  return Number(power);
}

/** Likelier ways first. */
const WAYS: readonly Way[] = [
  { factor: (unit) => (isAngularRate(unit) ? DEGREES : 1), report: (where) => message("slip.per-degree", { where }) },
  { factor: () => -1, report: (where) => message("slip.whole-sign", { where }) },
  {
    factor: (unit) => (isAngularRate(unit) ? 1 / DEGREES : 1),
    report: (where) => message("slip.radians-twice", { where }),
  },
  ...[1000, 100, 1 / 100, 1 / 1000].map((metre) => ({
    factor: (unit: string) => metre ** metresIn(unit),
    report: (where: Message) => message(metre > 1 ? "slip.metres-large" : "slip.metres-small", { where }),
  })),
  ...[10, 100, 1000, 1 / 10, 1 / 100, 1 / 1000].map((factor) => ({
    factor: () => factor,
    report: (where: Message) =>
      factor > 1
        ? message("slip.times-ten", { where, factor })
        : message("slip.over-ten", { where, factor: Math.round(1 / factor) }),
  })),
];

/** Return slips if each wrong number is right but for a way of writing; null if one is not. */
function findWays(typed: TypedNumbers): Slip[] | null {
  const { values, right, key, relative } = typed;
  const wrong = values.flatMap((_, i) => (right[i] ? [] : [i]));
  const fits = (way: Way) =>
    wrong.filter((i) => {
      const expected = key.right[i]!;
      const factor = way.factor(key.units[i] ?? "");
      const isZero = Math.abs(expected) <= key.floor;
      return (
        factor !== 1 &&
        !isZero &&
        Math.abs(values[i]! - factor * expected) <= (relative + STORED) * Math.abs(factor * expected)
      );
    });
  const { chosen, open } = coverPlaces(
    WAYS.map((way) => ({ ...way, places: fits(way) })),
    wrong,
  );
  return open.length > 0 ? null : chosen.map(({ report, places }) => report(whereOf(places, values.length)));
}

/** Return the sentence part that says where numbers are. */
function whereOf(places: readonly number[], count: number): Message {
  if (places.length === count) return message("slip.answer");
  const numbers = places.map((i) => i + 1);
  return places.length === 1
    ? message("slip.row", { row: numbers[0]! })
    : message("slip.entries", { entries: numbers.join(", ") });
}

/** Return whether all numbers are right to one or two digits, and some to two, as in ../../../grader/rounded.py. */
function isToFewDigits({ values, right, key }: TypedNumbers): boolean {
  const toTwo = values.map((value, i) => right[i]! || isRoundedTo(2, value, key.right[i]!));
  return values.every((value, i) => toTwo[i]! || isRoundedTo(1, value, key.right[i]!)) && toTwo.some(Boolean);
}

/** Return whether a number is the expected one, rounded to some digits, or cut off after two. */
function isRoundedTo(digits: number, typed: number, expected: number): boolean {
  const step = 10 ** (Math.floor(Math.log10(Math.abs(expected))) + 1 - digits);
  const rounded = [Math.round(expected / step) * step, ...(digits === 2 ? [Math.trunc(expected / step) * step] : [])];
  return rounded.some((way) => Math.abs(typed - way) <= 1e-9 * Math.abs(expected));
}

function isClose({ values, key }: TypedNumbers): boolean {
  const largest = Math.max(...key.right.map(Math.abs));
  return values.every((value, i) => {
    const expected = key.right[i]!;
    return Math.abs(value - expected) <= CLOSE * Math.max(Math.abs(expected), largest / 10);
  });
}
