// The terms and factors that answers consist of: lengths, rates, and sines and cosines of sums of joint angles.

import { call, integer, name, findNames, type Node, node, type SymbolValues, visitNodes } from "../read/tree.js";
import { evaluate } from "../read/evaluate.js";
import { findAngles, makeAngleKey } from "./angles.js";

/**
 * Maximum number of symbols of one kind, and of the answer's own angles; and the number of angles up to which products
 * of three sines or cosines are considered, too.
 */
const MAX_SYMBOLS = 8;
const MAX_OWN_ANGLES = 8;
const MAX_ANGLES_FOR_THREE = 10;

const LENGTH = /^[ad]\d+$/;
const ANGLE = /^theta\d+$/;
/** Symbols of rates (qd1), velocities (vx, wz), and forces or moments (fx, mz). The terms of an answer usually contain symbols of one of these kinds. */
const RATE = /^qd\d+$/;
const MULTIPLIERS = [RATE, /^[vw][xyz]$/, /^[fm][xyz]$/];

/** The expressions from which terms are built. */
export interface Library {
  /** Sums of successive joint angles, as theta1 + theta2, and angles of the answer with constants. */
  readonly angles: readonly Node[];
  /** Symbols of lengths, and decimals of the answer. */
  readonly lengths: readonly Node[];
  /** Rates, velocities, and forces or moments. */
  readonly multipliers: readonly Node[];
  /** Sums of successive joint rates. */
  readonly rateSums: readonly Node[];
}

/** A product of the library, as a tree, and its value at a configuration. */
export type ValuedTree = { readonly tree: Node; readonly value: number };

/** Return what terms may consist of: symbols of the problem, and decimals of the answer, which count as lengths. */
export function buildLibrary(symbols: readonly string[], entries: readonly Node[]): Library {
  const usedNames = findNames(...entries);
  const decimals = new Map<number, Node>();
  for (const entry of entries) visitNodes(entry, (term) => term.kind === "decimal" && decimals.set(term.value, term));
  decimals.delete(0);
  const symbolsOf = (kind: RegExp) =>
    symbols
      .filter((symbol) => kind.test(symbol))
      .slice(0, MAX_SYMBOLS)
      .map(name);
  const angleSums = listSuccessiveSums(symbolsOf(ANGLE));
  const sumTexts = new Set(angleSums.map(makeAngleKey));
  const ownAngles = findAngles(entries).filter((angle) => !sumTexts.has(makeAngleKey(angle)));
  const angles = [...angleSums, ...ownAngles.slice(0, MAX_OWN_ANGLES)];
  const multipliers = MULTIPLIERS.filter((kind) => [...usedNames].some((symbol) => kind.test(symbol))).flatMap(
    symbolsOf,
  );
  const lengths = [...symbolsOf(LENGTH), ...[...decimals.values()].slice(0, MAX_SYMBOLS)];
  const rates = multipliers.filter(({ text }) => RATE.test(text));
  return { angles, lengths, multipliers, rateSums: listSuccessiveSums(rates).filter(({ kind }) => kind === "+") };
}

/** Return the sums of successive nodes, including each node alone. */
function listSuccessiveSums(names: readonly Node[]): Node[] {
  return names.flatMap((_, start) =>
    names.slice(start).map((_each, count) => addNodes(names.slice(start, start + count + 1))),
  );
}

const addNodes = (terms: readonly Node[]): Node => terms.reduce((total, term) => node("+", total, term));

/** Return sines and cosines of the angles with their values at a configuration. */
export function listWaves({ angles }: Library, configuration: SymbolValues): ValuedTree[] {
  return angles.flatMap((angle) => [
    evaluateTree(call("sin", angle), configuration),
    evaluateTree(call("cos", angle), configuration),
  ]);
}

/** Return a tree with its value at a configuration. */
export const evaluateTree = (tree: Node, configuration: SymbolValues): ValuedTree => ({
  tree,
  value: evaluate(tree, configuration).re,
});

/** Terms of Jacobians: each is a multiplier times a product. */
export interface Terms {
  /** Products of a length or none, and a rate, velocity or force if there are any. */
  readonly multipliers: readonly ValuedTree[];
  /** Products of sines and cosines, sorted by absolute value. */
  readonly products: readonly ValuedTree[];
}

/** Return terms with products of up to two or three sines and cosines; of fewer if there were more than `maxTerms`. */
export function buildTerms(library: Library, configuration: SymbolValues, maxTerms = Infinity): Terms {
  const waves = listWaves(library, configuration);
  const lengths = [ONE, ...library.lengths.map((length) => evaluateTree(length, configuration))];
  const rates = [...library.multipliers, ...library.rateSums].map((rate) => evaluateTree(rate, configuration));
  const multipliers = (rates.length > 0 ? rates : [ONE]).flatMap((rate) =>
    lengths.map((length) => multiplyTerms(length, rate)),
  );
  const allowsThree = library.angles.length <= MAX_ANGLES_FOR_THREE;
  let products = [ONE];
  let longestProducts = products.map((product) => ({ product, lastWave: 0 })); // waves by their indices
  for (let count = 0; count < (allowsThree ? 3 : 2); count += 1) {
    longestProducts = longestProducts.flatMap(({ product, lastWave }) =>
      waves.slice(lastWave).map((wave, k) => ({ product: multiplyTerms(product, wave), lastWave: lastWave + k })),
    );
    if ((products.length + longestProducts.length) * multipliers.length > maxTerms) break;
    products = [...products, ...longestProducts.map(({ product }) => product)];
  }
  products.sort((a, b) => Math.abs(a.value) - Math.abs(b.value));
  return { multipliers, products };
}

/** Yield the terms whose absolute value equals that of `value`, up to a tolerance relative to it. */
export function* findTermsNear(
  { multipliers, products }: Terms,
  value: number,
  tolerance: number,
): Generator<ValuedTree> {
  for (const multiplier of multipliers) {
    const target = Math.abs(value / multiplier.value);
    let [low, high] = [0, products.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (Math.abs((products[middle] as ValuedTree).value) < target * (1 - tolerance)) low = middle + 1;
      else high = middle;
    }
    for (; low < products.length; low += 1) {
      const product = products[low] as ValuedTree;
      if (!(Math.abs(product.value) <= target * (1 + tolerance))) break;
      yield multiplyTerms(product, multiplier);
    }
  }
}

const ONE: ValuedTree = { tree: integer(1), value: 1 };

/** Return the product of two terms; a factor 1 is left out. */
export function multiplyTerms(left: ValuedTree, right: ValuedTree): ValuedTree {
  if (left === ONE) return right;
  return right === ONE ? left : { tree: node("*", left.tree, right.tree), value: left.value * right.value };
}
