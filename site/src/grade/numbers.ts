// Judge numbers with units, and vectors whose length does not matter.

import { dot } from "../arm/vector.js";
import type { KnownMistake, NumbersKey, ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { readCommasAsPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { numbersText, tableText } from "../read/tables.js";
import { hasBlank, namesIn, type Node, type SymbolValues } from "../read/tree.js";
import { parseUnit, unitsOfNumbers, withoutUnitsOfNumbers, withPlainUnits } from "../read/units.js";
import { message } from "../text/text.js";
import { shareUpToDeviations, shareOfEntries } from "./credit.js";
import { EXACT_TOLERANCE, slipsInNumbers } from "./number-slips.js";
import { correct, listNames, missing, parseOrVerdict, verdictOf, wrong } from "./verdict.js";
import type { Verdict } from "./verdict.js";
import { entriesOf, labelOf, parseRowsOrTable } from "./forms.js";
import { configurationOf, configurationText, findUnknownSymbols, fingerprintWeight } from "./values.js";
import { verdictOnAgreement } from "./values.js";

const NO_SYMBOLS: ReadonlySet<string> = new Set();
const TOLERANCE = 1e-9;
/** A component below this share of a number is a rounding error. */
const ZERO_TOLERANCE = 1e-12;

/** Judge numbers, which are right within the key's tolerance. */
export function judgeNumbers(answer: string, key: NumbersKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const typedNumbers = withPlainUnits(answer);
  const unitVerdict = findWrongUnit(typedNumbers, labels, key.units);
  if (unitVerdict) return unitVerdict;
  const numbers = withoutUnitsOfNumbers(typedNumbers);
  const count = key.right.length;
  const rows = parseRowsOrTable(
    (typed) => entriesOf(parse(typed, NO_SYMBOLS), { rows: count, columns: 1 }, NO_SYMBOLS, labels),
    count === 1 ? readCommasAsPoints(numbers) : numbers,
    () => numbersText(numbers, count),
  );
  return "outcome" in rows ? rows : parseOrVerdict(() => judgeEntries(rows.flat(), key, answer));
}

/** Return the verdict on a unit of another dimension than the expected one; null if all units can be right. */
function findWrongUnit(text: string, labels: readonly string[], units: readonly string[]): Verdict | null {
  const inner = text.trim();
  const separator = [";", "\n"].find((candidate) => inner.includes(candidate)) ?? ",";
  const separatorsIn = (part: string): number => part.split(separator).length - 1;
  const names = labels.map(labelOf);
  for (const { name, unit, end } of unitsOfNumbers(inner)) {
    const isInList = separatorsIn(inner) + 1 === units.length && !"]}".includes(inner[end - 1] as string);
    const indexInList = isInList ? separatorsIn(inner.slice(0, end)) : -1;
    const index = names.includes(labelOf(name)) ? names.indexOf(labelOf(name)) : indexInList;
    const expectedUnits = index < 0 ? units : units.slice(index, index + 1);
    const dimensions = expectedUnits.map((expected) => (expected ? parseUnit(expected)?.dimension.join() : undefined));
    const dimension = parseUnit(unit)?.dimension.join();
    if (!dimension || dimensions.length === 0 || dimensions.includes(undefined) || dimensions.includes(dimension))
      continue;
    return index >= 0 && units.length > 1
      ? wrong("read.unit-of-entry", { unit, entry: index + 1, due: expectedUnits[0] as string })
      : wrong("read.unit", { unit, due: expectedUnits[0] as string });
  }
  return null;
}

function judgeEntries(entries: readonly Node[], key: NumbersKey, text: string): Verdict {
  const symbols = namesIn(...entries);
  if (symbols.size > 0) return wrong("read.numbers", { names: listNames(symbols) });
  const values = entries.map((entry) => (hasBlank(entry) ? NaN : realOrNaN(entry)));
  const isNear = (value: number, expected: number) =>
    Math.abs(value - expected) <= Math.max(key.tolerance * Math.abs(expected), key.floor);
  const isRight = values.map((value, i) => isNear(value, key.right[i] as number));
  if (isRight.every(Boolean))
    return correct(
      key.tolerance < EXACT_TOLERANCE ? undefined : message("verdict.numbers", { percent: 100 * key.tolerance }),
    );
  const firstWrong = isRight.indexOf(false);
  const reason = message("verdict.number", {
    index: firstWrong + 1,
    yours: Number.isFinite(values[firstWrong]) ? (values[firstWrong] as number) : "—",
    expected: Number((key.right[firstWrong] as number).toPrecision(4)),
  });
  const isZero = key.right.map((expected) => Math.abs(expected) <= key.floor);
  const isRightUpToSigns =
    isRight.length > 1 &&
    !isZero.every(Boolean) &&
    key.units.every(Boolean) &&
    values.every((value, i) => isNear(value, key.right[i] as number) || isNear(-value, key.right[i] as number));
  const shareByEntries = shareOfEntries(isRight, isZero, entries.map(hasBlank));
  const share = isRightUpToSigns ? Math.max(shareByEntries, shareUpToDeviations(1)) : shareByEntries;
  return verdictOf(share, isRightUpToSigns ? [message("verdict.but-signs"), reason] : [reason], {
    entries: isRight.map((ok) => [ok]),
    ...slipsInNumbers(values, isRight, key, text),
  });
}

function realOrNaN(entry: Node): number {
  const { re, im, size } = evaluate(entry, {});
  return Math.abs(im) <= TOLERANCE * size ? re : NaN;
}

/** Judge a vector that is right if it is the reference times any nonzero factor. */
export function judgeDirection(answer: string, key: ValuesKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const symbols = new Set(key.symbols);
  const entriesIn = (text: string) => entriesOf(parse(text, symbols), key, symbols, labels);
  const rows = parseRowsOrTable(entriesIn, answer, () => tableText(answer, key.rows, 1));
  if ("outcome" in rows) return rows;
  return rows.flat().some(hasBlank) ? missing() : parseOrVerdict(() => judgeVector(rows.flat(), key));
}

function judgeVector(entries: readonly Node[], key: ValuesKey): Verdict {
  const names = namesIn(...entries);
  if (typeof key.tolerance === "number") return judgeNumericVector(entries, names, key, key.tolerance);
  const vectorValues = key.points.map((_, k) => {
    const values = configurationOf(key, k, names);
    return entries.map((entry) => evaluate(entry, values));
  });
  if (vectorValues.every((values) => values.every(({ re, im, size }) => Math.hypot(re, im) <= ZERO_TOLERANCE * size)))
    return wrong("verdict.zero-vector");
  const wrongPoint = vectorValues.findIndex((values, k) => {
    const expected = key.right.map((values) => values[k] ?? NaN);
    const tolerance = TOLERANCE * Math.max(...values.map(({ size }) => size));
    if (!Number.isFinite(tolerance)) return true;
    const parts = (["re", "im"] as const).map((part) => values.map((value) => value[part]));
    return parts.some((vector) => distanceFromLine(vector, expected) > tolerance);
  });
  if (wrongPoint < 0) return verdictOnAgreement(entries, message("verdict.direction"), vectorValues);
  const unknown = findUnknownSymbols(names, key);
  if (unknown) return verdictOf(0, [unknown]);
  const vectors = vectorValues.map((values) => values.map(({ re, im }) => (im === 0 ? re : NaN)));
  const mistake = key.mistakes.find(([, ...fingerprints]) =>
    fingerprints.every(
      (fingerprint, k) =>
        Math.abs(fingerprintOf(vectors[k] ?? []) - fingerprint) <=
        FINGERPRINT_TOLERANCE * Math.max(fingerprint, MIN_FINGERPRINT),
    ),
  );
  return reportDifference(names, configurationOf(key, wrongPoint, new Set()), mistake);
}

/** Relative tolerance for a direction's fingerprint, which has six digits; as if it were at least MIN_FINGERPRINT. */
const FINGERPRINT_TOLERANCE = 1e-5;
const MIN_FINGERPRINT = 0.1;

/** Return a fingerprint of a direction, independent of its length, as in ../../../exercises/site/keys.py. */
const fingerprintOf = (vector: readonly number[]): number =>
  Math.abs(vector.reduce((sum, component, i) => sum + fingerprintWeight(i) * component, 0)) / Math.hypot(...vector);

/** Judge a numeric vector, whose direction may deviate by `tolerance`. */
function judgeNumericVector(
  entries: readonly Node[],
  names: ReadonlySet<string>,
  key: ValuesKey,
  tolerance: number,
): Verdict {
  if (names.size > 0) return wrong("read.numbers", { names: listNames(names) });
  const values = entries.map((entry) => evaluate(entry, {}));
  const expected = key.right.map((values) => values[0] ?? NaN);
  const isReal = values.every(
    ({ re, im }) => Number.isFinite(re) && Math.abs(im) <= ZERO_TOLERANCE * Math.hypot(re, im),
  );
  const size = Math.hypot(...values.map(({ re }) => re));
  if (isReal && size === 0) return wrong("verdict.zero-vector");
  const unit = values.map(({ re }) => re / size);
  if (isReal && directionDifference(unit, expected) <= tolerance) return correct(message("verdict.direction"));
  // in a plane, many directions are near that of some mistake
  const mistakes = isReal && unit.length > 2 ? key.mistakes : [];
  const mistake = mistakes.find(([, ...mistaken]) => directionDifference(unit, mistaken) <= tolerance);
  return reportDifference(names, configurationOf(key, 0, new Set()), mistake);
}

/** Return the verdict that a direction differs at a configuration, with the values of the names in the answer. */
function reportDifference(
  names: ReadonlySet<string>,
  configuration: SymbolValues,
  [mistake]: KnownMistake = [],
): Verdict {
  const used = [...names].filter((symbol) => symbol in configuration).sort();
  const values = Object.fromEntries(used.map((symbol) => [symbol, configuration[symbol] as number]));
  if (used.length === 0) return { ...wrong("verdict.other-direction"), mistake };
  const reason = message("verdict.not-along", { at: configurationText(values) });
  return verdictOf(0, [reason], { counterexample: values, mistake });
}

/** Return the distance of a vector's head from the line through the origin along another vector. */
function distanceFromLine(v: readonly number[], line: readonly number[]): number {
  const projection = dot(v, line) / dot(line, line);
  return Math.hypot(...v.map((x, i) => x - projection * (line[i] as number)));
}

/** Return the distance between two unit vectors, or between one and the negative of the other if that is less. */
function directionDifference(vector: readonly number[], expected: readonly number[]): number {
  const length = Math.hypot(...expected);
  const distanceFrom = (sign: number) =>
    Math.hypot(...vector.map((x, i) => x - (sign * (expected[i] as number)) / length));
  return Math.min(distanceFrom(1), distanceFrom(-1));
}
