// Evaluate expressions in real numbers. Pages that only draw an arm need no complex numbers, and do not load them.

import { message } from "../text/text.js";
import { type Node, ParseError } from "./tree.js";

type Real = (x: number) => number;

/** A function of a real number, its derivative up to a sign, and the interval on which its values are real. */
interface RealFunction {
  readonly value: Real;
  readonly slope: Real;
  readonly from: number;
  readonly to: number;
}

const real = (value: Real, slope: Real, from = -Infinity, to = Infinity): RealFunction => ({ value, slope, from, to });
const { sin, cos, tan, exp, sinh, cosh, tanh } = Math;
const slopeOfArcSine = (x: number): number => 1 / Math.sqrt(1 - x * x);
const slopeOfArcTangent = (x: number): number => 1 / (1 + x * x);

/** Functions by name; complex.js has methods of the same names. */
export const REAL: Readonly<Record<string, RealFunction>> = {
  sin: real(sin, cos),
  cos: real(cos, sin),
  tan: real(tan, (x) => 1 / cos(x) ** 2),
  cot: real((x) => 1 / tan(x), (x) => 1 / sin(x) ** 2), // prettier-ignore
  sec: real((x) => 1 / cos(x), (x) => sin(x) / cos(x) ** 2), // prettier-ignore
  csc: real((x) => 1 / sin(x), (x) => cos(x) / sin(x) ** 2), // prettier-ignore
  asin: real(Math.asin, slopeOfArcSine, -1, 1),
  acos: real(Math.acos, slopeOfArcSine, -1, 1),
  atan: real(Math.atan, slopeOfArcTangent),
  acot: real((x) => Math.atan(1 / x), slopeOfArcTangent),
  sinh: real(sinh, cosh),
  cosh: real(cosh, sinh),
  tanh: real(tanh, (x) => 1 / cosh(x) ** 2),
  exp: real(exp, exp),
  log: real(Math.log, (x) => 1 / x, 0),
  sqrt: real(Math.sqrt, (x) => 0.5 / Math.sqrt(x), 0),
  abs: real(Math.abs, () => 1),
  sign: real(Math.sign, () => 0),
};

/** Return the value of an entry of an arm's table. Throws ParseError if it is no real expression. */
export function realValue(tree: Node, values: Readonly<Record<string, number>>): number {
  const { kind, text } = tree;
  const [x = NaN, y = NaN] = tree.args.map((arg) => realValue(arg, values));
  if (kind === "number" || kind === "decimal") return tree.value;
  if (kind === "name") return text === "pi" ? Math.PI : text === "E" ? Math.E : (values[text] ?? NaN);
  if (kind === "neg") return -x;
  if (kind === "+") return x + y;
  if (kind === "-") return x - y;
  if (kind === "*") return x * y;
  if (kind === "/") return x / y;
  if (kind === "^") return x ** y;
  if (kind !== "call") throw new ParseError("read.no-expression", { what: message("read.a-condition") });
  if (text === "atan2") return Math.atan2(x, y);
  const known = REAL[text];
  if (!known) throw new ParseError("read.function", { name: text });
  return known.value(x);
}
