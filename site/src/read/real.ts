// Real numbers without mathjs: functions where their values are real, and trees of which every value is.
//
// Values are the same as in mathjs, to the last bit; pages that only draw an arm need nothing else of it.

import { message } from "../text/text.js";
import { type Node, ReadError } from "./tree.js";

/** The value of a function at x, how steep it is there, and whether both are real. */
export interface RealFunction {
  readonly value: (x: number) => number;
  readonly slope: (x: number) => number;
  readonly isReal: (x: number) => boolean;
}

const always = (): boolean => true;
const inside = (x: number): boolean => x > -1 && x < 1;
const positive = (x: number): boolean => x > 0;

export const REAL: Readonly<Record<string, RealFunction>> = {
  sin: { value: Math.sin, slope: Math.cos, isReal: always },
  cos: { value: Math.cos, slope: Math.sin, isReal: always },
  tan: { value: Math.tan, slope: (x) => 1 / (Math.cos(x) * Math.cos(x)), isReal: always },
  exp: { value: Math.exp, slope: Math.exp, isReal: always },
  log: { value: Math.log, slope: (x) => 1 / x, isReal: positive },
  sqrt: { value: Math.sqrt, slope: (x) => 0.5 / Math.sqrt(x), isReal: positive },
  asin: { value: Math.asin, slope: (x) => 1 / Math.sqrt(1 - x * x), isReal: inside },
  acos: { value: Math.acos, slope: (x) => 1 / Math.sqrt(1 - x * x), isReal: inside },
  atan: { value: Math.atan, slope: (x) => 1 / (1 + x * x), isReal: always },
  abs: { value: Math.abs, slope: () => 1, isReal: always },
};

/** Whether x^y is real, and the same for Math.pow as for mathjs. */
export const isRealPower = (x: number, y: number): boolean =>
  Number.isFinite(y) && (x > 0 || Number.isInteger(y));

/** The value of an entry of an arm's table. Throws ReadError for what is no real expression. */
export function realValue(tree: Node, values: Readonly<Record<string, number>>): number {
  const at = (index: number): number => realValue(tree.args[index] as Node, values);
  switch (tree.kind) {
    case "number":
    case "decimal":
      return tree.value;
    case "name":
      return tree.text === "pi" ? Math.PI : tree.text === "E" ? Math.E : (values[tree.text] ?? NaN);
    case "neg":
      return -at(0);
    case "+":
      return at(0) + at(1);
    case "-":
      return at(0) - at(1);
    case "*":
      return at(0) * at(1);
    case "/":
      return at(0) / at(1);
    case "^":
      return at(0) ** at(1);
    case "call":
      return called(
        tree.text,
        tree.args.map((_, i) => at(i)),
      );
    default:
      throw new ReadError("read.no-expression", { what: message("read.a-condition") });
  }
}

function called(name: string, [x = NaN, y = NaN]: readonly number[]): number {
  if (name === "atan2") return Math.atan2(x, y);
  const known = REAL[name];
  if (!known) throw new ReadError("read.function", { name });
  return known.value(x);
}
