// bench/pages.mjs runs this in the browser: it grades the corpus with the site's grader, and times each answer.
import type { ValuesKey } from "../src/bank.js";
import { judgeValues } from "../src/grade/values.js";

interface Case {
  readonly student: string;
  readonly key?: ValuesKey;
}

/** Return the milliseconds that each answer of the corpus takes; the first answers run twice, as a warm-up. */
export function timed(text: string): number[] {
  const cases = (JSON.parse(text) as Case[]).filter(({ key }) => key);
  for (const { student, key } of cases.slice(0, 20)) judgeValues(student, key!);
  return cases.map(({ student, key }) => {
    const start = performance.now();
    judgeValues(student, key!);
    return performance.now() - start;
  });
}
