// Remove the unit m from a formula, unless m is a whole number, as in theta2 = (2m + 1) pi/2. The rules of
// ../../../exercises/formula/metres.py; ../../tests/readers.test.ts compares both.

import type { Kind, Node } from "./tree.js";
import { VOCABULARY, wholePattern } from "./vocabulary.js";

export const METRE = "m";
const ANGLE = wholePattern("angle");
const SQUARE = 2;
const NUMBERS: ReadonlySet<Kind> = new Set<Kind>(["number", "decimal"]);
const INVERSES: ReadonlySet<string> = new Set([...Object.values(VOCABULARY.inverses), "atan2"]);
const PRODUCTS: ReadonlySet<Kind> = new Set<Kind>(["*", "/", "^"]);

interface Step {
  readonly top: Node;
  readonly isReady: boolean;
  /** Whether m is a whole number here, because it multiplies pi or an angle. */
  readonly isWholeNumber: boolean;
  /** Whether no factor follows. */
  readonly isLast: boolean;
}

/** Return a tree without the unit m after a number, list or product; m times pi or an angle stays, as an integer. */
export function withoutMetres(tree: Node): Node {
  const done: Node[] = [];
  const todo: Step[] = [{ top: tree, isReady: false, isWholeNumber: false, isLast: true }];
  for (let next = todo.pop(); next; next = todo.pop()) {
    // no recursion, because a long sum is a deep tree
    const { top, isReady, isLast } = next;
    if (top.args.length === 0) done.push(top);
    else if (isReady) {
      const args = done.splice(done.length - top.args.length);
      const [first, second] = args as [Node, Node];
      const isUnit = top.kind === "*" && !next.isWholeNumber && isMetre(second) && hasUnit(first, isLast);
      done.push(isUnit ? first : { ...top, args });
    } else {
      const isProduct = PRODUCTS.has(top.kind);
      const isWholeNumber = top.kind !== "call" && (next.isWholeNumber || (isProduct && isLast && hasAngle(top)));
      todo.push({ top, isReady: true, isWholeNumber, isLast });
      for (let i = top.args.length - 1; i >= 0; i -= 1)
        todo.push({ top: top.args[i] as Node, isReady: false, isWholeNumber, isLast: !isProduct });
    }
  }
  return done[0] as Node;
}

function isMetre({ kind, args: [base, exponent], text }: Node): boolean {
  if (kind === "^" && exponent?.kind === "number" && exponent.value === SQUARE)
    return base?.kind === "name" && base.text === METRE;
  return kind === "name" && text === METRE;
}

/** Return whether the factors before m can have it as unit: numbers, fractions, lists; others before the last m. */
function hasUnit(factors: Node, isLast: boolean): boolean {
  const { kind, args, text } = factors.kind === "*" ? (factors.args[1] as Node) : factors;
  if (isLast) return kind !== "name" || !VOCABULARY.whole_numbers.includes(text);
  const isFraction = kind === "/" && args.every((arg) => NUMBERS.has(arg.kind));
  return isFraction || NUMBERS.has(kind) || kind === "list";
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
