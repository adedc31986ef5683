// Judge formulas by their values at the configurations of a key.

import { findMistakeIndex, type ValuesKey } from "../bank.js";
import { evaluate, type Value } from "../read/evaluate.js";
import { readCommasAsPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { convertTable } from "../read/tables.js";
import type { Node, Rows, SymbolValues } from "../read/tree.js";
import {
  anyNode,
  transposeRows,
  countDigitsOfDecimals,
  hasBlank,
  isConstant,
  findNames,
  locateEntry,
  visitNodes,
} from "../read/tree.js";
import { UNITS } from "../read/vocabulary.js";
import { formatNumber, message, type Message, numberSeparator, say, type TextKey, withGreek } from "../text/text.js";
import { computeShareForDeviations, computeShareOfEntries } from "./credit.js";
import { extractEntries, isBlank, buildMatrix, findOtherComponent } from "./forms.js";
import { parseRowsOrTable, requireScalars, takeRightSide, checkShape } from "./forms.js";
import { findSlips } from "./slips.js";
import { correct, isVerdict, listNames, missing, parseOrVerdict, type Verdict, verdictOf, wrong } from "./verdict.js";

/** Tolerance for rounding errors, relative to the size of the terms (`Value.size`), or to the expected value. */
const FORMULA_TOLERANCE = 1e-9;
/** Tolerance for the fingerprint of a mistake, relative to the fingerprint, which is stored with six digits. */
const FINGERPRINT_TOLERANCE = 2e-5;
/** Mistakes have fingerprints at most at this many configurations, the first ones of the key. */
const FINGERPRINT_COUNT = 3;
/** A mistake in some entries counts only if it changes the fingerprint by this many times the tolerance. */
const MIN_CHANGE_IN_TOLERANCES = 100;
/** If terms are at most this many times as large as the entry, rounding errors are far below the entry. */
const MAX_CANCELLATION = 1e4;
/** A larger value is infinite up to rounding errors. */
const MIN_INFINITE = 1e12;
/** Multiples of this number modulo 1 are spread evenly over the interval from 0 to 1. */
const GOLDEN_RATIO = 0.6180339887498949;
/** Functions with branches: two formulas with them may be equal in one region and differ in another. */
const BRANCHING = new Set(["sqrt", "abs", "sign", "asin", "acos", "atan", "acot", "atan2", "log"]);

type Names = readonly string[];
type Mistakes = ValuesKey["mistakes"];
/** The values of an answer's entries at a configuration; null for a blank. */
type EntryValues = readonly (Value | null)[];
/** Returns these values at configuration k (from 0). */
type ValuesAt = (k: number) => EntryValues;

/** Judge a formula, vector or matrix; `labels` name the entries of a vector. */
export function judgeValues(answer: string, key: ValuesKey, labels: Names = [], columnNames: Names = []): Verdict {
  const rowsOrVerdict = readFormulas(answer, key, labels, columnNames);
  if (!isVerdict(rowsOrVerdict)) return parseOrVerdict(() => judgeEntries(rowsOrVerdict, key));
  if (rowsOrVerdict.reasons[0]?.key !== "read.shape") return rowsOrVerdict;
  return parseOrVerdict(() => {
    const symbols = new Set(key.symbols);
    const rows = buildMatrix(parse(answer, symbols), symbols, labels, key, columnNames);
    return isTransposed(rows, key) ? judgeTransposed(rows, key) : rowsOrVerdict;
  });
}

/** The form of an answer of formulas, without the correct values. */
export type FormulaForm = Pick<ValuesKey, "symbols" | "rows" | "columns">;

/** Return the entries of a formula, vector or matrix, or the verdict on an answer without such entries. */
export function readFormulas(
  answer: string,
  form: FormulaForm,
  labels: Names = [],
  columnNames: Names = [],
): Rows | Verdict {
  if (!answer.trim()) return missing();
  const symbols = new Set(form.symbols);
  if (form.rows * form.columns === 1) return parseOrVerdict(() => parseFormula(answer, symbols, labels));
  return parseRowsOrTable(
    (text) => extractEntries(parse(text, symbols), form, symbols, labels, columnNames),
    answer,
    () => convertTable(answer, form.rows, form.columns),
  );
}

/** Parse an answer of one entry; if a decimal comma makes it a list, as in 0,5, commas are read as points. */
function parseFormula(answer: string, symbols: ReadonlySet<string>, labels: readonly string[]): Rows | Verdict {
  const typed = parse(removeCapitalName(answer, symbols), symbols);
  if (isBlank(typed)) return missing();
  const otherName = findOtherComponent(typed, labels);
  if (otherName) return wrong("read.component", { other: otherName, asked: labels[0] as string });
  const tree = takeRightSide(unwrapOnlyEntry(takeRightSide(typed, symbols, labels)), symbols, labels);
  const withDecimalPoints = readCommasAsPoints(answer);
  if (tree.kind === "list" && withDecimalPoints !== answer)
    return parseOrVerdict(() => parseFormula(withDecimalPoints, symbols, labels));
  return ["list", "set", "dict"].includes(tree.kind) ? wrong("read.list") : requireScalars([[tree]]);
}

/** Return the text after the name in "M = m*a1"; the parser takes M for the mass m if this is a symbol. */
function removeCapitalName(answer: string, symbols: ReadonlySet<string>): string {
  const [, name = "", value = ""] = /^\s*([A-Z]\w*)\s*:?=([^=]+)$/.exec(answer) ?? [];
  return !symbols.has(name) && symbols.has(name.toLowerCase()) ? value : answer;
}

/** Return the entry of Matrix([a]), [a] or [[a]]: a matrix of one entry is read as this entry. */
function unwrapOnlyEntry(tree: Node): Node {
  const [only] = tree.args;
  return tree.kind === "list" && tree.args.length === 1 && only ? unwrapOnlyEntry(only) : tree;
}

/** Return whether a matrix has the expected shape when transposed. */
function isTransposed(rows: Rows, key: ValuesKey): boolean {
  const columns = rows[0]?.length ?? 0;
  const isSwapped = rows.length === key.columns && columns === key.rows && key.rows !== key.columns;
  return isSwapped && Math.min(key.rows, key.columns) > 1;
}

/** Return the verdict on a transposed matrix; it says whether the transposition is the only mistake. */
function judgeTransposed(rows: Node[][], key: ValuesKey): Verdict {
  const isRight = judgeEntries(requireScalars(transposeRows(rows)), key).outcome === "correct";
  const slip = message(isRight ? "slip.transposed" : "slip.turned");
  return { ...(checkShape(rows, key) as Verdict), slips: [slip] };
}

function judgeEntries(rows: readonly (readonly Node[])[], key: ValuesKey): Verdict {
  if (key.points.length === 0) throw new Error("a key without configurations"); // else every answer would be right
  const entries = rows.flat();
  const blankFlags = entries.map(hasBlank);
  const names = findNames(...entries);
  const valuesByPoint: EntryValues[] = [];
  // a wrong answer differs at one of the first configurations, so later values are computed only when needed
  const configurationAt = (k: number) => getConfiguration(key, k, names);
  const evaluateEntries = (configuration: SymbolValues) =>
    entries.map((entry, i) => (blankFlags[i] ? null : evaluate(entry, configuration)));
  const valuesAt = (k: number) => (valuesByPoint[k] ??= evaluateEntries(configurationAt(k)));
  const expectedAt = (i: number, k: number) => key.right[i]?.[k] ?? null;
  const scales = key.right.map((correctValues) => Math.max(...correctValues.map((value) => Math.abs(value ?? 0))));
  const largestScale = Math.max(...scales);
  const firstDifferences = entries.map((_, i) =>
    key.points.findIndex((_point, k) => !isExpected(valuesAt(k)[i] ?? null, expectedAt(i, k))),
  );
  if (firstDifferences.every((k) => k < 0))
    return correctOrUnsure(
      entries,
      message("verdict.values", { points: key.points.length }),
      Array.from(key.points.keys(), valuesAt),
    );
  const rightFlags = firstDifferences.map((k) => k < 0);
  const zeroFlags = scales.map((scale) => scale === 0 && largestScale > 0);
  const deviation = blankFlags.some(Boolean) ? null : findDeviation(valuesAt, key, zeroFlags, rightFlags);
  const movingEntries = key.moving ?? [];
  const areMovingEntriesWrong = movingEntries.length > 0 && !movingEntries.some((i) => rightFlags[i]);
  const shareByEntries =
    rightFlags.length === 1 || areMovingEntriesWrong ? 0 : computeShareOfEntries(rightFlags, zeroFlags, blankFlags);
  const share = Math.max(shareByEntries, deviation === null ? 0 : computeShareForDeviations(deviation.count));
  const rightFlagsByRow = rows.map((row, r) => row.map((_, c) => rightFlags[r * row.length + c] as boolean));
  const firstWrong = firstDifferences.findIndex((k) => k >= 0);
  const firstPoint = firstDifferences[firstWrong] as number;
  const unknownMessage = findUnknownSymbols(names, key);
  const reason =
    unknownMessage ??
    describeDifference(entries, firstWrong, valuesAt(firstPoint)[firstWrong] ?? null, key, firstPoint);
  const mistake = findMistake(valuesAt, key.mistakes, key);
  const isRight = (i: number, entry: Node) =>
    key.points.every((_, k) => isExpected(evaluate(entry, configurationAt(k)), expectedAt(i, k)));
  const wrongIndices = firstDifferences.flatMap((k, i) => (k >= 0 && !blankFlags[i] ? [i] : []));
  const findMistakeIn = (places: ReadonlySet<number>) => findMistake(valuesAt, key.mistakes, key, places);
  const isUnexplained = mistake === undefined && wrongIndices.length > 0;
  const explanation = isUnexplained
    ? findSlips({ entries, wrongIndices, configurationAt, isRight, findMistakeIn }, key)
    : null;
  // the same mistake everywhere may look like several slips
  const finalMistake =
    explanation && !explanation.explainsAll ? findMistake(valuesAt, key.throughout ?? [], key) : mistake;
  const slips = finalMistake === undefined && explanation?.slips.length ? explanation.slips : undefined;
  const deviationMessages = deviation === null ? [] : [message(deviation.key)];
  const countMessages = unknownMessage && !rightFlags.some(Boolean) ? [] : countRightEntries(rightFlags, zeroFlags);
  return verdictOf(share, [...deviationMessages, ...countMessages, reason], {
    entries: rightFlagsByRow,
    counterexample: getConfiguration(key, firstPoint),
    mistake: finalMistake,
    slips,
  });
}

/** Return whether a value is the expected one; null is expected if the entry is undefined at the configuration. */
function isExpected(value: Value | null, expected: number | null): boolean {
  if (!value) return false;
  if (expected === null) return !isFinite(value.re) || Math.abs(value.re) > MIN_INFINITE;
  const tolerance = FORMULA_TOLERANCE * Math.max(value.size, Math.abs(expected), 1e-300);
  return (
    Number.isFinite(value.re) && Number.isFinite(value.im) && Math.hypot(value.re - expected, value.im) <= tolerance
  );
}

/** Return the verdict on entries that are right at all configurations; it is unsure if these may hide a difference. */
export function correctOrUnsure(
  entries: readonly Node[],
  sureReason: Message,
  values: readonly EntryValues[],
): Verdict {
  const points = values.length;
  const functions = new Set<string>();
  for (const entry of entries) visitNodes(entry, ({ text }) => BRANCHING.has(text) && functions.add(text));
  const digits = Math.max(...entries.map(countDigitsOfDecimals));
  if (digits > 8 && digits < 16) return correct(message("verdict.decimals", { points, digits }), false);
  const hidingNumber = entries.map(findExtremeNumber).find((number) => number !== null) ?? findCancellationSize(values);
  if (hidingNumber) return correct(message("verdict.out-of-sight", { points, number: hidingNumber }), false);
  if (functions.size === 0) return correct(sureReason);
  return correct(message("verdict.branches", { points, functions: [...functions].sort().join(", ") }), false);
}

/** Return a number or power so small or large that nine digits can't distinguish it from zero or infinity; or null. */
function findExtremeNumber(tree: Node): string | null {
  let text: string | null = null;
  anyNode(tree, (node) => {
    const isNumber = node.kind === "number" || node.kind === "decimal";
    if (!isNumber && !(node.kind === "^" && isConstant(node))) return false;
    const { size } = evaluate(node, {});
    const isZero = isNumber ? !/[1-9]/.test(node.text) : size === 0;
    if (!isZero && !(size >= 1e-6 && size <= 1e6)) text = isNumber ? node.text : size.toExponential(0);
    return text !== null;
  });
  return text;
}

/** Return the size of an entry's terms if they cancel so far that rounding errors may hide a difference; else null. */
function findCancellationSize(values: readonly EntryValues[]): string | null {
  const maxByEntry = (sizeOf: (value: Value) => number) =>
    (values[0] ?? []).map((_, i) =>
      Math.max(...values.map((entryValues) => (entryValues[i] ? sizeOf(entryValues[i]) : 0))),
    );
  const magnitudes = maxByEntry(({ re, im }) => Math.hypot(re, im));
  const largestMagnitude = Math.max(...magnitudes) || 1;
  const hidingSize = maxByEntry(({ size }) => size).find(
    (size, i) => !(size <= MAX_CANCELLATION * Math.max(magnitudes[i] as number, largestMagnitude / 100)),
  );
  return hidingSize === undefined ? null : hidingSize.toExponential(0);
}

interface Deviation {
  /** 1 for wrong signs or a wrong constant factor, 2 for both. */
  readonly count: 1 | 2;
  /** The key of the message that reports the deviation. */
  readonly key: TextKey;
}

/** Return the deviation if all wrong entries are right up to signs, a constant factor, or both; else null. */
function findDeviation(
  valuesAt: ValuesAt,
  key: ValuesKey,
  zeroFlags: readonly boolean[],
  rightFlags: readonly boolean[],
): Deviation | null {
  const movingEntries = key.moving ?? [];
  const wrongIndices = rightFlags.flatMap((isRight, i) => (isRight ? [] : [i]));
  const isOneNumber = movingEntries.length === 0 && zeroFlags.filter((isZero) => !isZero).length === 1;
  if (isOneNumber || wrongIndices.some((i) => zeroFlags[i])) return null;
  const ratios: number[] = []; // of typed to expected values, at each configuration
  let ratioSigns: readonly number[] = []; // of the wrong entries, at the first configuration
  for (let k = 0; k < key.points.length; k += 1) {
    const values = valuesAt(k);
    const signedRatios = wrongIndices.map((i) =>
      values[i]?.im === 0 ? values[i].re / (key.right[i]?.[k] ?? NaN) : NaN,
    );
    if (k === 0) ratioSigns = signedRatios.map(Math.sign);
    const magnitudes = signedRatios.map((ratio, j) => ratio * ratioSigns[j]!);
    const ratio = magnitudes[0] as number;
    if (!Number.isFinite(ratio) || !magnitudes.every((other) => isNear(other, ratio))) return null;
    ratios.push(ratio);
  }
  const constants = (key.constants ?? []).slice(0, MAX_CONSTANTS);
  const constantValues = key.points.map((point) => constants.map((name) => point[key.symbols.indexOf(name)] ?? NaN));
  for (const powers of listPowers(constants.length)) {
    const factors = ratios.map((ratio, k) =>
      powers.reduce((product, power, j) => product * (constantValues[k]?.[j] ?? NaN) ** power, ratio),
    );
    const [firstFactor] = factors as [number];
    if (!(Math.abs(firstFactor) > FORMULA_TOLERANCE) || !factors.every((factor) => isNear(factor, firstFactor)))
      continue;
    const hasFactor = powers.some((power) => power !== 0) || !isNear(firstFactor, 1);
    const hasWrongSign = ratioSigns.includes(-1);
    if (!hasWrongSign && !hasFactor) return null;
    // any number would be right up to a factor
    if (hasFactor && !wrongIndices.some((i) => movingEntries.includes(i))) return null;
    const hasSeveralEntries = rightFlags.length > 1;
    if (hasWrongSign && hasFactor)
      return { count: 2, key: hasSeveralEntries ? "verdict.but-signs-both" : "verdict.but-both" };
    if (!hasWrongSign) return { count: 1, key: "verdict.but-factor" };
    return { count: 1, key: hasSeveralEntries ? "verdict.but-signs" : "verdict.but-sign" };
  }
  return null;
}

/** At most this many lengths are tried as factors of a constant factor. */
const MAX_CONSTANTS = 5;
/** Powers of these lengths; `qdot grade` accepts any factor that no joint changes. */
const POWERS = [0, 1, -1, 0.5, -0.5];

const isNear = (a: number, b: number): boolean => Math.abs(a - b) <= FORMULA_TOLERANCE * Math.abs(b);

/** Return all combinations of such powers for some number of symbols. */
function listPowers(count: number): number[][] {
  return count === 0 ? [[]] : listPowers(count - 1).flatMap((rest) => POWERS.map((power) => [power, ...rest]));
}

/** Return a message on how many nonzero entries are right; an empty list if there is only one entry. */
function countRightEntries(rightFlags: readonly boolean[], zeroFlags: readonly boolean[]): Message[] {
  if (rightFlags.length === 1) return [];
  const nonzeroRightFlags = rightFlags.filter((_, i) => !zeroFlags[i]);
  const right = nonzeroRightFlags.filter(Boolean).length;
  return [message("verdict.entries", { right, count: nonzeroRightFlags.length })];
}

/** Return a message on the value of entry i, which differs from the expected one at configuration k. */
function describeDifference(
  entries: readonly Node[],
  i: number,
  value: Value | null,
  key: ValuesKey,
  k: number,
): Message {
  const place = locateEntry(i, key.columns);
  if (!value) return message("verdict.blank", place);
  const expected = key.right[i]?.[k] ?? null;
  const values = {
    at: writeConfiguration(listValuesForStudent(key, k, entries[i] as Node), key.symbols),
    yours: writeComplexNumber(value),
    expected: writeNumber(expected),
  };
  return entries.length === 1 ? message("verdict.differs", values) : message("verdict.entry", { ...place, ...values });
}

/** Return the index of the mistake that gives this answer, or its entries at `places` if all others are as expected. */
function findMistake(
  valuesAt: ValuesAt,
  mistakes: Mistakes,
  key: ValuesKey,
  places?: ReadonlySet<number>,
): number | undefined {
  const valuesAtPlaces = (k: number) =>
    valuesAt(k).map((value, i) => {
      if (places && !places.has(i)) return key.right[i]?.[k] ?? NaN;
      return value && value.im === 0 ? value.re : NaN;
    });
  const computeFingerprint = (values: readonly number[]) =>
    values.reduce((total, value, i) => total + computeFingerprintWeight(i) * value, 0);
  const fingerprints = key.points.slice(0, FINGERPRINT_COUNT).map((_, k) => computeFingerprint(valuesAtPlaces(k)));
  const changeOfFingerprint = (k: number) =>
    fingerprints[k]! - computeFingerprint(key.right.map((correctValues) => correctValues[k] ?? NaN));
  return findMistakeIndex(mistakes, (mistakenFingerprints) =>
    mistakenFingerprints.every((fingerprint, k) => {
      const tolerance = FINGERPRINT_TOLERANCE * Math.max(Math.abs(fingerprint), 1e-9);
      // a part must make a difference that is not lost in the other entries
      return (
        Math.abs((fingerprints[k] ?? NaN) - fingerprint) <= tolerance &&
        (!places || Math.abs(changeOfFingerprint(k)) > MIN_CHANGE_IN_TOLERANCES * tolerance)
      );
    }),
  );
}

/** Return the weight of an entry in the fingerprint of an answer, as in ../../../exercises/site/keys.py. */
export const computeFingerprintWeight = (index: number): number => 1 + ((index * GOLDEN_RATIO) % 1);

const NO_NAMES: ReadonlySet<string> = new Set();

/** Return the values of all symbols at configuration k, and an arbitrary number for each other name in an answer. */
export function getConfiguration(key: ValuesKey, k: number, names = NO_NAMES): SymbolValues {
  const values: Record<string, number> = {};
  for (const unknown of names) values[unknown] = makeArbitraryNumber(unknown, k);
  key.symbols.forEach((symbol, i) => (values[symbol] = key.points[k]?.[i] ?? NaN));
  return values;
}

/** Return a number from 0.3 to 1.7 that depends only on a name and on the index of a configuration. */
export function makeArbitraryNumber(name: string, k: number): number {
  const hash = [...name].reduce((sum, sign) => (sum * 31 + (sign.codePointAt(0) ?? 0)) % 9973, 7 + k);
  return 0.3 + ((hash * GOLDEN_RATIO) % 1.4);
}

/** Return the values with which a student can check an entry at configuration k. */
function listValuesForStudent(key: ValuesKey, k: number, entry: Node): SymbolValues {
  const usedNames = findNames(entry);
  const isMoving = [...usedNames].some(isRate);
  const relevantSymbols = key.symbols.filter(
    (symbol) =>
      isJoint(symbol) ||
      (key.constants ?? []).includes(symbol) ||
      usedNames.has(symbol) ||
      (key.mentioned ?? []).includes(symbol) ||
      (isMoving && isRate(symbol)),
  );
  return Object.fromEntries(
    relevantSymbols.map((symbol) => [symbol, key.points[k]?.[key.symbols.indexOf(symbol)] ?? NaN]),
  );
}

/** Return the values of a configuration as a text: θ1 = 30°, a1 = 0.5 m. `symbols` are all symbols of the problem. */
export function writeConfiguration(
  configuration: SymbolValues,
  symbols: readonly string[] = Object.keys(configuration),
): string {
  return Object.entries(configuration)
    .map(
      ([symbol, value]) =>
        `${withGreek(symbol)} = ${formatNumber(convertToSliderValue(symbol, value))}${unitOf(symbol, symbols)}`,
    )
    .join(numberSeparator());
}

/** Return a joint angle in degrees within a turn, as the page's sliders show it; other values unchanged. */
function convertToSliderValue(symbol: string, value: number): number {
  if (!isAngle(symbol)) return value;
  const degrees = (value * 180) / Math.PI;
  const shown = Number((degrees - 360 * Math.round(degrees / 360)).toFixed(1));
  return shown === -180 ? 180 : shown;
}

const isJoint = (symbol: string): boolean => /^(theta|d)\d/.test(symbol);
const isRate = (symbol: string): boolean => /^qd\d+$/.test(symbol);
const isAngle = (symbol: string): boolean => /^theta\d+$/.test(symbol);

const UNITS_OF_COMPONENTS: Readonly<Record<string, string>> = { v: " m/s", w: " rad/s", f: " N", m: " N m" };

/** Return the unit of a value, with the space before it; "" for a symbol of an instructor's own. */
function unitOf(symbol: string, symbols: readonly string[]): string {
  if (isAngle(symbol)) return "°";
  if (/^[ad]\d+$/.test(symbol)) return " m";
  const [, dots, joint] = /^q(dd?)(\d+)$/.exec(symbol) ?? [];
  if (joint) return ` ${symbols.includes(`theta${joint}`) ? "rad" : "m"}/s${dots === "dd" ? "²" : ""}`;
  return /^[vwfm][xyz]$/.test(symbol) ? (UNITS_OF_COMPONENTS[symbol.charAt(0)] ?? "") : "";
}

/** Return a message on names in an answer that are not symbols of the problem; null if there are none. */
export function findUnknownSymbols(
  names: ReadonlySet<string>,
  { symbols, constants, mentioned = [] }: Pick<ValuesKey, "symbols" | "constants" | "mentioned">,
): Message | null {
  const unknown = [...names].filter((name) => !symbols.includes(name));
  if (unknown.length === 0) return null;
  if (unknown.every((name) => UNITS.has(name))) return message("read.unit-left", { unit: unknown.sort()[0]! });
  // of rates, velocities and forces, list only those that the question mentions
  const isUsed = (symbol: string): boolean =>
    !constants || isJoint(symbol) || constants.includes(symbol) || mentioned.includes(symbol);
  const knownSymbols = symbols.filter(isUsed).join(", ");
  return message("read.unknown", { names: listNames(unknown), known: knownSymbols });
}

function writeNumber(value: number | null): string {
  return value === null || !isFinite(value) ? say("verdict.undefined") : formatNumber(value);
}

function writeComplexNumber({ re, im, size }: Value): string {
  if (!Number.isFinite(re) || !Number.isFinite(im)) return writeNumber(null);
  if (Math.abs(im) <= FORMULA_TOLERANCE * size) return writeNumber(re);
  return `${writeNumber(re)} ${im < 0 ? "−" : "+"} ${writeNumber(Math.abs(im))} i`;
}
