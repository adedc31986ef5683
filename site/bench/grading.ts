// What bench/pages.mjs runs in the browser: the site's grader on the corpus, each answer timed.
import type { ValuesKey } from "../src/bank.js";
import { judgeValues } from "../src/grade/values.js";

interface Case {
  readonly student: string;
  readonly key?: ValuesKey;
}

/** Returns the milliseconds that each answer of the corpus takes; the first ones are done twice, to be warm. */
export function timed(text: string): number[] {
  const cases = (JSON.parse(text) as Case[]).filter(({ key }) => key);
  for (const { student, key } of cases.slice(0, 20)) judgeValues(student, key!);
  return cases.map(({ student, key }) => {
    const start = performance.now();
    judgeValues(student, key!);
    return performance.now() - start;
  });
}
