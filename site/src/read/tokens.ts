// A text as its words, numbers and signs.

import { placed } from "./tree.js";
import { compiled, LIMITS, VOCABULARY } from "./vocabulary.js";

const { passed, number, name, operator } = VOCABULARY.patterns;
const TOKEN = compiled(`${passed}|(${number})|(${name})|(${operator})`, "gy");

export type Token = { readonly kind: "number" | "name" | "op" | "end"; readonly text: string; readonly at: number };

/** The tokens of a text, the last of kind "end". Throws ReadError for unknown signs, and brackets too deep. */
export function tokensOf(text: string): Token[] {
  const found: Token[] = [];
  let depth = 0;
  for (let at = 0; at < text.length; at = TOKEN.lastIndex) {
    TOKEN.lastIndex = at;
    const match = TOKEN.exec(text);
    if (!match) throw placed("read.sign", { sign: text[at] ?? "" }, text, at);
    const [, digits, called, sign] = match;
    if (digits !== undefined) found.push({ kind: "number", text: digits, at });
    else if (called !== undefined) found.push({ kind: "name", text: called, at });
    else if (sign !== undefined) {
      found.push({ kind: "op", text: sign, at });
      depth += deeperBy(sign);
      if (depth > LIMITS.depth) throw placed("read.brackets", { most: LIMITS.depth }, text, at);
    } // else a space or a remark
  }
  return [...found, { kind: "end", text: "", at: text.length }];
}

/** How much deeper in brackets a text is behind a sign. */
export const deeperBy = (sign: string): number =>
  sign === "" ? 0 : Number("([{".includes(sign)) - Number(")]}".includes(sign));
