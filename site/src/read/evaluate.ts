// The value of a tree at a configuration, with the size of its terms: complex arithmetic by mathjs.
//
// The size says what rounding may have done to a value: a difference that is small beside the size of what was added
// up may be no difference. It follows ../../../exercises/formula/program.py. Where all is real, the numbers are the processor's
// own: they are the same, and mathjs takes ten times as long to find out what it was given.

import { type Complex, create, type FactoryFunctionMap } from "mathjs";

import type { TextKey } from "../text/en.js";
import { message } from "../text/text.js";
import * as pieces from "./arithmetic.js";
import { isRealPower, REAL } from "./real.js";
import { type Node, ReadError } from "./tree.js";

const math = create(pieces as FactoryFunctionMap);

type Scalar = number | Complex;

/** A value and the size of the terms that it was made of. */
export interface Value {
  readonly re: number;
  readonly im: number;
  readonly size: number;
}

const CONSTANTS = new Map<string, Scalar>([
  ["pi", Math.PI],
  ["E", Math.E],
  ["I", math.complex(0, 1)],
]);
/** Kinds of nodes that have no value, by what they are called. */
const NAMES: Readonly<Partial<Record<Node["kind"], TextKey>>> = {
  list: "read.a-list",
  set: "read.a-set",
  dict: "read.a-dictionary",
  eq: "read.an-equation",
  blank: "read.a-blank",
};

const bothReal = (x: Scalar, y: Scalar): boolean => typeof x === "number" && typeof y === "number";
const plus = (x: Scalar, y: Scalar): Scalar =>
  bothReal(x, y) ? (x as number) + (y as number) : (math.add(x, y) as Scalar);
const times = (x: Scalar, y: Scalar): Scalar =>
  bothReal(x, y) ? (x as number) * (y as number) : (math.multiply(x, y) as Scalar);
const over = (x: Scalar, y: Scalar): Scalar =>
  bothReal(x, y) ? (x as number) / (y as number) : (math.divide(x, y) as Scalar);
const minus = (x: Scalar): Scalar => (typeof x === "number" ? -x : (math.unaryMinus(x) as Scalar));

const one = (x: Scalar): Scalar => math.divide(1, x) as Scalar;
const squared = (x: Scalar): Scalar => math.multiply(x, x) as Scalar;
const rest = (x: Scalar): Scalar => math.sqrt(math.subtract(1, squared(x)) as number) as Scalar;

/** Each function, and how steep it is: both as in mathjs, complex where it has to be. */
const FUNCTIONS: Readonly<Record<string, readonly [(x: Scalar) => Scalar, (x: Scalar) => Scalar]>> = {
  sin: [(x) => math.sin(x as number), (x) => math.cos(x as number)],
  cos: [(x) => math.cos(x as number), (x) => math.sin(x as number)],
  tan: [(x) => math.tan(x as number), (x) => one(squared(math.cos(x as number)))],
  exp: [(x) => math.exp(x as number), (x) => math.exp(x as number)],
  log: [(x) => math.log(x as number) as Scalar, one],
  sqrt: [(x) => math.sqrt(x as number) as Scalar, (x) => math.divide(0.5, math.sqrt(x as number)) as Scalar],
  asin: [(x) => math.asin(x as number) as Scalar, (x) => one(rest(x))],
  acos: [(x) => math.acos(x as number) as Scalar, (x) => one(rest(x))],
  atan: [(x) => math.atan(x as number) as Scalar, (x) => one(math.add(1, squared(x)) as Scalar)],
  sinh: [(x) => math.sinh(x as number), (x) => math.cosh(x as number)],
  cosh: [(x) => math.cosh(x as number), (x) => math.sinh(x as number)],
  tanh: [(x) => math.tanh(x as number), (x) => one(squared(math.cosh(x as number)))],
  abs: [(x) => absolute(x), () => 1],
  cot: [(x) => one(math.tan(x as number)), (x) => one(squared(math.sin(x as number)))],
  sec: [
    (x) => one(math.cos(x as number)),
    (x) => math.divide(math.sin(x as number), squared(math.cos(x as number))) as Scalar,
  ],
  csc: [
    (x) => one(math.sin(x as number)),
    (x) => math.divide(math.cos(x as number), squared(math.sin(x as number))) as Scalar,
  ],
  acot: [(x) => math.atan(one(x) as number) as Scalar, (x) => one(math.add(1, squared(x)) as Scalar)],
  sign: [(x) => (absolute(x) === 0 ? 0 : (math.divide(x, absolute(x)) as Scalar)), () => 0],
};

/** The value of a tree where names have these values; what is undefined is nan. Throws ReadError for what is no scalar. */
export function evaluate(tree: Node, values: Readonly<Record<string, number>>): Value {
  const value = valued(tree, values);
  return typeof value === "number" ? { re: value, im: 0, size } : { re: value.re, im: value.im, size };
}

/** The size of what `valued` told last: a pair for each node would take longer than all else. */
let size = 0;

function valued(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  switch (tree.kind) {
    case "number":
    case "decimal":
      size = Math.abs(tree.value);
      return tree.value;
    case "name": {
      const value =
        CONSTANTS.get(tree.text) ?? (Object.hasOwn(values, tree.text) ? values[tree.text] : NaN) ?? NaN;
      size = absolute(value);
      return value;
    }
    case "neg":
      return minus(inner(tree, 0, values));
    case "+":
    case "-":
      return sum(tree, values);
    case "*":
    case "/":
      return product(tree, values);
    case "^":
      return power(tree, values);
    case "call":
      return called(tree, values);
    default:
      throw new ReadError("read.no-expression", { what: message(NAMES[tree.kind] ?? "read.a-condition") });
  }
}

/** A sum, along its left spine: a long one would exhaust the stack. */
function sum(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const spine: Node[] = [];
  let top = tree;
  for (; top.kind === "+" || top.kind === "-"; top = top.args[0] as Node) spine.push(top);
  let total = valued(top, values);
  let all = size;
  for (let k = spine.length - 1; k >= 0; k -= 1) {
    const each = spine[k] as Node;
    const x = inner(each, 1, values);
    total = plus(total, each.kind === "+" ? x : minus(x));
    all += size;
  }
  size = all;
  return total;
}

/** A product or quotient, along its left spine, too. */
function product(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const spine: Node[] = [];
  let top = tree;
  for (; top.kind === "*" || top.kind === "/"; top = top.args[0] as Node) spine.push(top);
  let total = valued(top, values);
  let all = size;
  for (let k = spine.length - 1; k >= 0; k -= 1) {
    const each = spine[k] as Node;
    const y = inner(each, 1, values);
    all = each.kind === "*" ? all * size : (all * size) / absolute(y) ** 2;
    total = each.kind === "*" ? times(total, y) : over(total, y);
  }
  size = all;
  return total;
}

function inner(tree: Node, index: number, values: Readonly<Record<string, number>>): Scalar {
  return valued(tree.args[index] as Node, values);
}

function power(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const x = inner(tree, 0, values);
  const mx = size;
  const y = inner(tree, 1, values);
  const my = size;
  const value = powered(x, y);
  if (typeof y === "number" && Number.isInteger(y) && y > 0) {
    size = absolute(x) ** (y - 1) * (absolute(x) + y * mx);
    return value;
  }
  const varies =
    my === 0 || isWhole(tree.args[1] as Node) ? 0 : absolute(math.log(x as number) as Scalar) * my;
  size = absolute(value) * (1 + (absolute(y) * mx) / (absolute(x) || 1) + varies);
  return value;
}

function powered(x: Scalar, y: Scalar): Scalar {
  if (x === 0 && y === 0) return 1;
  if (typeof x === "number" && typeof y === "number" && isRealPower(x, y)) return x ** y;
  return math.pow(x as number, y as number) as Scalar;
}

function isWhole(exponent: Node): boolean {
  return exponent.kind === "number" || (exponent.kind === "neg" && exponent.args[0]?.kind === "number");
}

function called(tree: Node, values: Readonly<Record<string, number>>): Scalar {
  const x = inner(tree, 0, values);
  const mx = size;
  if (tree.text === "atan2") {
    const y = inner(tree, 1, values);
    const real = typeof x === "number" && typeof y === "number";
    size = real ? 1 + (mx * Math.abs(y) + size * Math.abs(x)) / (x * x + y * y) : NaN;
    return real ? Math.atan2(x, y) : NaN;
  }
  const real = typeof x === "number" ? REAL[tree.text] : undefined;
  if (typeof x === "number" && real?.isReal(x)) {
    const value = real.value(x);
    size = Math.abs(value) + Math.abs(real.slope(x)) * mx;
    return value;
  }
  const known = FUNCTIONS[tree.text];
  if (!known) throw new ReadError("read.function", { name: tree.text });
  const value = known[0](x);
  size = absolute(value) + absolute(known[1](x)) * mx;
  return value;
}

function absolute(value: Scalar): number {
  return typeof value === "number" ? Math.abs(value) : Math.hypot(value.re, value.im);
}
