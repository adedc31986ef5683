// The same verdicts as the Python grader's on the checked answers of corpus.jsonl (made by `python -m tests.tools.site_corpus`).
import { describe, expect, test } from "vitest";

import type { ValuesKey } from "../src/bank.js";
import { judgeValues } from "../src/grade/values.js";
import { evaluate } from "../src/read/evaluate.js";
import { parse } from "../src/read/reader.js";
import corpus from "./corpus.json" with { type: "json" };

interface Case {
  readonly id: string;
  readonly type: string;
  readonly student: string;
  readonly outcome: string;
  readonly key?: ValuesKey;
}

const CASES = corpus as unknown as readonly Case[];

describe("the corpus", () => {
  test.each(CASES.filter((each) => each.key).map((each) => [each.id, each.student.slice(0, 60), each] as const))(
    "%s: %s",
    (_id, _shown, { key, student, outcome }) => {
      const verdict = judgeValues(student, key as ValuesKey);
      // Where a function has branches the browser may not meet the one that differs, and says so.
      if (verdict.outcome === "correct" && !verdict.isSure) expect(["correct", "wrong"]).toContain(outcome);
      else expect(verdict.outcome).toBe(outcome);
    },
  );

  test("the browser is unsure about few answers, and never wrong about the others", () => {
    const verdicts = CASES.filter((each) => each.key).map(
      (each) => [each, judgeValues(each.student, each.key as ValuesKey)] as const,
    );
    const unsure = verdicts.filter(([, verdict]) => verdict.outcome === "correct" && !verdict.isSure);
    expect(unsure.filter(([each]) => each.outcome === "wrong").map(([each]) => each.student)).toEqual([
      "a1*sin(theta1)+a2*sin(theta1+theta2)+(abs(theta2+3)-(theta2+3))*a2/50", // differs below -3 only
    ]);
    expect(unsure.length).toBeLessThan(20);
  });

  test.each([
    ["sin(th12)", Math.sin(1.1)],
    ["cos(theta_1 + th2)", Math.cos(1.1)],
    ["c12", Math.cos(1.1)],
    ["s2", Math.sin(0.8)],
    ["th1", 0.3],
  ])("short names are read as the angles that they stand for: %s", (typed, value) => {
    const values = { theta1: 0.3, theta2: 0.8 };
    expect(evaluate(parse(typed, new Set(Object.keys(values))), values).re).toBeCloseTo(value, 12);
  });
});
