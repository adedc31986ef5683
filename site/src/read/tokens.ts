// Split a text into names, numbers and signs.

import { errorAt } from "./tree.js";
import { compile, LIMITS, VOCABULARY } from "./vocabulary.js";

const { between_tokens: gap, number, name, operator } = VOCABULARY.patterns;
/** Groups: a number, a name, a sign; none for a space or comment. */
const TOKEN = compile(`${gap}|(${number})|(${name})|(${operator})`, "gy");

/** A piece of text; the kind "op" is a sign such as "+" or "(". */
export interface Token {
  readonly kind: "number" | "name" | "op" | "end";
  readonly text: string;
  /** The index of the first character (UTF-16 unit). */
  readonly start: number;
}

/** Return the tokens of a text, the last one of kind "end". Throws ParseError for unknown signs and deep nesting. */
export function splitIntoTokens(text: string): Token[] {
  const tokens: Token[] = [];
  let depth = 0;
  for (let start = 0; start < text.length; start = TOKEN.lastIndex) {
    TOKEN.lastIndex = start;
    const match = TOKEN.exec(text);
    if (!match) throw errorAt("read.sign", { sign: text[start] ?? "" }, text, start);
    const [, digits, name, sign] = match;
    if (digits !== undefined) tokens.push({ kind: "number", text: digits, start });
    else if (name !== undefined) tokens.push({ kind: "name", text: name, start });
    else if (sign !== undefined) {
      tokens.push({ kind: "op", text: sign, start });
      depth += computeDepthChange(sign);
      if (depth > LIMITS.depth) throw errorAt("read.brackets", { limit: LIMITS.depth }, text, start);
    } // else a space or a comment
  }
  return [...tokens, { kind: "end", text: "", start: text.length }];
}

/** Return how a sign changes the depth of nested brackets: 1, 0 or -1. */
export const computeDepthChange = (sign: string): number =>
  sign === "" ? 0 : Number("([{".includes(sign)) - Number(")]}".includes(sign));
