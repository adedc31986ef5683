// Evaluate expressions in real numbers. Pages that only draw an arm need no complex numbers, and do not load them.

import { message } from "../text/text.js";
import { type Node, ParseError, type SymbolValues } from "./tree.js";

type RealMap = (x: number) => number;

interface RealFunction {
  readonly value: RealMap;
  /** The derivative, up to a sign. */
  readonly slope: RealMap;
  /** The function is real from `low` to `high`. */
  readonly low: number;
  readonly high: number;
}

const realFunction = (value: RealMap, slope: RealMap, low = -Infinity, high = Infinity): RealFunction => ({
  value,
  slope,
  low,
  high,
});
const { sin, cos, tan, exp, sinh, cosh, tanh } = Math;
const slopeOfArcSine = (x: number): number => 1 / Math.sqrt(1 - x * x);
const slopeOfArcTangent = (x: number): number => 1 / (1 + x * x);

/** Functions by name; complex.js has methods of the same names. */
export const REAL: Readonly<Record<string, RealFunction>> = {
  sin: realFunction(sin, cos),
  cos: realFunction(cos, sin),
  tan: realFunction(tan, (x) => 1 / cos(x) ** 2),
  cot: realFunction((x) => 1 / tan(x), (x) => 1 / sin(x) ** 2), // prettier-ignore
  sec: realFunction((x) => 1 / cos(x), (x) => sin(x) / cos(x) ** 2), // prettier-ignore
  csc: realFunction((x) => 1 / sin(x), (x) => cos(x) / sin(x) ** 2), // prettier-ignore
  asin: realFunction(Math.asin, slopeOfArcSine, -1, 1),
  acos: realFunction(Math.acos, slopeOfArcSine, -1, 1),
  atan: realFunction(Math.atan, slopeOfArcTangent),
  acot: realFunction((x) => Math.atan(1 / x), slopeOfArcTangent),
  sinh: realFunction(sinh, cosh),
  cosh: realFunction(cosh, sinh),
  tanh: realFunction(tanh, (x) => 1 / cosh(x) ** 2),
  exp: realFunction(exp, exp),
  log: realFunction(Math.log, (x) => 1 / x, 0),
  sqrt: realFunction(Math.sqrt, (x) => 0.5 / Math.sqrt(x), 0),
  abs: realFunction(Math.abs, () => 1),
  sign: realFunction(Math.sign, () => 0),
};

/** Return the value of an entry of an arm's table. Throws ParseError if it is not a real expression. */
export function evaluateRealTree(tree: Node, values: SymbolValues): number {
  const { kind, text } = tree;
  const [x = NaN, y = NaN] = tree.args.map((arg) => evaluateRealTree(arg, values));
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
  const functionOfName = REAL[text];
  if (!functionOfName) throw new ParseError("read.function", { name: text });
  return functionOfName.value(x);
}
