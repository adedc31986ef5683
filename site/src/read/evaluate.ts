// Evaluate a tree at a configuration in complex numbers (complex.js), together with the size of its terms.
//
// The size bounds rounding errors: a difference that is small relative to its terms may be zero. Follows
// ../../../exercises/formula/program.py.

import Complex from "complex.js";

import { message, type TextKey } from "../text/text.js";
import { REAL } from "./real.js";
import { type Node, ParseError, type SymbolValues } from "./tree.js";

type Scalar = number | Complex;

/** A complex value, and the size (absolute value) of the terms from which it was computed. */
export type Value = { readonly re: number; readonly im: number; readonly size: number };

const CONSTANTS = new Map<string, Scalar>(Object.entries({ pi: Math.PI, E: Math.E, I: new Complex(0, 1) }));
/** Kinds of nodes that have no value, with the keys of their names. */
const KIND_NAMES: Readonly<Partial<Record<Node["kind"], TextKey>>> = {
  list: "read.a-list",
  set: "read.a-set",
  dict: "read.a-dictionary",
  eq: "read.an-equation",
  blank: "read.a-blank",
};

const toComplex = (x: Scalar): Complex => (typeof x === "number" ? new Complex(x, 0) : x);
// Real numbers stay plain numbers, which are faster than objects.
const plus = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x + y : toComplex(x).add(y);
const times = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x * y : toComplex(x).mul(y);
const dividedBy = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x / y : toComplex(x).div(y);
const minus = (x: Scalar): Scalar => (typeof x === "number" ? -x : x.neg());

/** Return the value of a tree with these values of names, NaN if undefined. Throws ParseError if it is not a scalar. */
export function evaluate(tree: Node, values: SymbolValues): Value {
  const value = evaluateNode(tree, values);
  return typeof value === "number"
    ? { re: value, im: 0, size: latestSize }
    : { re: value.re, im: value.im, size: latestSize };
}

/** The size of the last result of `evaluateNode`. Returning a pair for each node would take longer than everything else. */
let latestSize = 0;

function evaluateNode(tree: Node, values: SymbolValues): Scalar {
  switch (tree.kind) {
    case "number":
    case "decimal":
      latestSize = Math.abs(tree.value);
      return tree.value;
    case "name": {
      const value = CONSTANTS.get(tree.text) ?? (Object.hasOwn(values, tree.text) ? values[tree.text] : NaN) ?? NaN;
      latestSize = absolute(value);
      return value;
    }
    case "neg":
      return minus(evaluateArgument(tree, 0, values));
    case "+":
    case "-":
      return evaluateChain(tree, values, "+-");
    case "*":
    case "/":
      return evaluateChain(tree, values, "*/");
    case "^":
      return evaluatePower(tree, values);
    case "call":
      return evaluateCall(tree, values);
    default:
      throw new ParseError("read.no-expression", { what: message(KIND_NAMES[tree.kind] ?? "read.a-condition") });
  }
}

/** Return the value of a sum or product along its left spine, without recursion: a long one would exhaust the stack. */
function evaluateChain(tree: Node, values: SymbolValues, kinds: string): Scalar {
  const spine: Node[] = [];
  let top = tree;
  for (; kinds.includes(top.kind); top = top.args[0] as Node) spine.push(top);
  let total = evaluateNode(top, values);
  let totalSize = latestSize;
  for (const operation of spine.reverse()) {
    const x = evaluateArgument(operation, 1, values);
    if (operation.kind === "+") total = plus(total, x);
    else if (operation.kind === "-") total = plus(total, minus(x));
    else if (operation.kind === "*") total = times(total, x);
    else total = dividedBy(total, x);
    totalSize =
      kinds === "+-"
        ? totalSize + latestSize
        : (totalSize * latestSize) / (operation.kind === "/" ? absolute(x) ** 2 : 1);
  }
  latestSize = totalSize;
  return total;
}

function evaluateArgument(tree: Node, index: number, values: SymbolValues): Scalar {
  return evaluateNode(tree.args[index] as Node, values);
}

function evaluatePower(tree: Node, values: SymbolValues): Scalar {
  const x = evaluateArgument(tree, 0, values);
  const sizeOfX = latestSize;
  const y = evaluateArgument(tree, 1, values);
  const sizeOfY = latestSize;
  const value = power(x, y);
  if (typeof y === "number" && Number.isInteger(y) && y > 0) {
    latestSize = absolute(x) ** (y - 1) * (absolute(x) + y * sizeOfX);
    return value;
  }
  const exponentTerm =
    sizeOfY === 0 || isWholeNumber(tree.args[1] as Node) ? 0 : absolute(toComplex(x).log()) * sizeOfY;
  latestSize = absolute(value) * (1 + (absolute(y) * sizeOfX) / (absolute(x) || 1) + exponentTerm);
  return value;
}

function power(x: Scalar, y: Scalar): Scalar {
  if (typeof x !== "number" || typeof y !== "number") return toComplex(x).pow(toComplex(y));
  return x < 0 && Number.isFinite(y) && !Number.isInteger(y) ? toComplex(x).pow(y) : x ** y;
}

function isWholeNumber(exponent: Node): boolean {
  return exponent.kind === "number" || (exponent.kind === "neg" && exponent.args[0]?.kind === "number");
}

function evaluateCall(tree: Node, values: SymbolValues): Scalar {
  const x = evaluateArgument(tree, 0, values);
  const sizeOfX = latestSize;
  if (tree.text === "atan2") {
    const y = evaluateArgument(tree, 1, values);
    const areReal = typeof x === "number" && typeof y === "number";
    latestSize = areReal ? 1 + (sizeOfX * Math.abs(y) + latestSize * Math.abs(x)) / (x * x + y * y) : NaN;
    return areReal ? Math.atan2(x, y) : NaN;
  }
  const realFunction = REAL[tree.text];
  if (!realFunction) throw new ParseError("read.function", { name: tree.text });
  if (typeof x === "number" && !(x < realFunction.low || x > realFunction.high)) {
    const value = realFunction.value(x);
    latestSize = Math.abs(value) + Math.abs(realFunction.slope(x)) * sizeOfX;
    return value;
  }
  const apply = (z: Complex): Scalar => (tree.text === "abs" ? absolute(z) : z[tree.text as "sin"]());
  const z = toComplex(x);
  const step = DIFFERENCE_STEP * (1 + absolute(x));
  const value = apply(z);
  const difference = plus(apply(z.add(step)), minus(apply(z.sub(step))));
  latestSize = absolute(value) + (absolute(difference) / (2 * step)) * sizeOfX;
  return value;
}

/** Step of numeric derivatives, relative to the argument if it is large. */
const DIFFERENCE_STEP = 1e-6;

function absolute(value: Scalar): number {
  return typeof value === "number" ? Math.abs(value) : Math.hypot(value.re, value.im);
}
