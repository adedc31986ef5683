// Find the terms of MathML formulas: where a term begins and ends, its joint, and how a reader would type it.

import type { Arm } from "./model.js";

const GREEK: Readonly<Record<string, string>> = { θ: "theta" };

/** Return the letter and the index of an indexed symbol; null for other elements. */
function letterAndIndex(symbol: Element): readonly [letter: string, index: string] | null {
  if (!/^msub(sup)?$/.test(symbol.localName)) return null;
  const [base, index] = symbol.children;
  const [letter, number] = [base?.textContent ?? "", index?.textContent ?? ""];
  return /^\d+$/.test(number) ? [letter.replace(/[\u02d9\u0307]/, "˙"), number] : null;
}

/**
 * Return the joint (from 0) to which a symbol belongs: its angle or displacement, the length of its link, or the
 * column J_i. Null if there is none.
 *
 * A sum of angles, as in c_12, belongs to its last joint. Axes and vectors to P have the index of the frame before:
 * z_0 is the axis of joint 1.
 */
export function jointOf(symbol: Element, arm: Arm): number | null {
  const parts = letterAndIndex(symbol);
  if (!parts) return null;
  const [letter, index] = parts;
  const count = arm.joints.length;
  const joint = Number(index) - 1;
  if (/^[θcs]$/.test(letter) && index.length > 1 && joint >= count) return jointOrNull(Number(index.at(-1)) - 1, count);
  if (/^([θcsadαJ]|[θdq]˙)$/.test(letter)) return jointOrNull(joint, count);
  if (/^[zp]\*?$/.test(letter)) return jointOrNull(joint + 1, count);
  return null;
}

const jointOrNull = (joint: number, count: number): number | null => (joint >= 0 && joint < count ? joint : null);

/** Return all symbols in an element that belong to a joint. */
export function symbolsOf(root: ParentNode, joint: number, arm: Arm): Element[] {
  return [...root.querySelectorAll("math :is(msub, msubsup)")].filter(
    (symbol) => !symbol.closest(".arm") && jointOf(symbol, arm) === joint,
  );
}

/** Signs between terms. */
const SIGNS_BETWEEN_TERMS = new Set(["+", "−", "-", "=", ",", ";", "≠", "≤", "≥", "<", ">", "±", "→", ":", "|"]);
const [OPENING_BRACKETS, CLOSING_BRACKETS] = [new Set(["(", "["]), new Set([")", "]"])];
const ROW_ELEMENTS = new Set(["math", "mrow", "mstyle", "mpadded", "mtd", "semantics"]);

const isSign = (part: Element): boolean => part.localName === "mo" && SIGNS_BETWEEN_TERMS.has(part.textContent!.trim());

/** Return the term that contains an element: the elements between two signs on one level, in order. */
export function termAt(target: Element): Element[] {
  if (isSign(target)) return [];
  let part = target;
  for (let row = part.parentElement; row && part.localName !== "math"; part = row, row = part.parentElement) {
    if (!ROW_ELEMENTS.has(row.localName)) continue;
    const siblings = [...row.children];
    const index = siblings.indexOf(part);
    const [first, last] = [endOfTerm(siblings, index, -1), endOfTerm(siblings, index, 1)];
    const term = siblings.slice(first, last + 1);
    const isProperPart = term.length < siblings.length || row.localName === "math" || row.localName === "mtd";
    if (isProperPart && term.some(({ localName }) => !["mo", "mspace"].includes(localName))) return term;
  }
  return [];
}

/** Return the index at which a term ends in one direction from an element of the term. */
function endOfTerm(siblings: readonly Element[], start: number, step: 1 | -1): number {
  const [enteringBrackets, leavingBrackets] =
    step > 0 ? [OPENING_BRACKETS, CLOSING_BRACKETS] : [CLOSING_BRACKETS, OPENING_BRACKETS];
  const signAt = (i: number): string => (siblings[i]!.localName === "mo" ? siblings[i]!.textContent!.trim() : "");
  let depth = enteringBrackets.has(signAt(start)) ? 1 : 0; // a bracket under the pointer stands for its contents
  let end = start;
  for (let i = start + step; i >= 0 && i < siblings.length; i += step) {
    const sign = signAt(i);
    if (depth === 0 && (SIGNS_BETWEEN_TERMS.has(sign) || leavingBrackets.has(sign))) break;
    if (enteringBrackets.has(sign)) depth += 1;
    else if (leavingBrackets.has(sign)) depth -= 1;
    end = i;
  }
  return end;
}

/** Selector of a letter with an index. */
export const SYMBOL = "msub, msubsup";

/** Return the letters with an index in a term. */
export const symbolsIn = (term: readonly Element[]): Element[] =>
  term.flatMap((part) => [...(part.matches(SYMBOL) ? [part] : []), ...part.querySelectorAll(SYMBOL)]);

/** Return all terms of a formula in order; a term with a bracket comes before the terms in it. */
export function termsOf(math: Element): Element[][] {
  const terms: Element[][] = [];
  for (const leaf of math.querySelectorAll("mi, mn, mo")) {
    const term = termAt(leaf);
    if (term.length > 0 && !terms.some((other) => isSameTerm(other, term))) terms.push(term);
  }
  return terms;
}

/** Return whether two terms are the same. */
export const isSameTerm = (a: readonly Element[], b: readonly Element[]): boolean =>
  a[0] === b[0] && a.length === b.length;

const FUNCTIONS = new Set(["sin", "cos", "tan"]);
const TYPED_SIGNS: Readonly<Record<string, string>> = {
  "−": "-",
  "⋅": "*",
  "·": "*",
  "×": "*",
  "\u2062": "*",
  "\u2061": "",
};

/** Return whether a row is the name of a function with its spacing, as Temml writes it. */
const isFunction = (part: Element): boolean =>
  part.localName === "mrow" && FUNCTIONS.has(part.textContent!.replace(/[\u2061\s]/g, ""));

/** Return parts of a formula as they would be typed; null if that is impossible. */
export function typedText(parts: readonly Element[]): string | null {
  let text = "";
  let isArgument = false; // whether the next part is the argument of a function
  for (const part of parts.flatMap((part) => (isFunction(part) ? [...part.children] : [part]))) {
    if (part.localName === "mspace") continue;
    if (part.localName === "mo") {
      const shownSign = part.textContent!.trim();
      const sign = TYPED_SIGNS[shownSign] ?? shownSign;
      if (!/^[-+*()]?$/.test(sign)) return null;
      if (sign === "(" && !isArgument && /[\w)]$/.test(text)) text += "*";
      if (sign === "(") isArgument = false;
      text += sign;
      continue;
    }
    if (part.localName === "mi" && FUNCTIONS.has(part.textContent!)) {
      text += `${/[\w)]$/.test(text) ? "*" : ""}${part.textContent}`;
      isArgument = true;
      continue;
    }
    const partText = typedPart(part);
    if (partText === null) return null;
    if (partText === "") continue;
    text += isArgument ? `(${partText})` : `${/[\w)]$/.test(text) ? "*" : ""}${partText}`;
    isArgument = false;
  }
  return isArgument ? null : text;
}

/** Return the typed name of an indexed letter; a joint rate is qd1. */
function typedSymbol(part: Element): string | null {
  const [letter = "", index = ""] = letterAndIndex(part) ?? [];
  if (/^[θdq]˙$/.test(letter)) return `qd${index}`;
  return /^[a-zθ]$/.test(letter) ? `${GREEK[letter] ?? letter}${index}` : null;
}

function typedPart(part: Element): string | null {
  const children = [...part.children];
  const [first, second] = children.map((child) => typedText([child]));
  const { localName, textContent } = part;
  if (localName === "mi") return GREEK[textContent!] ?? textContent!;
  if (localName === "mn") return textContent!.replace(",", ".");
  if (localName === "msub") return typedSymbol(part);
  if (localName === "msubsup") {
    const [symbol, power] = [typedSymbol(part), children[2] ? typedText([children[2]]) : null];
    return symbol && power ? `(${symbol})^(${power})` : null;
  }
  if (localName === "msup") return first && second ? `(${first})^(${second})` : null;
  if (localName === "mfrac") return first && second ? `((${first})/(${second}))` : null;
  const inner = typedText(children);
  if (localName === "msqrt") return inner === null ? null : `sqrt(${inner})`;
  if (!["mrow", "mstyle", "mpadded"].includes(localName)) return null;
  return inner === null || !/[-+]/.test(inner) || /^\(.*\)$/.test(inner) ? inner : `(${inner})`;
}
