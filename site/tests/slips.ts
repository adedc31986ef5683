// What the site says of slips that are made in right answers; ../../tests/tools/site_corpus.py keeps their keys current.
import { createSingularityTest } from "../src/arm/is-singular.js";
import type { Part, Problem } from "../src/bank.js";
import { judge } from "../src/grade/judge.js";
import type { Slip, Verdict } from "../src/grade/verdict.js";

type Typed = readonly [part: string, slip: string, text: string];

/** A problem with what is typed: the part's name, the slip's, the text. */
export type Slipped = Pick<Problem, "id" | "robot" | "parts" | "said"> & {
  readonly slips: readonly Typed[];
  /** Two slips at once, with both names. */
  readonly pairs?: readonly Typed[];
};

/** The outcome, the reported mistake, the keys of other messages, and the number of wrong entries without a message. */
export type Outcome = readonly [outcome: string, mistake: string | null, reasons: readonly string[], left: number];

export function outcomesOf(problem: Slipped): readonly Outcome[] {
  const singular = createSingularityTest(problem);
  return problem.slips.map(([name, , text]) => {
    const part = problem.parts.find((each) => each.name === name) as Part;
    const verdict = judge(problem as unknown as Problem, part, text, singular);
    const { outcome, mistake, slips = [], reasons } = verdict;
    return [
      outcome,
      mistake === undefined ? null : (problem.said[mistake]?.[0] ?? null),
      [
        ...slips.map((slip) => ("mistake" in slip ? `slip of ${problem.said[slip.mistake]?.[0]}` : slip.key)),
        ...reasons.map(({ key }) => key),
      ],
      mistake === undefined ? unexplainedCount(verdict) : 0,
    ];
  });
}

/** Return the number of wrong entries without a message. */
function unexplainedCount({ entries = [], slips = [] }: Verdict): number {
  const wrong = entries.flatMap((row, r) => row.flatMap((right, c) => (right ? [] : [[r + 1, c + 1] as const])));
  const columns = entries[0]?.length ?? 1;
  return wrong.filter(([r, c]) => !slips.some((each) => isCovered(r, c, each, columns))).length;
}

function isCovered(r: number, c: number, slip: Slip, columns: number): boolean {
  if ("key" in slip && slip.key === "slip.column-left-out") return slip.values["column"] === c;
  const where = "mistake" in slip ? slip.where : slip.values["where"];
  if (typeof where !== "object") return false;
  if (where.key === "slip.others") return true;
  const { row, column, entries } = where.values;
  if (typeof entries === "string")
    return columns === 1 ? entries.split(", ").includes(`${r}`) : entries.includes(`(${r}, ${c})`);
  if (where.key === "slip.row") return row === r;
  return (where.key !== "slip.entry" || row === r) && (column === undefined || column === c);
}
