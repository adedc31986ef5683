// The value of a tree at a configuration, with the size of its terms: complex arithmetic by complex.js.
//
// The size bounds rounding errors: a difference that is small relative to its terms may be zero. Follows
// ../../../exercises/formula/program.py.

import Complex from "complex.js";

import { message, type TextKey } from "../text/text.js";
import { REAL } from "./real.js";
import { type Node, ParseError } from "./tree.js";

type Scalar = number | Complex;

/** A value, and the size of the terms from which it was computed. */
export type Value = { readonly re: number; readonly im: number; readonly size: number };

const CONSTANTS = new Map<string, Scalar>(Object.entries({ pi: Math.PI, E: Math.E, I: new Complex(0, 1) }));
/** Kinds of nodes without a value, with their names. */
const NAMES: Readonly<Partial<Record<Node["kind"], TextKey>>> = {
  list: "read.a-list",
  set: "read.a-set",
  dict: "read.a-dictionary",
  eq: "read.an-equation",
  blank: "read.a-blank",
};

const complex = (x: Scalar): Complex => (typeof x === "number" ? new Complex(x, 0) : x);
const plus = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x + y : complex(x).add(y);
const times = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x * y : complex(x).mul(y);
const over = (x: Scalar, y: Scalar): Scalar =>
  typeof x === "number" && typeof y === "number" ? x / y : complex(x).div(y);
const minus = (x: Scalar): Scalar => (typeof x === "number" ? -x : x.neg());

/** Return the value of a tree with these values of names, NaN if undefined. Throws ParseError if it is no scalar. */
export function evaluate(tree: Node, values: Readonly<Record<string, number>>): Value {
  const value = valueOf(tree, values);
  return typeof value === "number" ? { re: value, im: 0, size } : { re: value.re, im: value.im, size };
}

/** The size of the last result of `valueOf`. Returning a pair for each node would take longer than everything else. */
let size = 0;

function valueOf(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  switch (tree.kind) {
    case "number":
    case "decimal":
      size = Math.abs(tree.value);
      return tree.value;
    case "name": {
      const value = CONSTANTS.get(tree.text) ?? (Object.hasOwn(values, tree.text) ? values[tree.text] : NaN) ?? NaN;
      size = absolute(value);
      return value;
    }
    case "neg":
      return minus(inner(tree, 0, values));
    case "+":
    case "-":
      return chainValue(tree, values, "+-");
    case "*":
    case "/":
      return chainValue(tree, values, "*/");
    case "^":
      return powerValue(tree, values);
    case "call":
      return callValue(tree, values);
    default:
      throw new ParseError("read.no-expression", { what: message(NAMES[tree.kind] ?? "read.a-condition") });
  }
}

/** Return the value of a sum or product along its left spine, without recursion: a long one would exhaust the stack. */
function chainValue(tree: Node, values: Readonly<Record<string, number>>, kinds: string): Scalar {
  const spine: Node[] = [];
  let top = tree;
  for (; kinds.includes(top.kind); top = top.args[0] as Node) spine.push(top);
  let total = valueOf(top, values);
  let totalSize = size;
  for (const operation of spine.reverse()) {
    const x = inner(operation, 1, values);
    if (operation.kind === "+") total = plus(total, x);
    else if (operation.kind === "-") total = plus(total, minus(x));
    else if (operation.kind === "*") total = times(total, x);
    else total = over(total, x);
    totalSize =
      kinds === "+-" ? totalSize + size : (totalSize * size) / (operation.kind === "/" ? absolute(x) ** 2 : 1);
  }
  size = totalSize;
  return total;
}

function inner(tree: Node, index: number, values: Readonly<Record<string, number>>): Scalar {
  return valueOf(tree.args[index] as Node, values);
}

function powerValue(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const x = inner(tree, 0, values);
  const mx = size;
  const y = inner(tree, 1, values);
  const my = size;
  const value = raise(x, y);
  if (typeof y === "number" && Number.isInteger(y) && y > 0) {
    size = absolute(x) ** (y - 1) * (absolute(x) + y * mx);
    return value;
  }
  const varies = my === 0 || isWhole(tree.args[1] as Node) ? 0 : absolute(complex(x).log()) * my;
  size = absolute(value) * (1 + (absolute(y) * mx) / (absolute(x) || 1) + varies);
  return value;
}

function raise(x: Scalar, y: Scalar): Scalar {
  if (typeof x !== "number" || typeof y !== "number") return complex(x).pow(complex(y));
  return x < 0 && Number.isFinite(y) && !Number.isInteger(y) ? complex(x).pow(y) : x ** y;
}

function isWhole(exponent: Node): boolean {
  return exponent.kind === "number" || (exponent.kind === "neg" && exponent.args[0]?.kind === "number");
}

function callValue(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const x = inner(tree, 0, values);
  const mx = size;
  if (tree.text === "atan2") {
    const y = inner(tree, 1, values);
    const real = typeof x === "number" && typeof y === "number";
    size = real ? 1 + (mx * Math.abs(y) + size * Math.abs(x)) / (x * x + y * y) : NaN;
    return real ? Math.atan2(x, y) : NaN;
  }
  const real = REAL[tree.text];
  if (!real) throw new ParseError("read.function", { name: tree.text });
  if (typeof x === "number" && !(x < real.from || x > real.to)) {
    const value = real.value(x);
    size = Math.abs(value) + Math.abs(real.slope(x)) * mx;
    return value;
  }
  const of = (z: Complex): Scalar => (tree.text === "abs" ? absolute(z) : z[tree.text as "sin"]());
  const [z, step] = [complex(x), 1e-6 * (1 + absolute(x))];
  const value = of(z);
  const change = plus(of(z.add(step)), minus(of(z.sub(step))));
  size = absolute(value) + (absolute(change) / (2 * step)) * mx;
  return value;
}

function absolute(value: Scalar): number {
  return typeof value === "number" ? Math.abs(value) : Math.hypot(value.re, value.im);
}
