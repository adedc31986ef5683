// Judge numbers with units, and vectors whose length does not matter.

import { dot } from "../arm/vector.js";
import { findMistakeIndex, type NumbersKey, type ValuesKey } from "../bank.js";
import { evaluate, type Value } from "../read/evaluate.js";
import { readCommasAsPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { convertNumbers } from "../read/tables.js";
import { hasBlank, findNames, type Node, type Rows, type SymbolValues } from "../read/tree.js";
import { convertUnitsOfNumbers, findUnits, parseUnit, replaceLatexUnits } from "../read/units.js";
import { message } from "../text/text.js";
import { computeShareForDeviations, computeShareOfEntries } from "./credit.js";
import { EXACT_TOLERANCE, explainWrongNumbers } from "./number-slips.js";
import { correct, isVerdict, listNames, missing, parseOrVerdict, verdictOf, wrong } from "./verdict.js";
import type { Verdict } from "./verdict.js";
import { extractEntries, labelOf, parseRowsOrTable } from "./forms.js";
import { writeConfiguration, findUnknownSymbols, computeFingerprintWeight, getConfiguration } from "./values.js";
import { correctOrUnsure, readFormulas } from "./values.js";

const NO_SYMBOLS: ReadonlySet<string> = new Set();
/** Tolerance of formulas for rounding errors, relative to the size of the terms (`Value.size`). */
const FORMULA_TOLERANCE = 1e-9;
/** A smaller number, relative to the terms from which it was computed, is a rounding error. */
const ZERO_TOLERANCE = 1e-12;

/** Judge numbers, which are right within the key's tolerance. */
export function judgeNumbers(answer: string, key: NumbersKey, labels: readonly string[] = []): Verdict {
  const rowsOrVerdict = readNumbers(answer, key.units, labels);
  return isVerdict(rowsOrVerdict)
    ? rowsOrVerdict
    : parseOrVerdict(() => judgeEntries(rowsOrVerdict.flat(), key, answer));
}

/** Return one number for each of the `units`, in SI units, or the verdict on an answer without such numbers. */
export function readNumbers(answer: string, units: readonly string[], labels: readonly string[] = []): Rows | Verdict {
  if (!answer.trim()) return missing();
  const textWithUnits = replaceLatexUnits(answer);
  const unitVerdict = findWrongUnit(textWithUnits, labels, units);
  if (unitVerdict) return unitVerdict;
  const text = convertUnitsOfNumbers(textWithUnits);
  const count = units.length;
  const rowsOrVerdict = parseRowsOrTable(
    (typed) => extractEntries(parse(typed, NO_SYMBOLS), { rows: count, columns: 1 }, NO_SYMBOLS, labels),
    count === 1 ? readCommasAsPoints(text) : text,
    () => convertNumbers(text, count),
  );
  if (isVerdict(rowsOrVerdict)) return rowsOrVerdict;
  const names = findNames(...rowsOrVerdict.flat());
  return names.size > 0 ? wrong("read.numbers", { names: listNames(names) }) : rowsOrVerdict;
}

/** Return the verdict on a unit whose dimension differs from the expected one; null if all units can be right. */
function findWrongUnit(text: string, labels: readonly string[], units: readonly string[]): Verdict | null {
  const numbersText = text.trim();
  const separator = [";", "\n"].find((candidate) => numbersText.includes(candidate)) ?? ",";
  const countSeparators = (part: string): number => part.split(separator).length - 1;
  const isListOfExpectedLength = countSeparators(numbersText) + 1 === units.length;
  const names = labels.map(labelOf);
  for (const { name, unit, end } of findUnits(numbersText)) {
    const isAfterBrackets = "]}".includes(numbersText[end - 1] as string); // in [1, 2] m, the unit is that of all entries
    const indexByPlace = isListOfExpectedLength && !isAfterBrackets ? countSeparators(numbersText.slice(0, end)) : -1;
    const indexByName = names.indexOf(labelOf(name));
    const index = indexByName >= 0 ? indexByName : indexByPlace; // -1 if the unit may be that of any entry
    const possibleUnits = index < 0 ? units : units.slice(index, index + 1);
    const dimension = describeDimension(unit);
    const possibleDimensions = possibleUnits.map(describeDimension);
    const isKnown = dimension !== null && possibleDimensions.length > 0 && !possibleDimensions.includes(null);
    if (!isKnown || possibleDimensions.includes(dimension)) continue;
    const expected = possibleUnits[0] as string;
    return index >= 0 && units.length > 1
      ? wrong("read.unit-of-entry", { unit, entry: index + 1, expected })
      : wrong("read.unit", { unit, expected });
  }
  return null;
}

/** Return a text that is equal for units of the same dimension; null if there is no unit, or an unknown one. */
const describeDimension = (unit: string): string | null =>
  unit === "" ? null : (parseUnit(unit)?.dimension.join() ?? null);

/** Judge numbers one by one; `text` is the typed answer. */
function judgeEntries(entries: readonly Node[], key: NumbersKey, text: string): Verdict {
  const { right: correctValues, tolerance: relativeTolerance } = key;
  const floorOf = (i: number) => key.floors?.[i] ?? key.floor;
  const values = entries.map((entry) => (hasBlank(entry) ? NaN : evaluateReal(entry)));
  const isNear = (value: number, expected: number, i: number) =>
    Math.abs(value - expected) <= Math.max(relativeTolerance * Math.abs(expected), floorOf(i));
  const rightFlags = values.map((value, i) => isNear(value, correctValues[i] as number, i));
  if (rightFlags.every(Boolean))
    return correct(
      relativeTolerance < EXACT_TOLERANCE
        ? undefined
        : message("verdict.numbers", { percent: 100 * relativeTolerance }),
    );
  const firstWrong = rightFlags.indexOf(false);
  const reason = message("verdict.number", {
    which: message(values.length > 1 ? "verdict.nth-number" : "answer.label", { n: firstWrong + 1 }),
    yours: Number.isFinite(values[firstWrong]) ? (values[firstWrong] as number) : "—",
    expected: Number((correctValues[firstWrong] as number).toPrecision(4)),
    unit: key.units[firstWrong] ? ` ${key.units[firstWrong]}` : "",
  });
  const zeroFlags = correctValues.map((expected, i) => Math.abs(expected) <= floorOf(i));
  const isRightUpToSigns =
    rightFlags.length > 1 &&
    !zeroFlags.every(Boolean) &&
    key.units.every(Boolean) && // numbers without units are counts, such as a rank
    values.every((value, i) => [value, -value].some((candidate) => isNear(candidate, correctValues[i] as number, i)));
  const shareByEntries = computeShareOfEntries(rightFlags, zeroFlags, entries.map(hasBlank));
  const share = isRightUpToSigns ? Math.max(shareByEntries, computeShareForDeviations(1)) : shareByEntries;
  return verdictOf(share, isRightUpToSigns ? [message("verdict.but-signs"), reason] : [reason], {
    entries: rightFlags.map((isRight) => [isRight]),
    ...explainWrongNumbers(values, rightFlags, key, text),
  });
}

/** Return the value of a number, NaN if it has an imaginary part. */
function evaluateReal(entry: Node): number {
  const { re, im, size: termSize } = evaluate(entry, {});
  return Math.abs(im) <= FORMULA_TOLERANCE * termSize ? re : NaN;
}

/** Judge a vector that is right if it is the reference times any nonzero factor. */
export function judgeDirection(answer: string, key: ValuesKey, labels: readonly string[] = []): Verdict {
  const rowsOrVerdict = readFormulas(answer, key, labels);
  if (isVerdict(rowsOrVerdict)) return rowsOrVerdict;
  const entries = rowsOrVerdict.flat();
  return entries.some(hasBlank) ? missing() : parseOrVerdict(() => judgeVector(entries, key));
}

/** Judge a vector of formulas by its values at the configurations of the key, or a numeric vector. */
function judgeVector(entries: readonly Node[], key: ValuesKey): Verdict {
  const names = findNames(...entries);
  const isNumeric = typeof key.tolerance === "number"; // formulas have no tolerance
  if (isNumeric) return judgeNumericVector(entries, names, key, key.tolerance);
  const vectorsByPoint = key.points.map((_, k) => {
    const configuration = getConfiguration(key, k, names);
    return entries.map((entry) => evaluate(entry, configuration));
  });
  const isZero = ({ re, im, size: termSize }: Value) => Math.hypot(re, im) <= ZERO_TOLERANCE * termSize;
  if (vectorsByPoint.every((vector) => vector.every(isZero))) return wrong("verdict.zero-vector");
  const firstWrongPoint = vectorsByPoint.findIndex((vector, k) => {
    const expected = key.right.map((correctValues) => correctValues[k] ?? NaN);
    const tolerance = FORMULA_TOLERANCE * Math.max(...vector.map(({ size: termSize }) => termSize));
    if (!Number.isFinite(tolerance)) return true;
    const realAndImaginaryParts = [vector.map(({ re }) => re), vector.map(({ im }) => im)];
    return realAndImaginaryParts.some((part) => computeDistanceFromLine(part, expected) > tolerance);
  });
  if (firstWrongPoint < 0) return correctOrUnsure(entries, message("verdict.direction"), vectorsByPoint);
  const unknownMessage = findUnknownSymbols(names, key);
  if (unknownMessage) return verdictOf(0, [unknownMessage]);
  const realVectors = vectorsByPoint.map((vector) => vector.map(({ re, im }) => (im === 0 ? re : NaN)));
  const mistake = findMistakeIndex(key.mistakes, (mistakenFingerprints) =>
    mistakenFingerprints.every((mistakenFingerprint, k) => {
      const tolerance = FINGERPRINT_TOLERANCE * Math.max(mistakenFingerprint, MIN_FINGERPRINT);
      return Math.abs(computeFingerprint(realVectors[k] ?? []) - mistakenFingerprint) <= tolerance;
    }),
  );
  return reportDifference(names, getConfiguration(key, firstWrongPoint), mistake);
}

/**
 * Tolerance for the fingerprint of a direction, relative to the fingerprint, which is stored with six digits. Smaller
 * fingerprints than MIN_FINGERPRINT get the tolerance of MIN_FINGERPRINT.
 */
const FINGERPRINT_TOLERANCE = 1e-5;
const MIN_FINGERPRINT = 0.1;

/** Return a fingerprint of a direction, independent of its length and sign, as in ../../../exercises/site/keys.py. */
const computeFingerprint = (vector: readonly number[]): number =>
  Math.abs(vector.reduce((sum, component, i) => sum + computeFingerprintWeight(i) * component, 0)) /
  Math.hypot(...vector);

/** Judge a numeric vector. Unit vectors in its direction and in the correct one may differ by `tolerance` in length. */
function judgeNumericVector(
  entries: readonly Node[],
  names: ReadonlySet<string>,
  key: ValuesKey,
  tolerance: number,
): Verdict {
  if (names.size > 0) return wrong("read.numbers", { names: listNames(names) });
  const components = entries.map((entry) => evaluate(entry, {}));
  const expected = key.right.map(([correctValue]) => correctValue ?? NaN);
  const isReal = components.every(
    ({ re, im }) => Number.isFinite(re) && Math.abs(im) <= ZERO_TOLERANCE * Math.hypot(re, im),
  );
  const length = Math.hypot(...components.map(({ re }) => re));
  if (isReal && length === 0) return wrong("verdict.zero-vector");
  const unitVector = components.map(({ re }) => re / length);
  if (isReal && compareDirections(unitVector, expected) <= tolerance) return correct(message("verdict.direction"));
  // in a plane, many directions are near that of some mistake
  const mistakes = isReal && unitVector.length > 2 ? key.mistakes : [];
  const mistake = findMistakeIndex(
    mistakes,
    (mistakenVector) => compareDirections(unitVector, mistakenVector) <= tolerance,
  );
  return reportDifference(names, getConfiguration(key, 0), mistake);
}

/** Return the verdict that a direction differs at a configuration, with the values of the names in the answer. */
function reportDifference(
  names: ReadonlySet<string>,
  configuration: SymbolValues,
  mistake: number | undefined,
): Verdict {
  const usedSymbols = [...names].filter((name) => name in configuration).sort();
  const values = Object.fromEntries(usedSymbols.map((symbol) => [symbol, configuration[symbol] as number]));
  if (usedSymbols.length === 0) return { ...wrong("verdict.other-direction"), mistake };
  const reason = message("verdict.not-along", { at: writeConfiguration(values) });
  return verdictOf(0, [reason], { counterexample: values, mistake });
}

/** Return the distance of a vector's head from the line through the origin along another vector. */
function computeDistanceFromLine(vector: readonly number[], line: readonly number[]): number {
  const factor = dot(vector, line) / dot(line, line); // the vector's projection onto the line is `factor` times `line`
  return Math.hypot(...vector.map((component, i) => component - factor * (line[i] as number)));
}

/** Return the distance of a unit vector from the unit vector along `expected`, or from its negative if that is less. */
function compareDirections(unitVector: readonly number[], expected: readonly number[]): number {
  const length = Math.hypot(...expected);
  const distanceWithSign = (sign: 1 | -1) =>
    Math.hypot(...unitVector.map((component, i) => component - (sign * (expected[i] as number)) / length));
  return Math.min(distanceWithSign(1), distanceWithSign(-1));
}
