// Slips that are made in right answers, and what they are called: only what was made is named.
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";

import type { ConfigurationsKey, ValuesKey } from "../src/bank.js";
import { told } from "../src/grade/levels.js";
import { judgeSet } from "../src/grade/sets.js";
import { judgeValues } from "../src/grade/values.js";
import { evaluate } from "../src/read/evaluate.js";
import { read } from "../src/read/reader.js";
import { said } from "../src/text/text.js";
import { type Slipped, toldOf } from "./slips.js";

const PROBLEMS = JSON.parse(
  readFileSync(new URL("./slips.json", import.meta.url), "utf-8"),
) as readonly Slipped[];

/** What a slip may be called; an angle's sign is an angle, and in one sine or cosine throughout is once. */
const CALLED: Readonly<Record<string, readonly string[]>> = {
  "sine for cosine": ["slip.quarter-turn"],
  "sine for cosine, one place": ["slip.wave"],
  "sine for cosine, column": ["slip.wave", "slip.all-waves"],
  "sine for cosine, throughout": ["slip.wave", "slip.all-waves"],
  "relative angle, one place": ["slip.relative"],
  "relative angle, column": ["slip.relative"],
  "relative angle, throughout": ["slip.relative"],
  "length missing, one place": ["slip.length-missing"],
  "length missing, column": ["slip.length-missing"],
  "length missing, throughout": ["slip.length-missing"],
  "sign of a term, one place": ["slip.sign", "slip.angle", "slip.whole-sign"],
  "sign of an entry": ["slip.whole-sign"],
  "sign of a column": ["slip.whole-sign"],
  "column dropped": ["slip.column-left-out"],
  "contribution dropped": ["slip.term-missing", "slip.zero"],
  "term dropped, one place": ["slip.term-missing", "slip.zero"],
  "factor missing": ["slip.length-missing", "slip.lengths-missing", "slip.factor-missing"],
  "condition left out": ["slip.half-turn"],
  "degrees for radians": ["slip.degrees"],
  "quarter turn": ["slip.quarter-turn"],
  "another joint": ["slip.other-joint", "slip.half-turn"],
};

test.each(PROBLEMS.map((problem) => [problem.id, problem] as const))(
  "most slips in answers to %s are named, and by no other name",
  (_, problem) => {
    const outcomes = toldOf(problem);
    const slips = problem.slips.map(([part, slip], i) => ({
      part,
      slip: slip.replace(/ \w+ missing/, " missing"),
      mistake: outcomes[i]![1],
      called: outcomes[i]![2].find((key) => key.startsWith("slip.")) ?? null,
    }));
    expect(outcomes.filter(([outcome]) => outcome === "correct")).toEqual([]);
    const others = slips.filter(({ slip, called }) => called !== null && !CALLED[slip]?.includes(called));
    expect(others).toEqual([]);
    const named = slips.filter(({ mistake, called }) => mistake !== null || called !== null);
    expect(named.length).toBeGreaterThan(0.88 * slips.length);
  },
);

const SYMBOLS = ["a1", "a2", "theta1", "theta2"];
const POINTS = [
  [0.5, 0.3, 0.31, -1.2],
  [1.2, 0.7, -2, 0.8],
  [0.9, 1.4, 1.1, 2.3],
];

/** A key of these formulas, row by row. */
function keyOf(rows: readonly (readonly string[])[]): ValuesKey {
  const at = (k: number) => Object.fromEntries(SYMBOLS.map((symbol, i) => [symbol, POINTS[k]![i]!]));
  const worth = (text: string) => POINTS.map((_, k) => evaluate(read(text, new Set(SYMBOLS)), at(k)).re);
  const right = rows.flat().map(worth);
  const [columns, mistakes] = [rows[0]!.length, []];
  return { type: "values", symbols: SYMBOLS, points: POINTS, rows: rows.length, columns, right, mistakes };
}

const JACOBIAN = keyOf([
  ["-a1*s1 - a2*s12", "-a2*s12"],
  ["a1*c1 + a2*c12", "a2*c12"],
]);

test.each([
  ["[[-a1*s1 - a2*s12, -a2*s2], [a1*c1 + a2*c12, a2*c2]]", "Column 2: an angle lacks"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*s12, a2*c12]]", "Entry (2, 1): in one place sine and cosine"],
  ["[[-s1 - a2*s12, -a2*s12], [c1 + a2*c12, a2*c12]]", "Column 1: a length is missing"],
  ["[[-a2*s12, -a2*s12], [a2*c12, a2*c12]]", "Column 1: a term is missing"],
  ["[[a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12]]", "Entry (1, 1): one sign"],
  ["[[-s1 - s12, -a2*s12], [c1 + c12, a2*c12]]", "Column 1: several lengths are missing"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, 0]]", "Entry (2, 2): zero, where something else is due"],
  ["[[-a1*s1 - a2*s12, 0], [a1*c1 + a2*c12, 0]]", "Column 2 is left out"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a1*c12, a2*c12]]", "Entry (2, 1): one symbol"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*(c1 + c12), a2*c12]]", undefined],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12 + a2*c2, a2*c12]]", "Entry (2, 1): there is a term too"],
  ["[[3*a1*s2, 7], [a1^3, 7*a2*s1*s2]]", undefined],
])("%s is told: %s", (typed, says) => {
  const { slip, outcome } = judgeValues(typed, JACOBIAN);
  expect(outcome).not.toBe("correct");
  if (says === undefined) expect(slip && said(slip)).toBeUndefined();
  else expect(slip && said(slip)).toContain(says);
});

test.each([
  ["a1*a2*c2", "Your answer: in one place"],
  ["a1*s2", "Your answer: a length is missing"],
  ["s2", "Your answer: several lengths are missing"],
  ["a1*a2", "Your answer: a factor with a joint"],
  ["2*a1*a2*s2", "Your answer: there is a factor too many"],
  ["a1*a2*s1*c2", undefined],
])("of a determinant %s is told: %s", (typed, says) => {
  const { slip } = judgeValues(typed, keyOf([["a1*a2*s2"]]));
  if (says === undefined) expect(slip).toBeUndefined();
  else expect(slip && said(slip)).toContain(says);
});

test("a bracket that is missing in a quotient is told", () => {
  const { slip } = judgeValues("a1*c1 + c12", keyOf([["a1*(c1 + c12)"]]));
  expect(slip?.key).toBe("slip.bracket");
});

const SET: ConfigurationsKey = {
  type: "configurations",
  joints: ["theta1", "theta2"],
  symbols: SYMBOLS,
  mistakes: [],
  pieces: [0, Math.PI].map((value) => POINTS.map(([a1, a2, theta1]) => [a1!, a2!, theta1!, value])),
};
const ANGLES = new Set(SET.joints);
const straight = (at: Readonly<Record<string, number>>) => Math.abs(Math.sin(at["theta2"]!)) < 1e-6;

test.each([
  ["theta2 = 0", "slip.half-turn"],
  ["theta2 = 0, theta2 = 180", "slip.degrees"],
  ["theta2 = pi/2, theta2 = -pi/2", "slip.quarter-turn"],
  ["theta1 = 0, theta1 = pi", "slip.other-joint"],
  ["theta2 = 1, theta2 = 2", undefined],
  ["theta1 = 1", undefined],
])("of the set %s is told %s", (typed, key) => {
  expect(judgeSet(typed, SET, ANGLES, straight).slip?.key).toBe(key);
});

test("a level that names no mistakes keeps slips back", () => {
  const verdict = judgeValues("a1*s2", keyOf([["a1*a2*s2"]]));
  expect(told(verdict, "outcome").slip).toBeUndefined();
  expect(told(verdict, "mistake").slip).toEqual(verdict.slip);
});
