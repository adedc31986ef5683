// What the site says of slips that are made in right answers, as ../../tests/tools/site_slips.py writes them.
import { singularIn } from "../src/arm/singular.js";
import type { Part, Problem } from "../src/bank.js";
import { judge } from "../src/grade/judge.js";

/** A problem with what is typed: the part's name, the slip's, the text. */
export type Slipped = Pick<Problem, "id" | "robot" | "parts" | "said"> & {
  readonly slips: readonly (readonly [part: string, slip: string, text: string])[];
};

/** The outcome, the names of the mistakes that are told, and the keys of what else is said. */
export type Told = readonly [outcome: string, mistake: string | null, reasons: readonly string[]];

export function toldOf(problem: Slipped): readonly Told[] {
  const singular = singularIn(problem);
  return problem.slips.map(([name, , text]) => {
    const part = problem.parts.find((each) => each.name === name) as Part;
    const { outcome, mistake, slip, reasons } = judge(problem as unknown as Problem, part, text, singular);
    return [
      outcome,
      mistake === undefined ? null : (problem.said[mistake]?.[0] ?? null),
      [...(slip ? [slip.key] : []), ...reasons.map(({ key }) => key)],
    ];
  });
}

export const allTold = (problems: readonly Slipped[]): readonly (readonly Told[])[] => problems.map(toldOf);
