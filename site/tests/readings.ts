// What the site's reader and its grader say of many texts: held against what Python's say of them.
//
// tests/tools/readers.py in the checkout writes the question and the same answers in the same forms.
import { singularIn } from "../src/arm/is-singular.js";
import type { Part, Problem } from "../src/bank.js";
import { judge } from "../src/grade/judge.js";
import { parse } from "../src/read/reader.js";
import { type Node, ParseError } from "../src/read/tree.js";

/** Texts to be read, each with the index of its symbols, and answers to be judged, with a problem's index and a part's name. */
export interface Asked {
  readonly symbols: readonly (readonly string[])[];
  readonly readings: readonly (readonly [text: string, symbols: number])[];
  readonly problems: readonly Pick<Problem, "id" | "robot" | "parts">[];
  readonly answers: readonly (readonly [problem: number, part: string, text: string])[];
}

/** Trees as texts, null for what is refused; outcomes with the share of the points, and whether the browser is sure. */
export interface Answered {
  readonly readings: readonly (string | null)[];
  readonly verdicts: readonly Judged[];
}

export type Judged = readonly [outcome: string, share: number, sure: boolean];

export function answered({ symbols, readings, problems, answers }: Asked): Answered {
  const known = symbols.map((each) => new Set(each));
  const singular = problems.map(singularIn);
  return {
    readings: readings.map(([text, k]) => treeText(text, known[k]!)),
    verdicts: answers.map(([k, name, text]) => {
      const problem = problems[k] as Problem;
      const part = problem.parts.find((each) => each.name === name) as Part;
      const { outcome, share, sure } = judge(problem, part, text, singular[k]!);
      return [outcome, share, sure];
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

/** A tree as a text: (kind inner inner), names as they are, numbers exactly. */
export function canonical(tree: Node): string {
  const parts: string[] = [];
  const todo: (Node | ")")[] = [tree];
  for (let top = todo.pop(); top; top = todo.pop()) {
    if (top === ")") parts.push(")");
    else if (top.kind === "name") parts.push(` ${top.text}`);
    else if (top.kind === "number" || top.kind === "decimal") parts.push(` ${exactly(top)}`);
    else {
      parts.push(` (${top.kind}${top.kind === "call" ? ` ${top.text}` : ""}`);
      todo.push(")");
      for (let i = top.args.length - 1; i >= 0; i -= 1) todo.push(top.args[i]!);
    }
  }
  return parts.join("").slice(1);
}

/** A number as #digits or, where it is a decimal, as #digits times a power of ten. */
function exactly({ kind, text }: Node): string {
  const [mantissa = "", exponent = "0"] = text.toLowerCase().split("e");
  const [whole = "", behind = ""] = mantissa.split(".");
  const all = (whole + behind).replace(/^0+/, "");
  const digits = all.replace(/0+$/, "");
  if (kind === "number") return `#${all || 0}`;
  return digits ? `#${digits}e${Number(exponent) - behind.length + all.length - digits.length}` : "#0e0";
}
