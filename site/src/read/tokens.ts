// A text as its words, numbers and signs.

import { placed } from "./tree.js";
import { compiled, LIMITS, VOCABULARY } from "./vocabulary.js";

const { passed, number, name, operator } = VOCABULARY.patterns;
/** All that there is; what most texts are made of is found without it, ten times as fast. */
const TOKEN = compiled(`${passed}|(${number})|(${name})|(${operator})`, "gy");

export interface Token {
  readonly kind: "number" | "name" | "op" | "end";
  readonly text: string;
  readonly at: number;
}

/** Signs that stand for themselves, whatever follows, and those that do unless they stand twice. */
const ALONE = new Set("+-/%^()[]{},:;&|±");
const TWICE = new Set("*=");

/** The tokens of a text, the last of kind "end". Throws ReadError for signs that mean nothing, and brackets too deep. */
export function tokensOf(text: string): Token[] {
  const found: Token[] = [];
  let depth = 0;
  let at = 0;
  while (at < text.length) {
    const token = plainToken(text, at) ?? anyToken(text, at);
    if (typeof token === "number") {
      at = token; // a space or a remark
      continue;
    }
    found.push(token);
    const { kind, text: sign } = token;
    if (kind === "op") {
      if (sign === "(" || sign === "[" || sign === "{") depth += 1;
      else if (sign === ")" || sign === "]" || sign === "}") depth -= 1;
      if (depth > LIMITS.depth) throw placed("read.brackets", { most: LIMITS.depth }, text, at);
    }
    at += sign.length;
  }
  found.push({ kind: "end", text: "", at });
  return found;
}

/** A token of plain letters, plain digits or a sign; null where it takes a second look. */
function plainToken(text: string, at: number): Token | null {
  const first = text.charCodeAt(at);
  if (isDigit(first)) {
    let end = at + 1;
    while (isDigit(text.charCodeAt(end))) end += 1;
    return ".eE".includes(text.charAt(end)) && end < text.length
      ? null
      : { kind: "number", text: text.slice(at, end), at };
  }
  if (isLetter(first)) {
    let end = at + 1;
    let next = text.charCodeAt(end);
    while (isLetter(next) || isDigit(next)) next = text.charCodeAt((end += 1));
    return next > 127 || text[end] === "." ? null : { kind: "name", text: text.slice(at, end), at };
  }
  const sign = text.charAt(at);
  const alone = ALONE.has(sign) || (TWICE.has(sign) && text[at + 1] !== sign);
  return alone ? { kind: "op", text: sign, at } : null;
}

const isDigit = (code: number): boolean => code >= 48 && code <= 57;
const isLetter = (code: number): boolean =>
  (code >= 97 && code <= 122) || (code >= 65 && code <= 90) || code === 95;

/** Any token by the grammar's own words; for what is none, where it ends. */
function anyToken(text: string, at: number): Token | number {
  TOKEN.lastIndex = at;
  const match = TOKEN.exec(text);
  if (!match) throw placed("read.sign", { sign: text[at] ?? "" }, text, at);
  const [, digits, called, op] = match;
  if (digits !== undefined) return { kind: "number", text: digits, at };
  if (called !== undefined) return { kind: "name", text: called, at };
  return op === undefined ? TOKEN.lastIndex : { kind: "op", text: op, at };
}
