// Find what went wrong in numbers: a known mistake of the problem, a slip in unit, sign or rounding, or both.

import type { NumbersKey } from "../bank.js";
import { message, type Message, type TextKey } from "../text/text.js";
import { coverPlaces, describePlaces } from "./slips.js";
import type { Slip } from "./verdict.js";

/** If a key's relative tolerance is smaller, its numbers are whole or exact, and rounding needs no comment. */
export const EXACT_TOLERANCE = 1e-5;
/** Mistaken numbers are stored with six digits; this tolerance, relative to them, is added to that of the answer. */
const STORED_TOLERANCE = 1e-5;
/** Numbers are assumed to have at least this many digits. */
const MIN_DIGITS = 3;
/** Highest accepted probability that some pair explains a wrong answer by chance. */
const MAX_CHANCE = 0.01;
/** Numbers are close within this share of the correct number, or of a tenth of the largest correct number. */
const CLOSE_TOLERANCE = 0.03;
/** Within this tolerance, relative to the number, a wrong mistake hardly matches by chance, as in ../../../grader/diagnosis/numbers.py. */
const PRECISE_TOLERANCE = 1e-4;
const DEGREES_PER_RADIAN = 180 / Math.PI;

/** What is reported: the index of a known mistake, or slips, or nothing. */
type Explanation = { readonly mistake?: number; readonly slips?: readonly Slip[] };

interface TypedNumbers {
  /** NaN for a blank. */
  readonly values: Numbers;
  /** For each number, whether it is right. */
  readonly rightFlags: readonly boolean[];
  readonly key: NumbersKey;
  /** Tolerance for the digits that the student typed, relative to each number. */
  readonly relativeTolerance: number;
}

type Numbers = readonly number[];

/** Return what went wrong in `values`, not all of which are right; `text` is the typed answer. */
export function explainWrongNumbers(
  values: Numbers,
  rightFlags: readonly boolean[],
  key: NumbersKey,
  text: string,
): Explanation {
  const typed = { values, rightFlags, key, relativeTolerance: computeToleranceOfDigits(text, key) };
  const isMeasured = key.tolerance >= EXACT_TOLERANCE;
  if (isMeasured && hasTooFewDigits(typed)) return { slips: [makeRoundingMessage("slip.rounded", key)] };
  const mistake = findMistake(typed);
  if (mistake !== undefined) return { mistake };
  if (!isMeasured) return {};
  const slips = findUnitSlips(typed) ?? findMistakeAndUnitSlip(typed);
  if (slips) return { slips };
  return areAllClose(typed) ? { slips: [makeRoundingMessage("slip.close", key)] } : {};
}

/** Return a message that names the tolerance in percent. */
const makeRoundingMessage = (key: TextKey, { tolerance }: NumbersKey): Message =>
  message(key, { percent: 100 * tolerance });

/** Return the relative tolerance of typed numbers: a little more than half a unit of the last digit. */
function computeToleranceOfDigits(text: string, { tolerance }: NumbersKey): number {
  const decimals = text.match(/\d*[.,]\d+/g) ?? [];
  const digits = decimals.map((number) => number.replace(/^[0.,]+|[.,]/g, "").length);
  const maxDigits = Math.max(MIN_DIGITS, ...digits);
  return Math.max(Math.min(tolerance, 0.6 * 10 ** (1 - maxDigits)), EXACT_TOLERANCE);
}

/**
 * Return whether numbers are those of a mistake, within a tolerance relative to these. The key's absolute tolerance is
 * reduced in the same ratio as its relative one.
 */
function areNear(
  values: Numbers,
  mistakenValues: Numbers,
  { tolerance: keyTolerance, floor: absoluteTolerance }: NumbersKey,
  relativeTolerance: number,
): boolean {
  const minTolerance = absoluteTolerance * (keyTolerance > 0 ? relativeTolerance / keyTolerance : 1);
  return mistakenValues.every((value, i) => {
    const tolerance = (relativeTolerance + STORED_TOLERANCE) * Math.abs(value);
    return Math.abs(values[i]! - value) <= Math.max(tolerance, minTolerance);
  });
}

/**
 * Return the index of the likeliest mistake that gives the typed digits. If none does, return for several numbers the
 * nearest mistake within the key's tolerance.
 */
function findMistake({ values, key, relativeTolerance }: TypedNumbers): number | undefined {
  const mistakes = relativeTolerance <= PRECISE_TOLERANCE ? [...key.mistakes, ...(key.precise ?? [])] : key.mistakes;
  const candidates = mistakes.map(([index, ...mistakenValues]) => ({ index, mistakenValues }));
  const listCandidatesWithin = (tolerance: number) =>
    candidates.filter(({ mistakenValues }) => areNear(values, mistakenValues, key, tolerance));
  const [precise] = listCandidatesWithin(relativeTolerance);
  if (precise || values.length < 2) return precise?.index;
  const computeDistance = (mistakenValues: Numbers) =>
    Math.max(...mistakenValues.map((value, i) => Math.abs(values[i]! - value) / Math.max(Math.abs(value), key.floor)));
  const [nearest] = listCandidatesWithin(key.tolerance).sort(
    (a, b) => computeDistance(a.mistakenValues) - computeDistance(b.mistakenValues),
  );
  return nearest?.index;
}

/** Return a mistake and a slip in unit or sign that turns the mistake's numbers into the typed ones. */
function findMistakeAndUnitSlip({ values, key, relativeTolerance }: TypedNumbers): Slip[] | null {
  if (values.length < 2) return null; // some pair would match by chance
  const minTolerance = (key.floor * relativeTolerance) / key.tolerance;
  // the probability that a random number of the same size is within the tolerance
  const chanceByNumber = values.map((value) => 2 * (relativeTolerance + minTolerance / Math.abs(value)));
  let triesLeft = MAX_CHANCE / chanceByNumber.reduce((product, probability) => product * Math.min(1, probability), 1);
  for (const unitSlip of UNIT_SLIPS) {
    const factors = key.units.map((unit) => unitSlip.factor(unit));
    if (factors.every((factor) => factor === 1)) continue;
    for (const [index, ...mistakenValues] of key.mistakes) {
      triesLeft -= 1;
      if (triesLeft < 0) return null;
      const changedValues = mistakenValues.map((value, i) => value * factors[i]!);
      if (areNear(values, changedValues, key, relativeTolerance))
        return [{ mistake: index as number }, unitSlip.report(message("slip.answer"))];
    }
  }
  return null;
}

/** A slip in the unit or sign of numbers. */
interface UnitSlip {
  /** Return the factor by which the slip changes a number with this unit. */
  readonly factor: (unit: string) => number;
  /** Return the message that reports the slip at a place. */
  readonly report: (where: Message) => Message;
}

const isAngularRate = (unit: string): boolean => unit === "rad/s";

/** Return the power of metres in a unit: 1 for m/s, 2 for m^2, 0 for rad/s. */
function countMetres(unit: string): number {
  const [, power = "1"] = /^m(?:\^(\d))?(?![a-z])/.exec(unit) ?? [null, "0"];
  return Number(power);
}

/** Likelier slips first. */
const UNIT_SLIPS: readonly UnitSlip[] = [
  {
    factor: (unit) => (isAngularRate(unit) ? DEGREES_PER_RADIAN : 1),
    report: (where) => message("slip.per-degree", { where }),
  },
  { factor: () => -1, report: (where) => message("slip.whole-sign", { where }) },
  {
    factor: (unit) => (isAngularRate(unit) ? 1 / DEGREES_PER_RADIAN : 1),
    report: (where) => message("slip.radians-twice", { where }),
  },
  ...[1000, 100, 1 / 100, 1 / 1000].map((unitsPerMetre) => ({
    factor: (unit: string) => unitsPerMetre ** countMetres(unit),
    report: (where: Message) => message(unitsPerMetre > 1 ? "slip.metres-large" : "slip.metres-small", { where }),
  })),
  ...[10, 100, 1000, 1 / 10, 1 / 100, 1 / 1000].map((factor) => ({
    factor: () => factor,
    report: (where: Message) =>
      factor > 1
        ? message("slip.times-ten", { where, factor })
        : message("slip.over-ten", { where, factor: Math.round(1 / factor) }),
  })),
];

/** Return slips in unit or sign that explain all wrong numbers; null if some wrong number stays unexplained. */
function findUnitSlips(typed: TypedNumbers): Slip[] | null {
  const { values, rightFlags, key, relativeTolerance } = typed;
  const wrongPlaces = values.flatMap((_, i) => (rightFlags[i] ? [] : [i]));
  const placesExplainedBy = (unitSlip: UnitSlip) =>
    wrongPlaces.filter((i) => {
      const factor = unitSlip.factor(key.units[i] ?? "");
      const changedValue = factor * key.right[i]!;
      const tolerance = (relativeTolerance + STORED_TOLERANCE) * Math.abs(changedValue);
      const isZero = Math.abs(key.right[i]!) <= key.floor;
      return factor !== 1 && !isZero && Math.abs(values[i]! - changedValue) <= tolerance;
    });
  const { chosenFindings, unexplainedPlaces } = coverPlaces(
    UNIT_SLIPS.map((unitSlip) => ({ ...unitSlip, places: placesExplainedBy(unitSlip) })),
    wrongPlaces,
  );
  if (unexplainedPlaces.length > 0) return null;
  const shape = { rows: values.length, columns: 1 };
  return chosenFindings.map(({ report, places }) =>
    report(places.length === values.length ? message("slip.answer") : describePlaces(places, wrongPlaces, shape)),
  );
}

/** Return whether all numbers are right to one or two digits, and some to two, as in ../../../grader/diagnosis/rounding.py. */
function hasTooFewDigits({ values, rightFlags, key }: TypedNumbers): boolean {
  const twoDigitFlags = values.map((value, i) => rightFlags[i]! || isRoundedTo(2, value, key.right[i]!));
  return (
    values.every((value, i) => twoDigitFlags[i]! || isRoundedTo(1, value, key.right[i]!)) && twoDigitFlags.some(Boolean)
  );
}

/** Return whether a number is the expected one, rounded to some digits, or cut off after two. */
function isRoundedTo(digits: number, typed: number, expected: number): boolean {
  const step = 10 ** (Math.floor(Math.log10(Math.abs(expected))) + 1 - digits);
  const roundedValues = [
    Math.round(expected / step) * step,
    ...(digits === 2 ? [Math.trunc(expected / step) * step] : []),
  ];
  return roundedValues.some((roundedValue) => Math.abs(typed - roundedValue) <= 1e-9 * Math.abs(expected));
}

/** Return whether all numbers are close to the correct ones. */
function areAllClose({ values, key }: TypedNumbers): boolean {
  const largestCorrect = Math.max(...key.right.map(Math.abs));
  return values.every((value, i) => {
    const expected = key.right[i]!;
    return Math.abs(value - expected) <= CLOSE_TOLERANCE * Math.max(Math.abs(expected), largestCorrect / 10);
  });
}
