// Judge formulas by their values at the configurations of a key.

import type { ValuesKey } from "../bank.js";
import { evaluate, type Value } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { tableText } from "../read/tables.js";
import { anyNode, columnsOf, digitsOfDecimals, hasBlank, namesIn, type Node, type Rows } from "../read/tree.js";
import { table, VOCABULARY } from "../read/vocabulary.js";
import { inDigits, message, type Message, numberSeparator, say, type TextKey } from "../text/text.js";
import { shareButForFactor, shareOfEntries } from "./credit.js";
import { entriesOf, isBlank, matrixOf, ofScalars, otherComponent, parseAs, rightSide, withShape } from "./forms.js";
import { slipsIn } from "./slips.js";
import { type SymbolValues, correct, verdictOf, parseOrVerdict, missing, type Verdict, wrong } from "./verdict.js";

/** Relative tolerance for rounding, of the size of the terms. */
const TOLERANCE = 1e-9;
/** Relative tolerance for the fingerprint of a mistake, stored with six digits. */
const FINGERPRINT_TOLERANCE = 2e-5;
/** Mistakes have fingerprints at this many configurations or fewer. */
const FINGERPRINT_COUNT = 3;
/** How many times the tolerance a mistake in some entries must change the fingerprint. */
const NOTICEABLE = 100;
/** Terms may be this many times the entry: rounding errors are then still far below the entry. */
const MAX_CANCELLATION = 1e4;
const UNITS = table(VOCABULARY.units);
const GOLDEN_RATIO = 0.6180339887498949;
/** Functions with branches: two formulas with them may be equal in one region and differ in another. */
const BRANCHING = new Set(["sqrt", "abs", "sign", "asin", "acos", "atan", "acot", "atan2", "log"]);

type Names = readonly string[];
type Mistakes = ValuesKey["mistakes"];
/** The values of an answer's entries, null for a blank; and a function that returns them at point k of the key. */
type Values = readonly (Value | null)[];
type ValuesAt = (k: number) => Values;

/** Judge a formula, vector or matrix; `labels` name the entries of a vector. */
export function judgeValues(answer: string, key: ValuesKey, labels: Names = [], columnNames: Names = []): Verdict {
  if (!answer.trim()) return missing();
  const known = new Set(key.symbols);
  const answerRows =
    key.rows * key.columns === 1
      ? parseOrVerdict(() => parseFormula(answer, known, labels))
      : parseAs(
          (text) => {
            const tree = parse(text, known);
            const rows = isBlank(tree) ? null : matrixOf(tree, known, labels, key, columnNames);
            return rows && isTransposed(rows, key)
              ? judgeTransposed(rows, key)
              : entriesOf(tree, key, known, labels, columnNames);
          },
          answer,
          () => tableText(answer, key.rows, key.columns),
        );
  return "outcome" in answerRows ? answerRows : parseOrVerdict(() => compare(answerRows, key));
}

/** Return the only entry of an answer; if 0,5 makes a list of it, commas are read as points. */
function parseFormula(answer: string, known: ReadonlySet<string>, labels: readonly string[]): Rows | Verdict {
  const typed = parse(answer, known);
  if (isBlank(typed)) return missing();
  const other = otherComponent(typed, labels);
  if (other) return wrong("read.component", { other, asked: labels[0] as string });
  const tree = rightSide(onlyEntry(rightSide(typed, known, labels)), known, labels);
  const withDecimalPoints = withPoints(answer);
  if (tree.kind === "list" && withDecimalPoints !== answer)
    return parseOrVerdict(() => parseFormula(withDecimalPoints, known, labels));
  return ["list", "set", "dict"].includes(tree.kind) ? wrong("read.list") : [[tree]];
}

/** Return the entry of Matrix([a]), [a] or [[a]]: a matrix of one entry is read as this entry. */
function onlyEntry(tree: Node): Node {
  const [only] = tree.args;
  return tree.kind === "list" && tree.args.length === 1 && only ? onlyEntry(only) : tree;
}

/** Return whether a matrix has the expected shape when transposed. */
function isTransposed(rows: Rows, key: ValuesKey): boolean {
  const columns = rows[0]?.length ?? 0;
  const isSwapped = rows.length === key.columns && columns === key.rows && key.rows !== key.columns;
  return isSwapped && Math.min(key.rows, key.columns) > 1;
}

/** Return the verdict on such a matrix; it says whether only the transposition is wrong. */
function judgeTransposed(rows: Node[][], key: ValuesKey): Verdict {
  const isRight = compare(ofScalars(columnsOf(rows)), key).outcome === "correct";
  const slip = message(isRight ? "slip.transposed" : "slip.turned");
  return { ...(withShape(rows, key) as Verdict), slips: [slip] };
}

function compare(rows: readonly (readonly Node[])[], key: ValuesKey): Verdict {
  if (key.points.length === 0) throw new Error("a key without configurations"); // else every answer would be right
  const entries = rows.flat();
  const blank = entries.map(hasBlank);
  const names = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  const valuesByPoint: Values[] = [];
  // a wrong answer differs at one of the first configurations, so later values are computed only when needed
  const evaluateAt = (at: SymbolValues) => entries.map((entry, i) => (blank[i] ? null : evaluate(entry, at)));
  const valuesAt = (k: number) => (valuesByPoint[k] ??= evaluateAt(configuration(key, k, names)));
  const scales = key.right.map((values) => Math.max(...values.map((value) => Math.abs(value ?? 0))));
  const largest = Math.max(...scales);
  const differing = entries.map((_, i) =>
    key.points.findIndex((_point, k) => !same(valuesAt(k)[i] ?? null, key.right[i]?.[k] ?? null)),
  );
  if (differing.every((k) => k < 0))
    return agreement(
      entries,
      message("verdict.values", { points: key.points.length }),
      Array.from(key.points.keys(), valuesAt),
    );
  const rightEntries = differing.map((k) => k < 0);
  const zeros = scales.map((scale) => scale === 0 && largest > 0);
  const deviation = blank.some(Boolean) ? 0 : deviationOf(valuesAt, key, zeros, rightEntries);
  const moving = key.moving ?? [];
  const byEntries =
    rightEntries.length === 1 || (moving.length > 0 && !moving.some((i) => rightEntries[i]))
      ? 0
      : shareOfEntries(rightEntries, zeros, blank);
  const share = Math.max(byEntries, deviation === 0 ? 0 : shareButForFactor(deviation.count));
  const rowsOfRight = rows.map((row, r) => row.map((_, c) => rightEntries[r * row.length + c] as boolean));
  const firstWrong = differing.findIndex((k) => k >= 0);
  const firstPoint = differing[firstWrong] as number;
  const unknownNames = unknownSymbols(names, key);
  const reason =
    unknownNames ?? differenceMessage(entries, firstWrong, valuesAt(firstPoint)[firstWrong] ?? null, key, firstPoint);
  const mistake = findMistake(valuesAt, key.mistakes, key);
  const isRight = (i: number, entry: Node) =>
    key.points.every((_, j) => same(evaluate(entry, configuration(key, j, names)), key.right[i]?.[j] ?? null));
  const wrong = differing.flatMap((j, i) => (j >= 0 && !blank[i] ? [i] : []));
  const at = (j: number) => configuration(key, j, names);
  const mistakeIn = (some: ReadonlySet<number>) => findMistake(valuesAt, key.mistakes, key, some);
  const isOpen = mistake === undefined && wrong.length > 0;
  const explained = isOpen ? slipsIn({ entries, wrong, at, isRight, mistakeIn }, key) : null;
  // the same mistake everywhere may look like several slips
  const mistakeEverywhere = explained && !explained.isAll ? findMistake(valuesAt, key.throughout ?? [], key) : mistake;
  const slips = mistakeEverywhere === undefined ? (explained?.slips ?? []) : [];
  const deviationMessages = deviation === 0 ? [] : [message(deviation.key)];
  const countMessages = unknownNames && !rightEntries.some(Boolean) ? [] : entryCount(rightEntries, zeros);
  return verdictOf(share, [...deviationMessages, ...countMessages, reason], {
    entries: rowsOfRight,
    at: configuration(key, firstPoint, NO_NAMES),
    ...(mistakeEverywhere === undefined ? {} : { mistake: mistakeEverywhere }),
    ...(slips.length > 0 ? { slips } : {}),
  });
}

/** Return whether a value is the expected one; null is expected where the entry is undefined. */
function same(value: Value | null, expected: number | null): boolean {
  if (!value) return false;
  if (expected === null) return !isFinite(value.re) || Math.abs(value.re) > 1e12;
  const tolerance = TOLERANCE * Math.max(value.size, Math.abs(expected), 1e-300);
  return (
    Number.isFinite(value.re) && Number.isFinite(value.im) && Math.hypot(value.re - expected, value.im) <= tolerance
  );
}

/** Return the verdict on entries that are right at all configurations; it says if these may not decide. */
export function agreement(entries: readonly Node[], sure: Message, values: readonly Values[]): Verdict {
  const points = values.length;
  const functions = new Set<string>();
  for (const entry of entries)
    anyNode(entry, ({ text }) => {
      if (BRANCHING.has(text)) functions.add(text);
      return false;
    });
  const digits = Math.max(...entries.map(digitsOfDecimals));
  if (digits > 8 && digits < 16) return correct(message("verdict.decimals", { points, digits }), false);
  const hidden = entries.map(extremeNumber).find((number) => number !== null) ?? cancellationSize(values);
  if (hidden) return correct(message("verdict.out-of-sight", { points, number: hidden }), false);
  if (functions.size === 0) return correct(sure);
  return correct(message("verdict.branches", { points, functions: [...functions].sort().join(", ") }), false);
}

/** Return a number or power so small or large that nine digits can't distinguish it from zero or infinity; or null. */
function extremeNumber(tree: Node): string | null {
  let text: string | null = null;
  anyNode(tree, (node) => {
    const isNumber = node.kind === "number" || node.kind === "decimal";
    if (!isNumber && !(node.kind === "^" && namesIn(node).size === 0)) return false;
    const { size } = evaluate(node, {});
    const isNothing = isNumber ? !/[1-9]/.test(node.text) : size === 0;
    if (!isNothing && !(size >= 1e-6 && size <= 1e6)) text = isNumber ? node.text : size.toExponential(0);
    return text !== null;
  });
  return text;
}

/** Return the size of terms that cancel each other, if nine digits of them exceed the entry itself; else null. */
function cancellationSize(values: readonly Values[]): string | null {
  const largestOf = (of: (value: Value) => number) =>
    (values[0] ?? []).map((_, i) =>
      Math.max(...values.map((entryValues) => (entryValues[i] ? of(entryValues[i]) : 0))),
    );
  const lengths = largestOf(({ re, im }) => Math.hypot(re, im));
  const largest = Math.max(...lengths) || 1;
  const hiding = largestOf(({ size }) => size).find(
    (size, i) => !(size <= MAX_CANCELLATION * Math.max(lengths[i] as number, largest / 100)),
  );
  return hiding === undefined ? null : hiding.toExponential(0);
}

/** A deviation: wrong signs or a constant factor (`count` 1), or both (2); `key` is the message that reports it. */
type Deviation = { readonly count: 1 | 2; readonly key: TextKey };

/** Return the deviation if all wrong entries are right up to signs, a constant factor, or both; else 0. */
function deviationOf(
  valuesAt: ValuesAt,
  key: ValuesKey,
  zeros: readonly boolean[],
  right: readonly boolean[],
): Deviation | 0 {
  const moving = key.moving ?? [];
  const wrong = right.flatMap((ok, i) => (ok ? [] : [i]));
  const isOneNumber = moving.length === 0 && zeros.filter((zero) => !zero).length === 1;
  if (isOneNumber || wrong.some((i) => zeros[i])) return 0;
  const ratios: number[] = [];
  let signs: readonly number[] = [];
  for (let k = 0; k < key.points.length; k += 1) {
    const values = valuesAt(k);
    const signed = wrong.map((i) => (values[i]?.im === 0 ? values[i].re / (key.right[i]?.[k] ?? NaN) : NaN));
    if (k === 0) signs = signed.map(Math.sign);
    const magnitudes = signed.map((ratio, j) => ratio * signs[j]!);
    const ratio = magnitudes[0] as number;
    if (!Number.isFinite(ratio) || !magnitudes.every((other) => near(other, ratio))) return 0;
    ratios.push(ratio);
  }
  const constants = (key.constants ?? []).slice(0, MOST_CONSTANTS).map((name) => key.symbols.indexOf(name));
  for (const powers of powersOf(constants.length)) {
    const left = ratios.map((ratio, k) =>
      powers.reduce((product, power, j) => product * (key.points[k]?.[constants[j]!] ?? NaN) ** power, ratio),
    );
    const [first] = left as [number];
    if (!(Math.abs(first) > TOLERANCE) || !left.every((factor) => near(factor, first))) continue;
    const isOther = powers.some((power) => power !== 0) || !near(first, 1);
    const isNegative = signs.includes(-1);
    if (!isNegative && !isOther) return 0;
    if (isOther && !wrong.some((i) => moving.includes(i))) return 0; // any number would be right up to a factor
    const several = right.length > 1;
    if (isNegative && isOther) return { count: 2, key: several ? "verdict.but-signs-both" : "verdict.but-both" };
    if (!isNegative) return { count: 1, key: "verdict.but-factor" };
    return { count: 1, key: several ? "verdict.but-signs" : "verdict.but-sign" };
  }
  return 0;
}

const MOST_CONSTANTS = 5;
/** Powers of lengths in a constant factor; `qdot grade` accepts any factor that no joint changes. */
const POWERS = [0, 1, -1, 0.5, -0.5];

const near = (a: number, b: number): boolean => Math.abs(a - b) <= TOLERANCE * Math.abs(b);

/** Return all ways to raise a number of symbols to these powers. */
function powersOf(count: number): number[][] {
  return count === 0 ? [[]] : powersOf(count - 1).flatMap((rest) => POWERS.map((power) => [power, ...rest]));
}

/** Return the message on how many nonzero entries are right. */
function entryCount(right: readonly boolean[], zeros: readonly boolean[]): Message[] {
  const entries = right.filter((_, i) => !zeros[i]);
  if (right.length === 1) return [];
  return [message("verdict.entries", { right: entries.filter(Boolean).length, count: entries.length })];
}

function differenceMessage(
  entries: readonly Node[],
  i: number,
  value: Value | null,
  key: ValuesKey,
  k: number,
): Message {
  const place = { row: Math.floor(i / key.columns) + 1, column: (i % key.columns) + 1 };
  if (!value) return message("verdict.blank", place);
  const expected = key.right[i]?.[k] ?? null;
  const values = {
    at: atText(valuesToShow(key, k, entries[i] as Node)),
    yours: complexText(value),
    expected: numberText(expected),
  };
  return entries.length === 1 ? message("verdict.differs", values) : message("verdict.entry", { ...place, ...values });
}

/** Return the index of the mistake that gives this answer, or `some` of its entries if all others are as expected. */
function findMistake(
  valuesAt: ValuesAt,
  mistakes: Mistakes,
  key: ValuesKey,
  some?: ReadonlySet<number>,
): number | undefined {
  const valuesWithMistake = (k: number) =>
    valuesAt(k).map((value, i) => {
      if (some && !some.has(i)) return key.right[i]?.[k] ?? NaN;
      return value && value.im === 0 ? value.re : NaN;
    });
  const sum = (values: readonly number[]) => values.reduce((total, value, i) => total + weight(i) * value, 0);
  const fingerprints = key.points.slice(0, FINGERPRINT_COUNT).map((_, k) => sum(valuesWithMistake(k)));
  const difference = (k: number) => fingerprints[k]! - sum(key.right.map((values) => values[k] ?? NaN));
  const mistake = mistakes.find(([, ...prints]) =>
    prints.every((print, k) => {
      const tolerance = FINGERPRINT_TOLERANCE * Math.max(Math.abs(print), 1e-9);
      // a part must make a difference that is not lost in the other entries
      return (
        Math.abs((fingerprints[k] ?? NaN) - print) <= tolerance &&
        (!some || Math.abs(difference(k)) > NOTICEABLE * tolerance)
      );
    }),
  );
  return mistake?.[0];
}

/** Return the weight of an entry in the fingerprint of an answer, as in ../../../exercises/site/keys.py. */
export const weight = (index: number): number => 1 + ((index * GOLDEN_RATIO) % 1);

/** Return the values of all symbols at point k; an unknown name gets an arbitrary number. */
export function configuration(key: ValuesKey, k: number, names: ReadonlySet<string>): SymbolValues {
  const values: Record<string, number> = {};
  for (const unknown of names) values[unknown] = arbitraryNumber(unknown, k);
  key.symbols.forEach((symbol, i) => (values[symbol] = key.points[k]?.[i] ?? NaN));
  return values;
}

const NO_NAMES: ReadonlySet<string> = new Set();

export function arbitraryNumber(name: string, k: number): number {
  const hash = [...name].reduce((sum, sign) => (sum * 31 + (sign.codePointAt(0) ?? 0)) % 9973, 7 + k);
  return 0.3 + ((hash * GOLDEN_RATIO) % 1.4);
}

/** Return what a student needs to check an entry at point k: joints, lengths, rates, symbols of entry and question. */
function valuesToShow(key: ValuesKey, k: number, entry: Node): SymbolValues {
  const used = namesIn(entry);
  const isMoving = [...used].some(isRate);
  const relevant = key.symbols.filter(
    (symbol) =>
      isJoint(symbol) ||
      (key.constants ?? []).includes(symbol) ||
      used.has(symbol) ||
      (key.mentioned ?? []).includes(symbol) ||
      (isMoving && isRate(symbol)),
  );
  return Object.fromEntries(relevant.map((symbol) => [symbol, key.points[k]?.[key.symbols.indexOf(symbol)] ?? NaN]));
}

export function atText(at: SymbolValues): string {
  return Object.entries(at)
    .map(([symbol, value]) => `${displayName(symbol)} = ${inDigits(asShownOnSliders(symbol, value))}${unitOf(symbol)}`)
    .join(numberSeparator());
}

/** Return a joint angle in degrees within a turn, as the page's sliders show it; other values unchanged. */
function asShownOnSliders(symbol: string, value: number): number {
  if (!isAngle(symbol)) return value;
  const degrees = (value * 180) / Math.PI;
  return Number((degrees - 360 * Math.round(degrees / 360)).toFixed(1));
}

const isJoint = (symbol: string): boolean => /^(theta|d)\d/.test(symbol);
const isRate = (symbol: string): boolean => /^qd\d+$/.test(symbol);
const isAngle = (symbol: string): boolean => /^theta\d+$/.test(symbol);
const unitOf = (symbol: string): string => (isAngle(symbol) ? "°" : /^[ad]\d+$/.test(symbol) ? " m" : "");
/** Return a symbol as the page shows it: θ1. */
export const displayName = (symbol: string): string => symbol.replace(/^theta(?=\d)/, "θ");

/** Return a message on words of an answer that are no symbols of the problem; null if there are none. */
export function unknownSymbols(names: ReadonlySet<string>, key: ValuesKey): Message | null {
  const { symbols, constants, mentioned = [] } = key;
  const unknown = [...names].filter((name) => !symbols.includes(name)).sort();
  if (unknown.length === 0) return null;
  if (unknown.every((name) => UNITS.has(name))) return message("read.unit-left", { unit: unknown[0] as string });
  // of rates, velocities and forces, list only those that the question mentions
  const isUsed = (symbol: string): boolean =>
    !constants || isJoint(symbol) || constants.includes(symbol) || mentioned.includes(symbol);
  const known = symbols.filter(isUsed).join(", ");
  return message("read.unknown", { names: unknown.slice(0, 5).join(", "), known });
}

function numberText(value: number | null): string {
  return value === null || !isFinite(value) ? say("verdict.undefined") : inDigits(value);
}

function complexText({ re, im, size }: Value): string {
  if (!Number.isFinite(re) || !Number.isFinite(im)) return numberText(null);
  if (Math.abs(im) <= TOLERANCE * size) return numberText(re);
  return `${numberText(re)} ${im < 0 ? "−" : "+"} ${numberText(Math.abs(im))} i`;
}
