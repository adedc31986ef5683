// Formulas, by what they are worth at the configurations of a key.

import type { ValuesKey } from "../bank.js";
import { evaluate, type Value } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { read } from "../read/reader.js";
import { tableText } from "../read/tables.js";
import { anyNode, columnsOf, digitsOfDecimals, hasBlank, namesIn, type Node, type Rows } from "../read/tree.js";
import { table, VOCABULARY } from "../read/vocabulary.js";
import { inDigits, message, type Message, say, type TextKey } from "../text/text.js";
import { shareButForFactor, shareOfEntries } from "./credit.js";
import { entriesOf, isBlank, matrixOf, ofScalars, otherComponent, readAs, rightSide, shaped } from "./forms.js";
import { slipsIn } from "./slips.js";
import { type At, correct, graded, ifRead, missing, type Verdict, wrong } from "./verdict.js";

/** Share of the size of the terms that rounding may take. */
const SAME = 1e-9;
/** Share by which the print of a mistake, which is kept with six digits, may differ. */
const PRINT = 2e-5;
/** Mistakes have prints at so many configurations at most; a part must differ by so many times the room. */
const PRINTED = 3;
const TELLING = 100;
/** So many times an entry its terms may be: rounding is still far below it then. */
const HIDING = 1e4;
const UNITS = table(VOCABULARY.units);
const GOLDEN = 0.6180339887498949;
/** Functions of which two formulas may be the same in one region and differ in another. */
const BRANCHING = new Set(["sqrt", "abs", "sign", "asin", "acos", "atan", "acot", "atan2", "log"]);

type Names = readonly string[];
type Mistakes = ValuesKey["mistakes"];
/** The values of an answer's entries, null for a blank, and these values at each point of the key. */
type Values = readonly (Value | null)[];
type Mine = (k: number) => Values;

/** Judge a formula, a vector or a matrix; `labels` name the entries of a vector of joint rates, `vectors` columns. */
export function judgeValues(answer: string, key: ValuesKey, labels: Names = [], vectors: Names = []): Verdict {
  if (!answer.trim()) return missing();
  const known = new Set(key.symbols);
  const found =
    key.rows * key.columns === 1
      ? ifRead(() => formula(answer, known, labels))
      : readAs(
          (text) => {
            const tree = read(text, known);
            const rows = isBlank(tree) ? null : matrixOf(tree, known, labels, key, vectors);
            return rows && isTurned(rows, key) ? turned(rows, key) : entriesOf(tree, key, known, labels, vectors);
          },
          answer,
          () => tableText(answer, key.rows, key.columns),
        );
  return "outcome" in found ? found : ifRead(() => compared(found, key));
}

/** The one entry of an answer; where 0,5 makes a list of it, with commas as points. */
function formula(answer: string, known: ReadonlySet<string>, labels: readonly string[]): Rows | Verdict {
  const typed = read(answer, known);
  if (isBlank(typed)) return missing();
  const other = otherComponent(typed, labels);
  if (other) return wrong("read.component", { other, asked: labels[0] as string });
  const tree = rightSide(alone(rightSide(typed, known, labels)), known, labels);
  const pointed = withPoints(answer);
  if (tree.kind === "list" && pointed !== answer) return ifRead(() => formula(pointed, known, labels));
  return ["list", "set", "dict"].includes(tree.kind) ? wrong("read.list") : [[tree]];
}

/** The entry of Matrix([a]), [a] or [[a]]: a matrix of one entry stands for that. */
function alone(tree: Node): Node {
  const [only] = tree.args;
  return tree.kind === "list" && tree.args.length === 1 && only ? alone(only) : tree;
}

/** Whether a matrix has as many rows as columns are expected, and the other way round. */
function isTurned(rows: Rows, key: ValuesKey): boolean {
  const columns = rows[0]?.length ?? 0;
  const isOther = rows.length === key.columns && columns === key.rows && key.rows !== key.columns;
  return isOther && Math.min(key.rows, key.columns) > 1;
}

/** What is said of such a matrix: that it is right but for that, where it is. */
function turned(rows: Node[][], key: ValuesKey): Verdict {
  const isRight = compared(ofScalars(columnsOf(rows)), key).outcome === "correct";
  const slip = message(isRight ? "slip.transposed" : "slip.turned");
  return { ...(shaped(rows, key) as Verdict), slips: [slip] };
}

function compared(rows: readonly (readonly Node[])[], key: ValuesKey): Verdict {
  if (key.points.length === 0) throw new Error("a key without configurations"); // else everything would be right
  const entries = rows.flat();
  const blank = entries.map(hasBlank);
  const names = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  const found: Values[] = [];
  // a wrong answer differs at one of the first configurations: what it is worth at the others need not be known
  const valuesAt = (at: At) => entries.map((entry, i) => (blank[i] ? null : evaluate(entry, at)));
  const mine = (k: number) => (found[k] ??= valuesAt(configuration(key, k, names)));
  const scales = key.right.map((values) => Math.max(...values.map((value) => Math.abs(value ?? 0))));
  const largest = Math.max(...scales);
  const differing = entries.map((_, i) =>
    key.points.findIndex((_point, k) => !same(mine(k)[i] ?? null, key.right[i]?.[k] ?? null)),
  );
  if (differing.every((k) => k < 0))
    return agreed(
      entries,
      message("verdict.values", { points: key.points.length }),
      Array.from(key.points.keys(), mine),
    );
  const right = differing.map((k) => k < 0);
  const zeros = scales.map((scale) => scale === 0 && largest > 0);
  const amiss = blank.some(Boolean) ? 0 : amissIn(mine, key, zeros, right);
  const moving = key.moving ?? [];
  const byEntries =
    right.length === 1 || (moving.length > 0 && !moving.some((i) => right[i]))
      ? 0
      : shareOfEntries(right, zeros, blank);
  const share = Math.max(byEntries, amiss === 0 ? 0 : shareButForFactor(amiss.count));
  const marks = rows.map((row, r) => row.map((_, c) => right[r * row.length + c] as boolean));
  const first = differing.findIndex((k) => k >= 0);
  const k = differing[first] as number;
  const unknown = unknownSymbols(names, key);
  const reason = unknown ?? difference(entries, first, mine(k)[first] ?? null, key, k);
  const mistake = mistakeBehind(mine, key.mistakes, key);
  const isRight = (i: number, entry: Node) =>
    key.points.every((_, j) => same(evaluate(entry, configuration(key, j, names)), key.right[i]?.[j] ?? null));
  const wrong = differing.flatMap((j, i) => (j >= 0 && !blank[i] ? [i] : []));
  const at = (j: number) => configuration(key, j, names);
  const mistakeIn = (some: ReadonlySet<number>) => mistakeBehind(mine, key.mistakes, key, some);
  const isOpen = mistake === undefined && wrong.length > 0;
  const explained = isOpen ? slipsIn({ entries, wrong, at, isRight, mistakeIn }, key) : null;
  // the same slip everywhere may come to several in places
  const everywhere = explained && !explained.isAll ? mistakeBehind(mine, key.throughout ?? [], key) : mistake;
  const slips = everywhere === undefined ? (explained?.slips ?? []) : [];
  const but = amiss === 0 ? [] : [message(amiss.says)];
  const count = unknown && !right.some(Boolean) ? [] : counted(right, zeros);
  return graded(share, [...but, ...count, reason], {
    entries: marks,
    at: configuration(key, k, NOTHING),
    ...(everywhere === undefined ? {} : { mistake: everywhere }),
    ...(slips.length > 0 ? { slips } : {}),
  });
}

function same(mine: Value | null, due: number | null): boolean {
  if (!mine) return false;
  if (due === null) return !isFinite(mine.re) || Math.abs(mine.re) > 1e12;
  const room = SAME * Math.max(mine.size, Math.abs(due), 1e-300);
  return Number.isFinite(mine.re) && Number.isFinite(mine.im) && Math.hypot(mine.re - due, mine.im) <= room;
}

/** What is said of entries that are right at all configurations, where these may not tell all. */
export function agreed(entries: readonly Node[], sure: Message, values: readonly Values[]): Verdict {
  const points = values.length;
  const functions = new Set<string>();
  for (const entry of entries)
    anyNode(entry, ({ text }) => {
      if (BRANCHING.has(text)) functions.add(text);
      return false;
    });
  const digits = Math.max(...entries.map(digitsOfDecimals));
  if (digits > 8 && digits < 16) return correct(message("verdict.decimals", { points, digits }), false);
  const unseen = entries.map(outOfSight).find((number) => number !== null) ?? hiddenBy(values);
  if (unseen) return correct(message("verdict.out-of-sight", { points, number: unseen }), false);
  if (functions.size === 0) return correct(sure);
  return correct(message("verdict.branches", { points, functions: [...functions].sort().join(", ") }), false);
}

/** A number or power that nine digits can't tell from zero or infinity; null if there is none. */
function outOfSight(tree: Node): string | null {
  let found: string | null = null;
  anyNode(tree, (each) => {
    const isNumber = each.kind === "number" || each.kind === "decimal";
    if (!isNumber && !(each.kind === "^" && namesIn(each).size === 0)) return false;
    const { size } = evaluate(each, {});
    const isNothing = isNumber ? !/[1-9]/.test(each.text) : size === 0;
    if (!isNothing && !(size >= 1e-6 && size <= 1e6)) found = isNumber ? each.text : size.toExponential(0);
    return found !== null;
  });
  return found;
}

/** How large terms are that cancel each other, where nine digits of them are more than the entry itself; else null. */
function hiddenBy(values: readonly Values[]): string | null {
  const most = (of: (value: Value) => number) =>
    (values[0] ?? []).map((_, i) => Math.max(...values.map((each) => (each[i] ? of(each[i]) : 0))));
  const lengths = most(({ re, im }) => Math.hypot(re, im));
  const largest = Math.max(...lengths) || 1;
  const hiding = most(({ size }) => size).find(
    (size, i) => !(size <= HIDING * Math.max(lengths[i] as number, largest / 100)),
  );
  return hiding === undefined ? null : hiding.toExponential(0);
}

type Amiss = { readonly count: 1 | 2; readonly says: TextKey };

/** What is amiss if all wrong entries are right but for signs, a constant factor, or both; else 0. */
function amissIn(mine: Mine, key: ValuesKey, zeros: readonly boolean[], right: readonly boolean[]): Amiss | 0 {
  const moving = key.moving ?? [];
  const wrong = right.flatMap((ok, i) => (ok ? [] : [i]));
  const isOneNumber = moving.length === 0 && zeros.filter((zero) => !zero).length === 1;
  if (isOneNumber || wrong.some((i) => zeros[i])) return 0;
  const ratios: number[] = [];
  let signs: readonly number[] = [];
  for (let k = 0; k < key.points.length; k += 1) {
    const own = mine(k);
    const signed = wrong.map((i) => (own[i]?.im === 0 ? own[i].re / (key.right[i]?.[k] ?? NaN) : NaN));
    if (k === 0) signs = signed.map(Math.sign);
    const each = signed.map((ratio, j) => ratio * signs[j]!);
    const ratio = each[0] as number;
    if (!Number.isFinite(ratio) || !each.every((other) => near(other, ratio))) return 0;
    ratios.push(ratio);
  }
  const constants = (key.constants ?? []).slice(0, MOST_CONSTANTS).map((name) => key.symbols.indexOf(name));
  for (const powers of powersOf(constants.length)) {
    const left = ratios.map((ratio, k) =>
      powers.reduce((product, power, j) => product * (key.points[k]?.[constants[j]!] ?? NaN) ** power, ratio),
    );
    const [first] = left as [number];
    if (!(Math.abs(first) > SAME) || !left.every((each) => near(each, first))) continue;
    const isOther = powers.some((power) => power !== 0) || !near(first, 1);
    const isNegative = signs.includes(-1);
    if (!isNegative && !isOther) return 0;
    if (isOther && !wrong.some((i) => moving.includes(i))) return 0; // any number would be right but for a factor
    const several = right.length > 1;
    if (isNegative && isOther) return { count: 2, says: several ? "verdict.but-signs-both" : "verdict.but-both" };
    if (!isNegative) return { count: 1, says: "verdict.but-factor" };
    return { count: 1, says: several ? "verdict.but-signs" : "verdict.but-sign" };
  }
  return 0;
}

const MOST_CONSTANTS = 5;
/** Powers of lengths that a constant factor may hold; the grader of qdot takes any factor that no joint changes. */
const POWERS = [0, 1, -1, 0.5, -0.5];

const near = (a: number, b: number): boolean => Math.abs(a - b) <= SAME * Math.abs(b);

/** All ways to raise so many symbols to these powers. */
function powersOf(count: number): number[][] {
  return count === 0 ? [[]] : powersOf(count - 1).flatMap((rest) => POWERS.map((power) => [power, ...rest]));
}

function counted(right: readonly boolean[], zeros: readonly boolean[]): Message[] {
  const entries = right.filter((_, i) => !zeros[i]);
  if (right.length === 1) return [];
  return [message("verdict.entries", { right: entries.filter(Boolean).length, count: entries.length })];
}

function difference(entries: readonly Node[], i: number, mine: Value | null, key: ValuesKey, k: number): Message {
  const place = { row: Math.floor(i / key.columns) + 1, column: (i % key.columns) + 1 };
  if (!mine) return message("verdict.blank", place);
  const due = key.right[i]?.[k] ?? null;
  const values = {
    at: atText(shownAt(key, k, entries[i] as Node)),
    yours: complexText(mine),
    expected: numberText(due),
  };
  return entries.length === 1 ? message("verdict.differs", values) : message("verdict.entry", { ...place, ...values });
}

/** The index of the mistake that gives this answer, or, with all other entries as expected, `some` of it. */
function mistakeBehind(mine: Mine, mistakes: Mistakes, key: ValuesKey, some?: ReadonlySet<number>): number | undefined {
  const worth = (k: number) =>
    mine(k).map((value, i) => {
      if (some && !some.has(i)) return key.right[i]?.[k] ?? NaN;
      return value && value.im === 0 ? value.re : NaN;
    });
  const sum = (values: readonly number[]) => values.reduce((total, value, i) => total + weight(i) * value, 0);
  const prints = key.points.slice(0, PRINTED).map((_, k) => sum(worth(k)));
  const off = (k: number) => prints[k]! - sum(key.right.map((values) => values[k] ?? NaN));
  const found = mistakes.find(([, ...theirs]) =>
    theirs.every((their, k) => {
      const room = PRINT * Math.max(Math.abs(their), 1e-9);
      // a part must make a difference that is not lost in all the rest
      return Math.abs((prints[k] ?? NaN) - their) <= room && (!some || Math.abs(off(k)) > TELLING * room);
    }),
  );
  return found?.[0];
}

/** What an entry counts in the print of an answer, as in ../../../exercises/site/keys.py. */
export const weight = (index: number): number => 1 + ((index * GOLDEN) % 1);

// --- configurations ---

/** The values of all symbols at point k; a name that no one knows is any number. */
export function configuration(key: ValuesKey, k: number, names: ReadonlySet<string>): At {
  const found: Record<string, number> = {};
  for (const unknown of names) found[unknown] = anyNumber(unknown, k);
  key.symbols.forEach((symbol, i) => (found[symbol] = key.points[k]?.[i] ?? NaN));
  return found;
}

const NOTHING: ReadonlySet<string> = new Set();

export function anyNumber(name: string, k: number): number {
  const turned = [...name].reduce((sum, sign) => (sum * 31 + (sign.codePointAt(0) ?? 0)) % 9973, 7 + k);
  return 0.3 + ((turned * GOLDEN) % 1.4);
}

/** What a student needs to check an entry at point k: joints, lengths, rates, symbols of entry and question. */
function shownAt(key: ValuesKey, k: number, entry: Node): At {
  const used = namesIn(entry);
  const isMoving = [...used].some(isRate);
  const shown = key.symbols.filter(
    (symbol) =>
      isJoint(symbol) ||
      (key.constants ?? []).includes(symbol) ||
      used.has(symbol) ||
      (key.spoken ?? []).includes(symbol) ||
      (isMoving && isRate(symbol)),
  );
  return Object.fromEntries(shown.map((symbol) => [symbol, key.points[k]?.[key.symbols.indexOf(symbol)] ?? NaN]));
}

export function atText(at: At): string {
  return Object.entries(at)
    .map(([symbol, value]) => `${seen(symbol)} = ${inDigits(asOnSliders(symbol, value))}${unitOf(symbol)}`)
    .join(inDigits(0.5).includes(",") ? "; " : ", ");
}

/** A joint angle in degrees, as the page's sliders have it, within a turn; everything else as it is. */
function asOnSliders(symbol: string, value: number): number {
  if (!isAngle(symbol)) return value;
  const degrees = (value * 180) / Math.PI;
  return Number((degrees - 360 * Math.round(degrees / 360)).toFixed(1));
}

const isJoint = (symbol: string): boolean => /^(theta|d)\d/.test(symbol);
const isRate = (symbol: string): boolean => /^qd\d+$/.test(symbol);
const isAngle = (symbol: string): boolean => /^theta\d+$/.test(symbol);
const unitOf = (symbol: string): string => (isAngle(symbol) ? "°" : /^[ad]\d+$/.test(symbol) ? " m" : "");
/** A symbol as the page shows it: θ1. */
export const seen = (symbol: string): string => symbol.replace(/^theta(?=\d)/, "θ");

/** What is said of words in an answer that are no symbols of the problem; null where there are none. */
export function unknownSymbols(names: ReadonlySet<string>, key: ValuesKey): Message | null {
  const { symbols, constants, spoken = [] } = key;
  const unknown = [...names].filter((each) => !symbols.includes(each)).sort();
  if (unknown.length === 0) return null;
  if (unknown.every((each) => UNITS.has(each))) return message("read.unit-left", { unit: unknown[0] as string });
  // of rates, velocities and forces those of which the question speaks
  const isUsed = (each: string): boolean =>
    !constants || isJoint(each) || constants.includes(each) || spoken.includes(each);
  const known = symbols.filter(isUsed).join(", ");
  return message("read.unknown", { names: unknown.slice(0, 5).join(", "), known });
}

function numberText(value: number | null): string {
  return value === null || !isFinite(value) ? say("verdict.undefined") : inDigits(value);
}

function complexText({ re, im, size }: Value): string {
  if (!Number.isFinite(re) || !Number.isFinite(im)) return numberText(null);
  if (Math.abs(im) <= SAME * size) return numberText(re);
  return `${numberText(re)} ${im < 0 ? "−" : "+"} ${numberText(Math.abs(im))} i`;
}
