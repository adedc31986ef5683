// Split a text into names, numbers and signs.

import { errorAt } from "./tree.js";
import { compile, LIMITS, VOCABULARY } from "./vocabulary.js";

const { between_tokens: gap, number, name, operator } = VOCABULARY.patterns;
const TOKEN = compile(`${gap}|(${number})|(${name})|(${operator})`, "gy");

export type Token = { readonly kind: "number" | "name" | "op" | "end"; readonly text: string; readonly at: number };

/** Return the tokens of a text, the last one of kind "end". Throws ParseError for unknown signs and deep nesting. */
export function tokensOf(text: string): Token[] {
  const tokens: Token[] = [];
  let depth = 0;
  for (let at = 0; at < text.length; at = TOKEN.lastIndex) {
    TOKEN.lastIndex = at;
    const match = TOKEN.exec(text);
    if (!match) throw errorAt("read.sign", { sign: text[at] ?? "" }, text, at);
    const [, digits, called, sign] = match;
    if (digits !== undefined) tokens.push({ kind: "number", text: digits, at });
    else if (called !== undefined) tokens.push({ kind: "name", text: called, at });
    else if (sign !== undefined) {
      tokens.push({ kind: "op", text: sign, at });
      depth += deeperBy(sign);
      if (depth > LIMITS.depth) throw errorAt("read.brackets", { most: LIMITS.depth }, text, at);
    } // else a space or a comment
  }
  return [...tokens, { kind: "end", text: "", at: text.length }];
}

/** Return the change of nesting depth at a sign. */
export const deeperBy = (sign: string): number =>
  sign === "" ? 0 : Number("([{".includes(sign)) - Number(")]}".includes(sign));
