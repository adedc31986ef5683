// Judge numbers with units, and vectors whose length does not matter.

import { dot } from "../arm/vector.js";
import type { NumbersKey, ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { kindOfUnit, unitsOfNumbers } from "../read/notation.js";
import { numbersText, tableText } from "../read/tables.js";
import { hasBlank, namesIn, type Node } from "../read/tree.js";
import { message } from "../text/text.js";
import { shareButForFactor, shareOfEntries } from "./credit.js";
import { EXACT, slipsInNumbers } from "./number-slips.js";
import { correct, verdictOf, parseOrVerdict, missing, type Verdict, wrong } from "./verdict.js";
import { entriesOf, labelOf, parseAs } from "./forms.js";
import { agreement, atText, configuration, unknownSymbols, weight } from "./values.js";

const NO_SYMBOLS: ReadonlySet<string> = new Set();
const TOLERANCE = 1e-9;
/** A component below this share of a number is a rounding error. */
const ZERO_TOLERANCE = 1e-12;

/** Judge numbers, which are right within the key's tolerance. */
export function judgeNumbers(answer: string, key: NumbersKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const unit = wrongUnit(answer, labels, key.units);
  if (unit) return unit;
  const count = key.right.length;
  const rows = parseAs(
    (typed) => entriesOf(parse(typed, NO_SYMBOLS), { rows: count, columns: 1 }, NO_SYMBOLS, labels),
    count === 1 ? withPoints(answer) : answer,
    () => numbersText(answer, count),
  );
  return "outcome" in rows ? rows : parseOrVerdict(() => judgeEntries(rows.flat(), key, answer));
}

/** Return the verdict on a unit that can't be right, such as a length for an angle; null if all units can be right. */
function wrongUnit(text: string, labels: readonly string[], units: readonly string[]): Verdict | null {
  const inner = text.trim().replace(/^[[\](){}]+|[[\](){}]+$/g, "");
  const separator = [";", "\n"].find((sign) => inner.includes(sign)) ?? ",";
  const separatorsIn = (part: string): number => part.split(separator).length - 1;
  const names = labels.map(labelOf);
  for (const { name, unit, start } of unitsOfNumbers(inner)) {
    const itemsOfSet = separatorsIn(inner) + 1 === units.length ? separatorsIn(inner.slice(0, start)) : -1;
    const place = names.includes(labelOf(name)) ? names.indexOf(labelOf(name)) : itemsOfSet;
    const expected = place < 0 ? units : units.slice(place, place + 1);
    const kinds = new Set(expected.map(kindOfUnit));
    const kind = kindOfUnit(unit);
    if (expected.length === 0 || kinds.has("") || kind === "" || kinds.has(kind)) continue;
    return place >= 0 && units.length > 1
      ? wrong("read.unit-of-entry", { unit, entry: place + 1, due: expected[0] as string })
      : wrong("read.unit", { unit, due: expected[0] as string });
  }
  return null;
}

function judgeEntries(entries: readonly Node[], key: NumbersKey, text: string): Verdict {
  const symbols = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  if (symbols.size > 0) return wrong("read.numbers", { names: [...symbols].sort().slice(0, 5).join(", ") });
  const values = entries.map((entry) => (hasBlank(entry) ? NaN : real(entry)));
  const near = (value: number, expected: number) =>
    Math.abs(value - expected) <= Math.max(key.tolerance * Math.abs(expected), key.floor);
  const right = values.map((value, i) => near(value, key.right[i] as number));
  if (right.every(Boolean))
    return correct(key.tolerance < EXACT ? undefined : message("verdict.numbers", { percent: 100 * key.tolerance }));
  const first = right.indexOf(false);
  const reason = message("verdict.number", {
    index: first + 1,
    yours: Number.isFinite(values[first]) ? (values[first] as number) : "—",
    expected: Number((key.right[first] as number).toPrecision(4)),
  });
  const zeros = key.right.map((expected) => Math.abs(expected) <= key.floor);
  const isRightUpToSigns =
    right.length > 1 &&
    !zeros.every(Boolean) &&
    key.units.every(Boolean) &&
    values.every((value, i) => near(value, key.right[i] as number) || near(-value, key.right[i] as number));
  const byEntries = shareOfEntries(right, zeros, entries.map(hasBlank));
  const share = isRightUpToSigns ? Math.max(byEntries, shareButForFactor(1)) : byEntries;
  return verdictOf(share, isRightUpToSigns ? [message("verdict.but-signs"), reason] : [reason], {
    entries: right.map((ok) => [ok]),
    ...slipsInNumbers(values, right, key, text),
  });
}

function real(entry: Node): number {
  const { re, im, size } = evaluate(entry, {});
  return Math.abs(im) <= TOLERANCE * size ? re : NaN;
}

/** Judge a vector that is right if it is the reference times any nonzero factor. */
export function judgeDirection(answer: string, key: ValuesKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const known = new Set(key.symbols);
  const entriesIn = (text: string) => entriesOf(parse(text, known), key, known, labels);
  const rows = parseAs(entriesIn, answer, () => tableText(answer, key.rows, 1));
  if ("outcome" in rows) return rows;
  return rows.flat().some(hasBlank) ? missing() : parseOrVerdict(() => judgeVector(rows.flat(), key));
}

function judgeVector(entries: readonly Node[], key: ValuesKey): Verdict {
  const names = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  if (typeof key.tolerance === "number") return judgeNumericVector(entries, names, key, key.tolerance);
  const vectorValues = key.points.map((_, k) => {
    const at = configuration(key, k, names);
    return entries.map((entry) => evaluate(entry, at));
  });
  if (vectorValues.every((values) => values.every(({ re, im, size }) => Math.hypot(re, im) <= ZERO_TOLERANCE * size)))
    return wrong("verdict.zero-vector");
  const wrongPoint = vectorValues.findIndex((values, k) => {
    const expected = key.right.map((values) => values[k] ?? NaN);
    const room = TOLERANCE * Math.max(...values.map(({ size }) => size));
    if (!Number.isFinite(room)) return true;
    const isAlong = (part: "re" | "im") =>
      distanceFromLine(
        values.map((value) => value[part]),
        expected,
      ) <= room;
    return !isAlong("re") || !isAlong("im");
  });
  if (wrongPoint < 0) return agreement(entries, message("verdict.direction"), vectorValues);
  const unknown = unknownSymbols(names, key);
  if (unknown) return verdictOf(0, [unknown]);
  const vectors = vectorValues.map((values) => values.map(({ re, im }) => (im === 0 ? re : NaN)));
  const mistake = key.mistakes.find(([, ...prints]) =>
    prints.every(
      (print, k) =>
        Math.abs(fingerprintOf(vectors[k] ?? []) - print) <= FINGERPRINT_TOLERANCE * Math.max(print, MIN_FINGERPRINT),
    ),
  );
  return withMistake(differenceAt(names, configuration(key, wrongPoint, new Set())), mistake);
}

/** Relative tolerance for the fingerprint of a direction, stored with six digits; smaller ones count as this number. */
const FINGERPRINT_TOLERANCE = 1e-5;
const MIN_FINGERPRINT = 0.1;

/** Return a fingerprint of a direction, independent of its length, as in ../../../exercises/site/keys.py. */
const fingerprintOf = (vector: readonly number[]): number =>
  Math.abs(vector.reduce((sum, component, i) => sum + weight(i) * component, 0)) / Math.hypot(...vector);

const withMistake = (verdict: Verdict, mistake: readonly number[] | undefined): Verdict =>
  mistake ? { ...verdict, mistake: mistake[0] as number } : verdict;

/** Judge a numeric vector, whose direction may deviate by `tolerance`. */
function judgeNumericVector(
  entries: readonly Node[],
  names: ReadonlySet<string>,
  key: ValuesKey,
  tolerance: number,
): Verdict {
  if (names.size > 0) return wrong("read.numbers", { names: [...names].sort().slice(0, 5).join(", ") });
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
  return withMistake(differenceAt(names, configuration(key, 0, new Set())), mistake);
}

/** Return the verdict that a direction differs at a configuration. */
function differenceAt(names: ReadonlySet<string>, at: Readonly<Record<string, number>>): Verdict {
  const used = [...names].filter((symbol) => symbol in at).sort();
  const values = Object.fromEntries(used.map((symbol) => [symbol, at[symbol] as number]));
  if (used.length === 0) return wrong("verdict.other-direction");
  return verdictOf(0, [message("verdict.not-along", { at: atText(values) })], { at: values });
}

/** Return the distance of a vector's head from the line along another vector. */
function distanceFromLine(v: readonly number[], line: readonly number[]): number {
  const share = dot(v, line) / dot(line, line);
  return Math.hypot(...v.map((x, i) => x - share * (line[i] as number)));
}

/** Return the distance between two unit vectors, or between one and the negative of the other if that is less. */
function directionDifference(unit: readonly number[], expected: readonly number[]): number {
  const length = Math.hypot(...expected);
  const distanceFrom = (sign: number) =>
    Math.hypot(...unit.map((x, i) => x - (sign * (expected[i] as number)) / length));
  return Math.min(distanceFrom(1), distanceFrom(-1));
}
