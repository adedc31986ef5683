// What people bring along, turned into the plain text that the grammar reads: LaTeX, typography, units.
// The rules of ../../../exercises/formula/notation.py; ../../tests/readers.test.ts holds both together.

import { latexAsText } from "./latex.js";
import {
  compiled,
  lengthOf,
  LIMITS,
  literally,
  pattern,
  table,
  VOCABULARY,
  whole,
  withoutSpacesAtEnd,
} from "./vocabulary.js";

const SUPERSCRIPTS = table(VOCABULARY.superscripts);
const SUPERSCRIPT = compiled(`[${[...SUPERSCRIPTS.keys()].join("")}]+`, "g");
const SIGNS = table(VOCABULARY.signs);
const RATE_WITH_DOT = pattern("rate_with_dot", "g");
const DOLLARS = whole("dollars");
/** The semicolon or full stop that ends a statement or a sentence. */
const END = pattern("end");

const { whole_numbers: WHOLE, before_whole_numbers: BEFORE_WHOLE } = VOCABULARY;
const UNITS = table(VOCABULARY.units);
/** What finds any of these units, also with blanks around its stroke, as in rad / s. */
const unitsPattern = (units: readonly string[]): string =>
  [...units]
    .sort((a, b) => b.length - a.length)
    .map((unit) => literally(unit).replace("\\/", " ?/ ?"))
    .join("|");
/** A unit as the vocabulary has it. */
const unitOf = (found: string): string => found.replace(" /", "/").replace("/ ", "/");
const UNIT_NAMES = unitsPattern([...UNITS.keys()]);
const UNIT_AT_END = compiled(`${VOCABULARY.patterns.before_unit}(${UNIT_NAMES})$`);

/**
 * What stands before the result, a unit in brackets behind it, degrees inside it, roots by their sign; each with what
 * there must be in a text that has it, for the search takes longer.
 */
const HABITS = VOCABULARY.habits.map(({ mark, pattern: source, meant }) => ({
  mark,
  pattern: compiled(source, "g"),
  meant: meant.replace(/\\([12])/g, "$$$1"),
}));

/** Digits of all scripts, wide signs of East Asian keyboards, spaces of typesetters, and marks that nobody sees. */
let lookAlikes: ReadonlyMap<string, string> | null = null; // seven hundred, which few texts have

function withoutLookAlikes(text: string): string {
  lookAlikes ??= new Map([
    ...Object.entries(VOCABULARY.look_alikes),
    ...[...VOCABULARY.zeros].flatMap((zero) =>
      Array.from({ length: 10 }, (_, k): [string, string] => [
        String.fromCodePoint((zero.codePointAt(0) as number) + k),
        String(k),
      ]),
    ),
  ]);
  const meant = lookAlikes;
  return [...text].map((sign) => meant.get(sign) ?? sign).join("");
}

const SYMBOLS_IN_A_ROW = pattern("symbols_in_a_row", "g");
const SIGNED_SYMBOL = pattern("signed_symbol", "g");

/** + a1 - a1 + a1 … with equal symbols counted; the first and the last may belong to what stands beside them. */
function counted(row: string, known: ReadonlySet<string>): string {
  const terms = [...row.matchAll(SIGNED_SYMBOL)].map(([, sign = "", symbol = ""]) => ({ sign, symbol }));
  const inner = terms.slice(1, -1);
  const first = terms[0];
  const last = terms.at(-1);
  if (terms.length < LIMITS.many || !first || !last || inner.some(({ symbol }) => !known.has(symbol))) return row;
  const counts = new Map<string, number>();
  for (const { sign, symbol } of inner) counts.set(sign + symbol, (counts.get(sign + symbol) ?? 0) + 1);
  const sums = [...counts.keys()].sort().map((each) => `${each[0]}${counts.get(each)}*${each.slice(1)}`);
  return `${first.sign}${first.symbol}${sums.join("")}${last.sign}${last.symbol}`;
}

// eslint-disable-next-line no-control-regex
const isAscii = (text: string): boolean => /^[\x00-\x7f]*$/.test(text);

/** An answer in plain text; the names that are `known` are never taken for units. */
export function plain(answer: string, known: ReadonlySet<string>): string {
  let text = withoutSpacesAtEnd(isAscii(answer) ? answer : withoutLookAlikes(answer));
  if (lengthOf(text, LIMITS.long) > LIMITS.long) text = text.replace(SYMBOLS_IN_A_ROW, (row) => counted(row, known));
  for (const habit of HABITS) if (text.includes(habit.mark)) text = text.replace(habit.pattern, habit.meant);
  text = withoutUnits(text, known);
  const isShort = lengthOf(text, LIMITS.latex_characters) <= LIMITS.latex_characters;
  const latex = isShort && ["\\", "_{", "^{"].some((mark) => text.includes(mark));
  const last = text.at(-1) ?? "";
  const isPlain = isAscii(text) && !latex && !".;$".includes(last) && !/[A-Za-z]/.test(last);
  if (isPlain && !text.slice(-5).includes("^")) return ofJoints(text, known);
  const raised = (found: string): string => [...found].map((sign) => SUPERSCRIPTS.get(sign)).join("");
  text = text.replace(SUPERSCRIPT, (found) => `^(${raised(found)})`).replace(RATE_WITH_DOT, "qd");
  text = [...text].map((sign) => SIGNS.get(sign) ?? sign).join("");
  text = DOLLARS.exec(text)?.[2] ?? text;
  if (latex) text = latexAsText(text);
  text = ofJoints(withoutSpacesAtEnd(text).replace(END, ""), known);
  return withoutUnit(withoutUnits(text, known), known);
}

const NUMBER_IN_UNIT = compiled(
  `${VOCABULARY.patterns.number_in_unit}(${UNIT_NAMES})${VOCABULARY.patterns.behind_unit}`,
  "g",
);

/** A text without the units of its numbers, as in 0.5 rad/s, 30 cm; those of m are left to the grammar. */
export function withoutUnits(text: string, known: ReadonlySet<string>): string {
  return text.replace(NUMBER_IN_UNIT, (found: string, number: string, written: string) => {
    const unit = unitOf(written);
    return known.has(unit) || WHOLE.includes(unit) ? found : number + (UNITS.get(unit) ?? "");
  });
}

const LENGTH_WITH_COMMA = compiled(
  `${VOCABULARY.patterns.decimal_in_unit}(${unitsPattern(VOCABULARY.lengths)})${VOCABULARY.patterns.behind_unit}`,
  "g",
);

/** A text with the commas of lengths as in 0,2 m, which stand between no two values, written as points. */
export const withPointsOfLengths = (text: string): string => text.replace(LENGTH_WITH_COMMA, "$1.$2$3");

const OF_NUMBERS = unitsPattern([...UNITS.keys(), ...VOCABULARY.degrees]);
const NAMED_IN_UNIT = compiled(
  `${VOCABULARY.patterns.name_of_number}${VOCABULARY.patterns.number_in_unit}` +
    `(${OF_NUMBERS})${VOCABULARY.patterns.behind_unit}`,
  "g",
);

/** The unit of every number that has one, each with the name before it, or "", and where that begins. */
export function unitsOfNumbers(text: string): { name: string; unit: string; start: number }[] {
  return [...text.matchAll(NAMED_IN_UNIT)].map((found) => ({
    name: found[1] ?? "",
    unit: unitOf(found[3] as string),
    start: found.index,
  }));
}

/** Whether a unit is one of lengths or of angles, also per second; "" for any other. */
export function kindOfUnit(unit: string): "length" | "angle" | "" {
  const rate = (bare: string, each: string): string =>
    bare.endsWith(each) ? bare.slice(0, bare.length - each.length) : bare;
  const bare = VOCABULARY.per_second.reduce(rate, unit);
  return VOCABULARY.lengths.includes(bare) ? "length" : VOCABULARY.angles.includes(bare) ? "angle" : "";
}

const RATES = pattern("rate_as_derivative", "g");
const VECTORS = pattern("entry_of_vector", "g");

/**
 * A text with rates written as derivatives, and joints as the entries q[0] or q(1) of a vector, by name. In brackets
 * the first joint has the number 0, as in Python, or 1, as in Maple, where the last would be none of the problem's; in
 * parentheses 1, as in Matlab.
 */
function ofJoints(answer: string, known: ReadonlySet<string>): string {
  let text = answer;
  if (text.includes("'") || (text.includes("/") && text.includes("t"))) {
    text = text.replace(RATES, (...found: unknown[]) => ` qd${found.slice(1, 5).find((digit) => digit)} `);
  }
  if (text.includes(".diff")) text = text.replaceAll("(t).diff", ".diff");
  const indices = text.includes("[")
    ? [...text.matchAll(VECTORS)].flatMap(([, , index]) => (index === undefined ? [] : [Number(index)]))
    : [];
  const beyond = Math.max(0, ...indices) + 1;
  const isLast = known.has(`theta${beyond}`) || known.has(`d${beyond}`);
  const first = indices.length > 0 && !indices.includes(0) && known.size > 0 && !isLast ? 0 : 1;
  return text.replace(VECTORS, (_, joint?: string, index?: string, fromOne?: string) => {
    const number = index === undefined ? fromOne : Number(index) + first;
    return `${joint ? "q" : "qd"}${number}`;
  });
}

function withoutUnit(text: string, known: ReadonlySet<string>): string {
  const found = UNIT_AT_END.exec(text);
  const unit = unitOf(found?.[1] ?? "");
  if (!found || known.has(unit)) return text;
  const factor = UNITS.get(unit) ?? "";
  const rest = text.slice(0, found.index);
  // A list can't be scaled, and in theta2 = pi*m the m is any whole number.
  const isList = factor !== "" && "[{".includes(rest[0] ?? " ");
  if (isList || text.includes("=") || (WHOLE.includes(unit) && BEFORE_WHOLE.some((sign) => rest.endsWith(sign))))
    return text;
  return factor ? `(${rest})${factor}` : rest;
}
