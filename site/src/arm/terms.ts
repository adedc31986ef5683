// Find the terms of MathML formulas: where a term begins and ends, its joint, and how it would be typed.

import type { Arm } from "./model.js";

const GREEK: Readonly<Record<string, string>> = { θ: "theta" };

/** The letter of a symbol with an index, and the index; null for what is none. */
function partsOf(symbol: Element): readonly [letter: string, index: string] | null {
  if (!/^msub(sup)?$/.test(symbol.localName)) return null;
  const [base, index] = symbol.children;
  const [letter, number] = [base?.textContent ?? "", index?.textContent ?? ""];
  return /^\d+$/.test(number) ? [letter.replace(/[\u02d9\u0307]/, "˙"), number] : null;
}

/**
 * The joint (from 0) that a symbol is about: whose angle or slide it is, whose link has the length, whose column is
 * J_i.
 *
 * Sums of angles, as in c_12, are the direction of the last joint's link. Axes and vectors to P are counted from the
 * frame before: z_0 is the axis of joint 1.
 */
export function jointOf(symbol: Element, arm: Arm): number | null {
  const parts = partsOf(symbol);
  if (!parts) return null;
  const [letter, index] = parts;
  const count = arm.joints.length;
  const own = Number(index) - 1;
  if (/^[θcs]$/.test(letter) && index.length > 1 && own >= count) return inRange(Number(index.at(-1)) - 1, count);
  if (/^([θcsadαJ]|[θdq]˙)$/.test(letter)) return inRange(own, count);
  if (/^[zp]\*?$/.test(letter)) return inRange(own + 1, count);
  return null;
}

const inRange = (joint: number, count: number): number | null => (joint >= 0 && joint < count ? joint : null);

/** All symbols in an element that are about a joint. */
export function symbolsOf(root: ParentNode, joint: number, arm: Arm): Element[] {
  return [...root.querySelectorAll("math :is(msub, msubsup)")].filter(
    (symbol) => !symbol.closest(".arm") && jointOf(symbol, arm) === joint,
  );
}

/** Signs between terms. */
const BETWEEN = new Set(["+", "−", "-", "=", ",", ";", "≠", "≤", "≥", "<", ">", "±", "→", ":", "|"]);
const [OPEN, CLOSED] = [new Set(["(", "["]), new Set([")", "]"])];
const ROWS = new Set(["math", "mrow", "mstyle", "mpadded", "mtd", "semantics"]);

const isSign = (part: Element): boolean => part.localName === "mo" && BETWEEN.has(part.textContent!.trim());

/** The term in which something of a formula stands: what lies between two signs, on one level, in order. */
export function termAt(target: Element): Element[] {
  if (isSign(target)) return [];
  let part = target;
  for (let row = part.parentElement; row && part.localName !== "math"; part = row, row = part.parentElement) {
    if (!ROWS.has(row.localName)) continue;
    const all = [...row.children];
    const at = all.indexOf(part);
    const [first, last] = [reach(all, at, -1), reach(all, at, 1)];
    const found = all.slice(first, last + 1);
    const isPart = found.length < all.length || row.localName === "math" || row.localName === "mtd";
    if (isPart && found.some(({ localName }) => !["mo", "mspace"].includes(localName))) return found;
  }
  return [];
}

/** How far a term goes in one direction from a place in it. */
function reach(all: readonly Element[], at: number, step: 1 | -1): number {
  const [into, out] = step > 0 ? [OPEN, CLOSED] : [CLOSED, OPEN];
  const signAt = (i: number): string => (all[i]!.localName === "mo" ? all[i]!.textContent!.trim() : "");
  let depth = into.has(signAt(at)) ? 1 : 0; // a bracket that is pointed at has what is in it
  let end = at;
  for (let i = at + step; i >= 0 && i < all.length; i += step) {
    const sign = signAt(i);
    if (depth === 0 && (BETWEEN.has(sign) || out.has(sign))) break;
    if (into.has(sign)) depth += 1;
    else if (out.has(sign)) depth -= 1;
    end = i;
  }
  return end;
}

/** A letter with an index. */
export const SYMBOL = "msub, msubsup";

/** The letters with an index in a term. */
export const symbolsIn = (term: readonly Element[]): Element[] =>
  term.flatMap((part) => [...(part.matches(SYMBOL) ? [part] : []), ...part.querySelectorAll(SYMBOL)]);

/** All terms of a formula, in order; one with a bracket comes before those in it. */
export function termsOf(math: Element): Element[][] {
  const found: Element[][] = [];
  for (const leaf of math.querySelectorAll("mi, mn, mo")) {
    const term = termAt(leaf);
    if (term.length > 0 && !found.some((other) => isSame(other, term))) found.push(term);
  }
  return found;
}

/** Whether two terms are the same. */
export const isSame = (one: readonly Element[], other: readonly Element[]): boolean =>
  one[0] === other[0] && one.length === other.length;

const FUNCTIONS = new Set(["sin", "cos", "tan"]);
const SIGNS: Readonly<Record<string, string>> = { "−": "-", "⋅": "*", "·": "*", "×": "*", "\u2062": "*", "\u2061": "" };

/** Whether a row is the name of a function with what sets it apart, as Temml has it. */
const isFunction = (part: Element): boolean =>
  part.localName === "mrow" && FUNCTIONS.has(part.textContent!.replace(/[\u2061\s]/g, ""));

/** Parts of a formula as they would be typed; null where that can't be done. */
export function typed(parts: readonly Element[]): string | null {
  let text = "";
  let called = false; // whether what comes is what a sine is of
  for (const part of parts.flatMap((part) => (isFunction(part) ? [...part.children] : [part]))) {
    if (part.localName === "mspace") continue;
    if (part.localName === "mo") {
      const raw = part.textContent!.trim();
      const sign = SIGNS[raw] ?? raw;
      if (!/^[-+*()]?$/.test(sign)) return null;
      if (sign === "(" && !called && /[\w)]$/.test(text)) text += "*";
      if (sign === "(") called = false;
      text += sign;
      continue;
    }
    if (part.localName === "mi" && FUNCTIONS.has(part.textContent!)) {
      text += `${/[\w)]$/.test(text) ? "*" : ""}${part.textContent}`;
      called = true;
      continue;
    }
    const one = typedPart(part);
    if (one === null) return null;
    if (one === "") continue;
    text += called ? `(${one})` : `${/[\w)]$/.test(text) ? "*" : ""}${one}`;
    called = false;
  }
  return called ? null : text;
}

/** A letter with an index by its name, the rate of a joint as qd1. */
function typedSymbol(part: Element): string | null {
  const [letter = "", index = ""] = partsOf(part) ?? [];
  if (/^[θdq]˙$/.test(letter)) return `qd${index}`;
  return /^[a-zθ]$/.test(letter) ? `${GREEK[letter] ?? letter}${index}` : null;
}

function typedPart(part: Element): string | null {
  const children = [...part.children];
  const [first, second] = children.map((child) => typed([child]));
  const { localName, textContent } = part;
  if (localName === "mi") return GREEK[textContent!] ?? textContent!;
  if (localName === "mn") return textContent!.replace(",", ".");
  if (localName === "msub") return typedSymbol(part);
  if (localName === "msubsup") {
    const [symbol, power] = [typedSymbol(part), children[2] ? typed([children[2]]) : null];
    return symbol && power ? `(${symbol})^(${power})` : null;
  }
  if (localName === "msup") return first && second ? `(${first})^(${second})` : null;
  if (localName === "mfrac") return first && second ? `((${first})/(${second}))` : null;
  const inner = typed(children);
  if (localName === "msqrt") return inner === null ? null : `sqrt(${inner})`;
  if (!["mrow", "mstyle", "mpadded"].includes(localName)) return null;
  return inner === null || !/[-+]/.test(inner) || /^\(.*\)$/.test(inner) ? inner : `(${inner})`;
}
