// Convert the notations of answers to the plain text that the grammar parses: LaTeX, typography, units.
// The rules of ../../../exercises/formula/notation.py; ../../tests/readers.test.ts compares both.

import { convertLatex } from "./latex.js";
import { normalizeUnit } from "./units.js";
import { anyOf, compile, escapeSigns, countCharacters, LIMITS, pattern, SUPERSCRIPTS, table } from "./vocabulary.js";
import { UNITS, VOCABULARY, wholePattern, stripEnd } from "./vocabulary.js";

/** As "⁻¹". */
const SUPERSCRIPT = compile(`[${[...SUPERSCRIPTS.keys()].join("")}]+`, "g");
const SIGNS = table(VOCABULARY.signs);
/** As "θ̇_" before the index of a joint. */
const RATE_WITH_DOT = pattern("rate_with_dot", "g");
/** A whole text between dollar signs, as in "$a_1$"; group 2: the text. */
const DOLLARS = wholePattern("dollars");
/** The semicolon or full stop at the end of a statement or sentence. */
const END_OF_TEXT = pattern("end_of_text");

const { whole_numbers: WHOLE_NUMBERS, before_whole_numbers: BEFORE_WHOLE_NUMBERS } = VOCABULARY;
/** Return a pattern for any of these units, also with spaces around the slash, as in rad / s. */
const patternOfUnits = (units: Iterable<string>): string =>
  anyOf(units, (unit) => escapeSigns(unit).replace("\\/", " ?/ ?"));
const UNIT_NAMES = patternOfUnits(UNITS.keys());
/** As " rad/s" and "*m" at the end of a text; group: the unit. */
const UNIT_AT_END = compile(`${VOCABULARY.patterns.before_unit}(${UNIT_NAMES})$`);

/**
 * Habits of typing: a text before the result, a unit in brackets after it, degrees inside it, roots by their sign.
 * `mark` is a text that each occurrence contains; looking for it first saves time.
 */
const HABITS = VOCABULARY.habits.map(({ mark, pattern: source, replacement }) => ({
  mark,
  pattern: compile(source, "g"),
  replacement: replacement.replace(/\\([12])/g, "$$$1"),
}));

/** Plain characters for digits of all scripts, wide signs, typographic spaces, invisible marks; null until needed. */
let lookAlikes: ReadonlyMap<string, string> | null = null;

/** Return a text in which these characters are replaced by plain ones. */
function replaceLookAlikes(text: string): string {
  lookAlikes ??= new Map([
    ...Object.entries(VOCABULARY.look_alikes),
    ...[...VOCABULARY.zeros].flatMap((zero) =>
      Array.from({ length: 10 }, (_, k): [string, string] => [
        String.fromCodePoint((zero.codePointAt(0) as number) + k),
        String(k),
      ]),
    ),
  ]);
  const plainSigns = lookAlikes;
  return [...text].map((sign) => plainSigns.get(sign) ?? sign).join("");
}

/** As "+ a1 - a1 + a2". */
const SYMBOLS_IN_A_ROW = pattern("symbols_in_a_row", "g");
/** As "+ a1"; groups: the sign, and the symbol. */
const SIGNED_SYMBOL = pattern("signed_symbol", "g");

/** Shorten + a1 - a1 + a1 … by counting equal terms; the first and last may belong to their neighbours, and stay. */
function countEqualTerms(row: string, symbols: ReadonlySet<string>): string {
  const terms = [...row.matchAll(SIGNED_SYMBOL)].map(([, sign = "", symbol = ""]) => ({ sign, symbol }));
  const innerTerms = terms.slice(1, -1);
  const firstTerm = terms[0];
  const lastTerm = terms.at(-1);
  const areKnown = innerTerms.every(({ symbol }) => symbols.has(symbol));
  if (terms.length < LIMITS.counted_terms || !firstTerm || !lastTerm || !areKnown) return row;
  const counts = new Map<string, number>();
  for (const { sign, symbol } of innerTerms) counts.set(sign + symbol, (counts.get(sign + symbol) ?? 0) + 1);
  const sums = [...counts.keys()].sort().map((term) => `${term[0]}${counts.get(term)}*${term.slice(1)}`);
  return `${firstTerm.sign}${firstTerm.symbol}${sums.join("")}${lastTerm.sign}${lastTerm.symbol}`;
}

// eslint-disable-next-line no-control-regex
const isAscii = (text: string): boolean => /^[\x00-\x7f]*$/.test(text);

/** Return an answer as plain text; the names in `symbols` are never read as units. */
export function toPlainText(answer: string, symbols: ReadonlySet<string>): string {
  let text = stripEnd(isAscii(answer) ? answer : replaceLookAlikes(answer));
  if (countCharacters(text, LIMITS.long_text) > LIMITS.long_text)
    text = text.replace(SYMBOLS_IN_A_ROW, (row) => countEqualTerms(row, symbols));
  for (const habit of HABITS) if (text.includes(habit.mark)) text = text.replace(habit.pattern, habit.replacement);
  text = convertUnits(text, symbols);
  const isShort = countCharacters(text, LIMITS.latex_characters) <= LIMITS.latex_characters;
  const isLatex = isShort && ["\\", "_{", "^{"].some((mark) => text.includes(mark));
  const lastSign = text.at(-1) ?? "";
  const isPlain = isAscii(text) && !isLatex && !".;$".includes(lastSign) && !/[A-Za-z]/.test(lastSign);
  if (isPlain && !text.slice(-5).includes("^")) return nameRatesAndEntries(text, symbols);
  const exponentOf = (superscripts: string): string => [...superscripts].map((sign) => SUPERSCRIPTS.get(sign)).join("");
  text = text.replace(SUPERSCRIPT, (superscripts) => `^(${exponentOf(superscripts)})`).replace(RATE_WITH_DOT, "qd");
  text = [...text].map((sign) => SIGNS.get(sign) ?? sign).join("");
  text = DOLLARS.exec(text)?.[2] ?? text;
  if (isLatex) text = convertLatex(text);
  text = nameRatesAndEntries(stripEnd(text).replace(END_OF_TEXT, ""), symbols);
  return removeFinalUnit(convertUnits(text, symbols), symbols);
}

/** As "30 cm"; groups: the number, and the unit. */
const NUMBER_WITH_UNIT = compile(
  `${VOCABULARY.patterns.number_before_unit}(${UNIT_NAMES})${VOCABULARY.patterns.after_unit}`,
  "g",
);

/** Remove the units of numbers, as in 0.5 rad/s or 30 cm; the parser handles m. */
export function convertUnits(text: string, symbols: ReadonlySet<string>): string {
  return text.replace(NUMBER_WITH_UNIT, (match: string, number: string, typedUnit: string) => {
    const unit = normalizeUnit(typedUnit);
    return symbols.has(unit) || WHOLE_NUMBERS.includes(unit) ? match : number + (UNITS.get(unit) ?? "");
  });
}

/** As "0,2 m"; groups: the digits before the comma, those after it, and the unit. */
const LENGTH_WITH_COMMA = compile(
  `${VOCABULARY.patterns.decimal_before_length}(${patternOfUnits(VOCABULARY.lengths)})${VOCABULARY.patterns.after_unit}`,
  "g",
);

/** Replace the decimal commas of lengths by points, as in 0,2 m; such a comma does not separate values. */
export const usePointsInLengths = (text: string): string => text.replace(LENGTH_WITH_COMMA, "$1.$2$3");

/** As "dtheta1/dt" and "theta1'"; one of four groups is the digit. */
const RATES_AS_DERIVATIVES = pattern("rate_as_derivative", "g");
/** As "q[0]" and "qd(1)"; groups: the name (none for rates), the index from 0, the index from 1. */
const ENTRIES_OF_VECTORS = pattern("entry_of_vector", "g");

/**
 * Replace rates written as derivatives, and joints written as entries q[0] or q(1) of a vector, by their names. In
 * square brackets, the first joint has index 0, as in Python. It has index 1, as in Maple, if index 0 is missing and
 * the last joint would otherwise be unknown. In parentheses, it has index 1, as in Matlab.
 */
function nameRatesAndEntries(answer: string, symbols: ReadonlySet<string>): string {
  let text = answer;
  if (text.includes("'") || (text.includes("/") && text.includes("t"))) {
    text = text.replace(
      RATES_AS_DERIVATIVES,
      (...match: unknown[]) => ` qd${match.slice(1, 5).find((digit) => digit)} `,
    );
  }
  if (text.includes(".diff")) text = text.replaceAll("(t).diff", ".diff");
  const indices = text.includes("[")
    ? [...text.matchAll(ENTRIES_OF_VECTORS)].flatMap(([, , index]) => (index === undefined ? [] : [Number(index)]))
    : [];
  const jointAfterLast = Math.max(0, ...indices) + 1;
  const isKnownJoint = symbols.has(`theta${jointAfterLast}`) || symbols.has(`d${jointAfterLast}`);
  const indexOffset = indices.length > 0 && !indices.includes(0) && symbols.size > 0 && !isKnownJoint ? 0 : 1;
  return text.replace(ENTRIES_OF_VECTORS, (_, joint?: string, indexFromZero?: string, indexFromOne?: string) => {
    const number = indexFromZero === undefined ? indexFromOne : Number(indexFromZero) + indexOffset;
    return `${joint ? "q" : "qd"}${number}`;
  });
}

/** Remove or convert the unit at the end of a text. */
function removeFinalUnit(text: string, symbols: ReadonlySet<string>): string {
  const match = UNIT_AT_END.exec(text);
  const unit = normalizeUnit(match?.[1] ?? "");
  if (!match || symbols.has(unit)) return text;
  const factor = UNITS.get(unit) ?? "";
  const value = text.slice(0, match.index);
  // a list can't be scaled, and in theta2 = pi*m the m is an integer
  const isList = factor !== "" && "[{".includes(value[0] ?? " ");
  if (
    isList ||
    text.includes("=") ||
    (WHOLE_NUMBERS.includes(unit) && BEFORE_WHOLE_NUMBERS.some((sign) => value.endsWith(sign)))
  )
    return text;
  return factor ? `(${value})${factor}` : value;
}
