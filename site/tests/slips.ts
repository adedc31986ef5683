// What the site says of slips that are made in right answers, as ../../tests/tools/site_slips.py writes them.
import { singularIn } from "../src/arm/singular.js";
import type { Part, Problem } from "../src/bank.js";
import { judge } from "../src/grade/judge.js";
import type { Verdict } from "../src/grade/verdict.js";
import type { Message } from "../src/text/text.js";

/** A problem with what is typed: the part's name, the slip's, the text. */
export type Slipped = Pick<Problem, "id" | "robot" | "parts" | "said"> & {
  readonly slips: readonly (readonly [part: string, slip: string, text: string])[];
};

/** The outcome, the name of the mistake that is told, the keys of what else is said, and how many wrong entries nothing is said of. */
export type Told = readonly [
  outcome: string,
  mistake: string | null,
  reasons: readonly string[],
  left: number,
];

export function toldOf(problem: Slipped): readonly Told[] {
  const singular = singularIn(problem);
  return problem.slips.map(([name, , text]) => {
    const part = problem.parts.find((each) => each.name === name) as Part;
    const verdict = judge(problem as unknown as Problem, part, text, singular);
    const { outcome, mistake, slip, reasons } = verdict;
    return [
      outcome,
      mistake === undefined ? null : (problem.said[mistake]?.[0] ?? null),
      [...(slip ? [slip.key] : []), ...reasons.map(({ key }) => key)],
      mistake === undefined ? leftBy(verdict) : 0,
    ];
  });
}

/** How many wrong entries are in no place of which something is said. */
function leftBy({ entries = [], slip }: Verdict): number {
  const said = slip ? [slip] : [];
  const wrong = entries.flatMap((row, r) =>
    row.flatMap((right, c) => (right ? [] : [[r + 1, c + 1] as const])),
  );
  return wrong.filter(([r, c]) => !said.some((each) => isIn(r, c, each, entries[0]?.length ?? 1))).length;
}

function isIn(r: number, c: number, { key, values }: Message, columns: number): boolean {
  if (key === "slip.column-left-out") return values["column"] === c;
  const { where } = values;
  if (typeof where !== "object") return false;
  const { row, column, entries } = where.values;
  if (typeof entries === "string") return entries.includes(columns === 1 ? `${r}` : `(${r}, ${c})`);
  return (row === undefined || row === r) && (column === undefined || column === c);
}

export const allTold = (problems: readonly Slipped[]): readonly (readonly Told[])[] => problems.map(toldOf);
