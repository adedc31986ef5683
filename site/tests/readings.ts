// Parse and judge many texts, for a comparison with the results in Python.
//
// tests/tools/readers.py in the checkout writes the same texts with Python's results.
import { createSingularityTest } from "../src/arm/is-singular.js";
import type { Part, Problem } from "../src/bank.js";
import { judge } from "../src/grade/judge.js";
import { parse } from "../src/read/reader.js";
import { type Node, ParseError } from "../src/read/tree.js";

/** Texts to parse, each with the index of its symbols, and answers to judge, each with its problem's index and its part. */
export interface Input {
  readonly symbols: readonly (readonly string[])[];
  readonly readings: readonly (readonly [text: string, symbols: number])[];
  readonly problems: readonly Pick<Problem, "id" | "robot" | "parts">[];
  readonly answers: readonly (readonly [problem: number, part: string, text: string])[];
}

/** Trees as texts, null for texts that can't be parsed; verdicts. */
export interface Results {
  readonly readings: readonly (string | null)[];
  readonly verdicts: readonly ShortVerdict[];
}

export type ShortVerdict = readonly [outcome: string, share: number, sure: boolean];

export function resultsOf({ symbols, readings, problems, answers }: Input): Results {
  const known = symbols.map((listed) => new Set(listed));
  const singular = problems.map(createSingularityTest);
  return {
    readings: readings.map(([text, k]) => treeText(text, known[k]!)),
    verdicts: answers.map(([k, name, text]) => {
      const problem = problems[k] as Problem;
      const part = problem.parts.find((listed) => listed.name === name) as Part;
      const { outcome, share, isSure } = judge(problem, part, text, singular[k]!);
      return [outcome, share, isSure];
    }),
  };
}

export function treeText(text: string, known: ReadonlySet<string>): string | null {
  try {
    return canonical(parse(text, known));
  } catch (error) {
    if (error instanceof ParseError) return null;
    throw error;
  }
}

/** Return a tree as a text, "(kind argument argument)", with exact numbers. */
export function canonical(tree: Node): string {
  const parts: string[] = [];
  const stack: (Node | ")")[] = [tree];
  for (let top = stack.pop(); top; top = stack.pop()) {
    if (top === ")") parts.push(")");
    else if (top.kind === "name") parts.push(` ${top.text}`);
    else if (top.kind === "number" || top.kind === "decimal") parts.push(` ${exactText(top)}`);
    else {
      parts.push(` (${top.kind}${top.kind === "call" ? ` ${top.text}` : ""}`);
      stack.push(")");
      for (let i = top.args.length - 1; i >= 0; i -= 1) stack.push(top.args[i]!);
    }
  }
  return parts.join("").slice(1);
}

/** Return an integer as #digits, or a decimal as #digits times a power of ten. */
function exactText({ kind, text }: Node): string {
  const [mantissa = "", exponent = "0"] = text.toLowerCase().split("e");
  const [whole = "", decimals = ""] = mantissa.split(".");
  const significant = (whole + decimals).replace(/^0+/, "");
  const digits = significant.replace(/0+$/, "");
  if (kind === "number") return `#${significant || 0}`;
  return digits ? `#${digits}e${Number(exponent) - decimals.length + significant.length - digits.length}` : "#0e0";
}
