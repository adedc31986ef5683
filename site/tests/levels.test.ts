// What a level of feedback keeps back of a verdict, as grader/reports/feedback_levels.py does.
import { expect, test } from "vitest";

import type { NumbersKey, ValuesKey } from "../src/bank.js";
import { type Level, LEVELS, chooseLowerLevel, limitVerdict } from "../src/grade/levels.js";
import { judgeNumbers } from "../src/grade/numbers.js";
import { judgeValues } from "../src/grade/values.js";
import { verdictOf, type Verdict, wrong } from "../src/grade/verdict.js";
import { message, textOf } from "../src/text/text.js";

const NUMBERS: NumbersKey = {
  type: "numbers",
  units: ["rad/s", "rad/s"],
  tolerance: 0.001,
  floor: 1e-9,
  right: [1.25, 7.75],
  mistakes: [[4, 1.25, -7.75]],
};
const FORMULA: ValuesKey = {
  type: "values",
  symbols: ["theta1"],
  points: [[0.5], [1.5]],
  rows: 1,
  columns: 1,
  right: [[0.479425538604203, 0.997494986604054]],
  mistakes: [],
};
const WRONG: readonly (readonly [string, Verdict, RegExp])[] = [
  ["a number", judgeNumbers("[1.25, -7.75]", NUMBERS), /\b7[.]75\b(?<!−7[.]75)/],
  ["a formula", judgeValues("cos(theta1)", FORMULA, []), /0[.]4794|0[.]9974/],
  [
    "a set",
    verdictOf(0.5, [message("verdict.uncovered", { at: "theta1 = 0.123" })], { counterexample: { theta1: 0.123 } }),
    /0[.]123/,
  ],
];
const text = (verdict: Verdict): string => verdict.reasons.map((reason) => textOf(reason)).join(" ");

test("the lower of two levels is the one that reveals less", () => {
  expect(chooseLowerLevel("solutions", "counterexample")).toBe("counterexample");
  expect(chooseLowerLevel("mistake", "counterexample")).toBe("mistake");
});

test.each(WRONG)("%s: each level reveals more", (_, verdict, right) => {
  const at = (level: Level): Verdict => limitVerdict(verdict, level);
  expect(text(at("values"))).toMatch(right);
  expect(at("solutions")).toEqual(verdict);
  for (const level of ["outcome", "mistake", "counterexample"] as const) {
    expect(text(at(level))).not.toMatch(right);
    expect([at(level).outcome, at(level).share]).toEqual([verdict.outcome, verdict.share]);
  }
  expect(text(at("mistake"))).not.toMatch(/\d[.]\d/);
  expect(at("mistake").counterexample).toBeUndefined();
  expect(at("mistake").mistake).toBe(verdict.mistake);
  expect(at("outcome").reasons).toEqual([]);
  expect(at("outcome").mistake).toBeUndefined();
  expect(at("outcome").entries).toBeUndefined();
});

test("a counterexample belongs to the answer; a missing configuration is not shown", () => {
  const [, formula, set] = WRONG.map(([, verdict]) => limitVerdict(verdict, "counterexample")) as [
    Verdict,
    Verdict,
    Verdict,
  ];
  expect(text(formula)).toContain("your value is 0.877");
  expect(formula.counterexample).toBeDefined();
  expect(set.counterexample).toBeUndefined();
});

test("right answers and answers that can't be parsed get the full feedback", () => {
  for (const level of LEVELS) {
    expect(limitVerdict(judgeNumbers("[1.25, 7.75]", NUMBERS), level).reasons).not.toEqual([]);
    expect(text(limitVerdict(wrong("read.unreadable", { why: message("read.missing") }), level))).not.toBe("");
  }
});
