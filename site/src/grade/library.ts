// What terms and factors of this subject are made of: lengths, rates, sines and cosines of sums of joint angles.

import { anyNode, call, integer, name, namesIn, type Node, node } from "../read/tree.js";
import { evaluate } from "../read/evaluate.js";
import { anglesIn, angleText } from "./angles.js";
import type { At } from "./verdict.js";

/** So many symbols of a kind are looked at, so many angles of the answer's own, so many for products of three waves. */
const MOST_SYMBOLS = 8;
const MOST_OWN = 8;
const MOST_FOR_THREE = 10;

const LENGTH = /^[ad]\d+$/;
const ANGLE = /^theta\d+$/;
/** Rates, velocities and forces: what else a term may be multiplied by; an answer has those of one kind. */
const RATE = /^qd\d+$/;
const MULTIPLIERS = [RATE, /^[vw][xyz]$/, /^[fm][xyz]$/];

export interface Library {
  /** Sums of successive joint angles, theta1 + theta2 and the like, and angles of the answer, which have constants. */
  readonly angles: readonly Node[];
  readonly lengths: readonly Node[];
  readonly multipliers: readonly Node[];
  /** Sums of successive joint rates. */
  readonly together: readonly Node[];
}

/** A product of the library, as a tree, and what it is worth at a configuration. */
export type Known = { readonly tree: Node; readonly value: number };

/** What an answer may be made of: symbols of the problem, and the decimals of the answer, taken for lengths. */
export function libraryOf(symbols: readonly string[], entries: readonly Node[]): Library {
  const used = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  const decimals = new Map<number, Node>();
  for (const entry of entries)
    anyNode(entry, (each) => (each.kind === "decimal" && decimals.set(each.value, each), false));
  decimals.delete(0);
  const those = (kind: RegExp) =>
    symbols
      .filter((each) => kind.test(each))
      .slice(0, MOST_SYMBOLS)
      .map(name);
  const sums = successive(those(ANGLE));
  const texts = new Set(sums.map(angleText));
  const own = anglesIn(entries).filter((angle) => !texts.has(angleText(angle)));
  const angles = [...sums, ...own.slice(0, MOST_OWN)];
  const multipliers = MULTIPLIERS.filter((kind) => [...used].some((each) => kind.test(each))).flatMap(those);
  const lengths = [...those(LENGTH), ...[...decimals.values()].slice(0, MOST_SYMBOLS)];
  const rates = multipliers.filter(({ text }) => RATE.test(text));
  return { angles, lengths, multipliers, together: successive(rates).filter(({ kind }) => kind === "+") };
}

/** The sums of successive ones, those of one included. */
function successive(names: readonly Node[]): Node[] {
  return names.flatMap((_, first) =>
    names.slice(first).map((_each, more) => sumOf(names.slice(first, first + more + 1))),
  );
}

const sumOf = (terms: readonly Node[]): Node => terms.reduce((total, term) => node("+", total, term));

/** Sines and cosines of the angles at a configuration. */
export function waves({ angles }: Library, at: At): Known[] {
  return angles.flatMap((angle) => [known(call("sin", angle), at), known(call("cos", angle), at)]);
}

export const known = (tree: Node, at: At): Known => ({ tree, value: evaluate(tree, at).re });

/** Terms as Jacobians have them: a length or none, a rate or none where there are any, and sines and cosines. */
export interface Terms {
  readonly multipliers: readonly Known[];
  /** Products of sines and cosines, the smallest first. */
  readonly products: readonly Known[];
}

/** The terms of a library: products of up to two or three sines and cosines, of fewer if there are more than `most`. */
export function termsOf(library: Library, at: At, most = Infinity): Terms {
  const all = waves(library, at);
  const lengths = [ONE, ...library.lengths.map((each) => known(each, at))];
  const rates = [...library.multipliers, ...library.together].map((each) => known(each, at));
  const multipliers = (rates.length > 0 ? rates : [ONE]).flatMap((rate) =>
    lengths.map((length) => times(length, rate)),
  );
  const fewer = library.angles.length <= MOST_FOR_THREE;
  let products = [ONE];
  let last = products.map((product) => ({ product, from: 0 }));
  for (let count = 0; count < (fewer ? 3 : 2); count += 1) {
    last = last.flatMap(({ product, from }) =>
      all.slice(from).map((wave, k) => ({ product: times(product, wave), from: from + k })),
    );
    if ((products.length + last.length) * multipliers.length > most) break;
    products = [...products, ...last.map(({ product }) => product)];
  }
  products.sort((one, other) => Math.abs(one.value) - Math.abs(other.value));
  return { multipliers, products };
}

/** The terms that are worth a value, or its negative, but for a share of it. */
export function* termsNear({ multipliers, products }: Terms, value: number, share: number): Generator<Known> {
  for (const multiplier of multipliers) {
    const due = Math.abs(value / multiplier.value);
    let [low, high] = [0, products.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (Math.abs((products[middle] as Known).value) < due * (1 - share)) low = middle + 1;
      else high = middle;
    }
    for (; low < products.length; low += 1) {
      const product = products[low] as Known;
      if (!(Math.abs(product.value) <= due * (1 + share))) break;
      yield times(product, multiplier);
    }
  }
}

const ONE: Known = { tree: integer(1), value: 1 };

export function times(left: Known, right: Known): Known {
  if (left === ONE) return right;
  return right === ONE ? left : { tree: node("*", left.tree, right.tree), value: left.value * right.value };
}
