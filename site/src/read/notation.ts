// What people bring along, turned into the plain text that the grammar reads: LaTeX, typography, units.
// The same rules as in ../../../exercises/formula/notation.py; tests hold both against the corpus.

import { latexAsText } from "./latex.js";

const LONGEST_LATEX = 20_000;
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺";
const PLAIN_SUPERSCRIPTS = "0123456789-+";
const SIGNS: Readonly<Record<string, string>> = {
  "−": "-",
  "–": "-",
  "×": "*",
  "·": "*",
  "⋅": "*",
  "∗": "*",
  "÷": "/",
  "…": "...",
  "√": "sqrt",
  ḋ: "qd",
  "′": "'",
  "½": "(1/2)",
  "⅓": "(1/3)",
  "⅔": "(2/3)",
  "¼": "(1/4)",
  "¾": "(3/4)",
  "⅛": "(1/8)",
  "\u00a0": " ",
  "\u2009": " ",
};
const UNITS: Readonly<Record<string, string>> = {
  m: "",
  rad: "",
  "m/s": "",
  "rad/s": "",
  N: "",
  Nm: "",
  "N*m": "",
  "N m": "",
  cm: "/100",
  mm: "/1000",
  deg: "*pi/180",
  degree: "*pi/180",
  degrees: "*pi/180",
};
const WORD = "[\\p{L}\\p{N}_]";
const UNIT_NAMES = Object.keys(UNITS)
  .sort((a, b) => b.length - a.length)
  .map((unit) => unit.replace("*", "\\*"));
const UNIT_AT_END = new RegExp(
  `(?<=[\\p{L}\\p{N}_)\\]}])(?:\\s*\\*\\s*|\\s+)(${UNIT_NAMES.join("|")})$`,
  "u",
);
/** So near to the end of a text a unit begins. */
const LAST = 30;

/** What stands before the result, a unit in brackets behind it, degrees inside it, roots by their sign. */
const HABITS: readonly (readonly [RegExp, string])[] = [
  [/^(\s{0,9}\${0,2}) ?(?:\\?det ?[({]? ?J ?[)}]?|(?:\\left)?\|J(?:\\right)?\|) ?=(?!=)/, "$1"],
  [/(?<=[\p{L}\p{N}_)\]}])\s?\[(?:m|rad|m\/s|rad\/s)\]\s*$/u, ""],
  [/(?<![\p{L}\p{N}_.])(\d{1,9}(?:\.\d{1,12})?) ?deg(?:rees?)?\b/gu, "($1*pi/180)"],
  [/(?:√ ?|(?<![A-Za-z_\\])sqrt)(\d{1,9}(?:\.\d{1,12})?)(?![\d.])/g, "sqrt($1)"],
  [new RegExp(`√ ?((?!\\d)${WORD}{1,21})(?!${WORD})`, "gu"), "sqrt($1)"],
];

const LONG = 2000;
const MANY = 100;
const SYMBOLS_IN_A_ROW = /(?:[-+]\s{0,2}(?!\d)[\p{L}\p{N}_]+(?![\p{L}\p{N}_.([{])\s{0,2})+/gu;

/** + a1 - a1 + a1 … with equal symbols counted; the first and the last may belong to what stands beside them. */
function counted(row: string, known: ReadonlySet<string>): string {
  const terms = [...row.matchAll(/([-+])\s*([\p{L}\p{N}_]+)/gu)].map(([, sign = "", symbol = ""]) => ({
    sign,
    symbol,
  }));
  const inner = terms.slice(1, -1);
  const first = terms[0];
  const last = terms.at(-1);
  if (terms.length < MANY || !first || !last || inner.some(({ symbol }) => !known.has(symbol))) return row;
  const counts = new Map<string, number>();
  for (const { sign, symbol } of inner)
    counts.set(symbol, (counts.get(symbol) ?? 0) + (sign === "+" ? 1 : -1));
  const sums = [...counts].map(([symbol, count]) => `${count < 0 ? "-" : "+"}${Math.abs(count)}*${symbol}`);
  return `${first.sign}${first.symbol}${sums.join("")}${last.sign}${last.symbol}`;
}

/** An answer in plain text; the names that are `known` are never taken for units. */
export function plain(answer: string, known: ReadonlySet<string>): string {
  let text = answer.length > LONG ? answer.replace(SYMBOLS_IN_A_ROW, (row) => counted(row, known)) : answer;
  for (const [pattern, meant] of HABITS) text = text.replace(pattern, meant);
  const latex = ["\\", "_{", "^{"].some((mark) => text.includes(mark)) && text.length <= LONGEST_LATEX;
  // eslint-disable-next-line no-control-regex
  const ascii = /^[\x00-\x7f]*$/.test(text);
  const last = text.at(-1) ?? "";
  if (ascii && !latex && !".;\n$".includes(last) && !/[A-Za-z]/.test(last)) return ofJoints(text);
  text = text.replace(new RegExp(`[${SUPERSCRIPTS}]+`, "g"), (found) => `^(${fromSuperscript(found)})`);
  text = text.replace(/(?:θ|q|d|theta|ϑ)\u0307_?/g, "qd");
  text = [...text].map((sign) => SIGNS[sign] ?? sign).join("");
  text = /^\s*(\$\$?)([^$]*)\1\s*$/.exec(text)?.[2] ?? text;
  if (latex) text = latexAsText(text);
  return withoutUnit(ofJoints(withoutEnd(text).replaceAll("°", "*pi/180")), known);
}

function fromSuperscript(text: string): string {
  return [...text].map((sign) => PLAIN_SUPERSCRIPTS[[...SUPERSCRIPTS].indexOf(sign)]).join("");
}

const JOINT = "(?:theta|th|q|θ|ϑ)_?(\\d)";
const RATES = new RegExp(
  `\\(\\( ?d ?${JOINT} ?\\)/\\( ?d ?t ?\\)\\)|\\(\\( ?d ?\\)/\\( ?d ?t ?\\)\\) ?${JOINT}` +
    `|\\bd ?${JOINT} ?/ ?d ?t\\b|(?<!${WORD})${JOINT}(?:\\(t\\))?'`,
  "gu",
);
const VECTORS =
  /\b(?:(q|theta|th)|(?:qd|dq|qp|qdot|q_dot|dtheta|thetadot|theta_dot))(?:\[([0-8])\]|\(([1-9])\))/g;

/**
 * A text with rates written as derivatives, and joints as the entries q[0] or q(1) of a vector, by name. In brackets
 * the first joint has the number 0, as in Python; in parentheses 1, as in Matlab.
 */
function ofJoints(answer: string): string {
  let text = answer;
  if (text.includes("'") || (text.includes("/") && text.includes("t"))) {
    text = text.replace(RATES, (...found: unknown[]) => ` qd${found.slice(1, 5).find((digit) => digit)} `);
  }
  if (text.includes(".diff")) text = text.replaceAll("(t).diff", ".diff");
  return text.replace(VECTORS, (_, joint?: string, fromNought?: string, fromOne?: string) => {
    const number = fromNought === undefined ? fromOne : Number(fromNought) + 1;
    return `${joint ? "q" : "qd"}${number}`;
  });
}

/** A text without the semicolon or full stop that ends a statement or a sentence. */
function withoutEnd(answer: string): string {
  const text = answer.trimEnd();
  const ends = text.endsWith(";") || (text.endsWith(".") && !text.endsWith(".."));
  return ends ? text.slice(0, -1).trimEnd() : text;
}

function withoutUnit(text: string, known: ReadonlySet<string>): string {
  const from = Math.max(0, text.length - LAST - 1);
  const found = UNIT_AT_END.exec(text.slice(from));
  const unit = found?.[1];
  if (!found || unit === undefined || known.has(unit)) return text;
  const factor = UNITS[unit] ?? "";
  const rest = text.slice(0, from + found.index);
  // A list can't be scaled, and in theta2 = pi*m the m is any whole number.
  if (
    (factor && "[{".includes(rest[0] ?? " ")) ||
    text.includes("=") ||
    (unit === "m" && /(pi|π)$/.test(rest))
  )
    return text;
  return factor ? `(${rest})${factor}` : rest;
}

/** A matrix whose rows end with semicolons, [a, b; c, d], as nested lists; any other text as it is. */
export function rowsOfSemicolons(text: string): string {
  const inner = text.trim();
  const ends = `${inner[0] ?? ""}${inner.at(-1) ?? ""}`;
  if (!inner.includes(";") || inner.length < 2 || !["[]", "{}", "()"].includes(ends)) return text;
  const rows = inner.slice(1, -1).split(";");
  return `[${rows
    .filter((row) => row.trim())
    .map((row) => `[${row}]`)
    .join(", ")}]`;
}
