// Remove the unit m from a formula, unless m is a whole number, as in theta2 = (2m + 1) pi/2. The rules of
// ../../../exercises/formula/metres.py; ../../tests/readers.test.ts compares both.

import type { Kind, Node } from "./tree.js";
import { VOCABULARY, wholePattern } from "./vocabulary.js";

export const METRE = "m";
const ANGLE = wholePattern("angle");
const NUMBER_KINDS: ReadonlySet<Kind> = new Set<Kind>(["number", "decimal"]);
const INVERSES: ReadonlySet<string> = new Set([...Object.values(VOCABULARY.inverses), "atan2"]);
const PRODUCT_KINDS: ReadonlySet<Kind> = new Set<Kind>(["*", "/", "^"]);

/** A visit of a node; each node is visited twice: before its arguments, and when these have been rebuilt. */
interface Visit {
  readonly node: Node;
  readonly areArgsDone: boolean;
  /** Whether m is a whole number here, because it multiplies pi or an angle. */
  readonly isWholeNumber: boolean;
  /** Whether the node is not followed by another factor of the same product. */
  readonly isLast: boolean;
}

/** Return a tree without the unit m after a number, list or product; with pi or an angle, m is an integer. */
export function removeMetres(tree: Node): Node {
  const results: Node[] = [];
  const pending: Visit[] = [{ node: tree, areArgsDone: false, isWholeNumber: false, isLast: true }];
  for (let visit = pending.pop(); visit; visit = pending.pop()) {
    // no recursion, because a long sum is a deep tree
    const { node, areArgsDone, isLast } = visit;
    if (node.args.length === 0) results.push(node);
    else if (areArgsDone) {
      const args = results.splice(results.length - node.args.length);
      const [first, second] = args as [Node, Node];
      const isUnit = node.kind === "*" && !visit.isWholeNumber && isMetre(second) && hasUnit(first, isLast);
      results.push(isUnit ? first : { ...node, args });
    } else {
      const isProduct = PRODUCT_KINDS.has(node.kind);
      const isWholeNumber = node.kind !== "call" && (visit.isWholeNumber || (isProduct && isLast && hasAngle(node)));
      pending.push({ node, areArgsDone: true, isWholeNumber, isLast });
      for (let i = node.args.length - 1; i >= 0; i -= 1)
        pending.push({ node: node.args[i] as Node, areArgsDone: false, isWholeNumber, isLast: !isProduct });
    }
  }
  return results[0] as Node;
}

/** Return whether a node is m or m^2. */
function isMetre({ kind, args: [base, exponent], text }: Node): boolean {
  if (kind === "^" && exponent?.kind === "number" && exponent.value === 2)
    // an area, or a determinant
    return base?.kind === "name" && base.text === METRE;
  return kind === "name" && text === METRE;
}

/**
 * Return whether m can be the unit of the factors before it. If m is the last factor, they may be anything but a whole
 * number's name; else the last of them must be a number, fraction or list.
 */
function hasUnit(factors: Node, isLast: boolean): boolean {
  const { kind, args, text } = factors.kind === "*" ? (factors.args[1] as Node) : factors;
  if (isLast) return kind !== "name" || !VOCABULARY.whole_numbers.includes(text);
  const isFraction = kind === "/" && args.every((arg) => NUMBER_KINDS.has(arg.kind));
  return isFraction || NUMBER_KINDS.has(kind) || kind === "list";
}

/** Return whether pi or an angle is in a product, but not as the argument of a function. */
function hasAngle(product: Node): boolean {
  const stack = [product];
  for (let top = stack.pop(); top; top = stack.pop()) {
    const { kind, text, args } = top;
    if (kind === "name" && (text === "pi" || ANGLE.test(text))) return true;
    if (kind === "call" && INVERSES.has(text)) return true;
    if (kind !== "call") stack.push(...args);
  }
  return false;
}
