// Letters, numbers, directions and sets, judged as the grader judges them.
import { expect, test } from "vitest";

import type { ConfigurationsKey, LettersKey, NumbersKey, Part, Problem, ValuesKey } from "../src/bank.js";
import { parseAnswer } from "../src/grade/forms.js";
import { judge } from "../src/grade/judge.js";
import { parseLetters, judgeLetters } from "../src/grade/letters.js";
import { judgeDirection, judgeNumbers } from "../src/grade/numbers.js";
import { judgeSet } from "../src/grade/sets.js";
import { writeConfiguration, judgeValues, computeFingerprintWeight } from "../src/grade/values.js";
import { isParsed } from "../src/grade/verdict.js";
import { readCommasAsPoints } from "../src/read/points.js";
import { message, textOf } from "../src/text/text.js";
import units from "../../tests/data/units.json" with { type: "json" };
import { canonical } from "./readings.js";

const PLAIN_KEY: ValuesKey = {
  type: "values",
  symbols: ["theta1"],
  points: [[0.5], [1.5]],
  rows: 1,
  columns: 1,
  right: [[Math.sin(0.5), Math.sin(1.5)]],
  mistakes: [],
};
const CHOICE: LettersKey = { type: "choice", options: 4, items: 0, right: [2], option_mistakes: [[0], [1, 2], [], []] };

test.each([
  ["C", "correct"],
  ["(c)", "correct"],
  ["Ｃ", "correct"],
  ["A", "wrong"],
  ["AC", "wrong"],
  ["", "missing"],
  ["blank", "missing"],
  ["theta1", "wrong"],
])("one letter: %s is %s", (typed, outcome) => expect(judgeLetters(typed, CHOICE).outcome).toBe(outcome));

test("several letters for one option are not called unknown", () =>
  expect(judgeLetters("A, B", CHOICE).reasons).toEqual([
    message("read.several-letters", { said: "A, B", letters: "A, B, C, D" }),
  ]));

test.each([
  ["AC", 1],
  ["c, a", 1],
  ["A\nC", 1],
  ["A", 0.5],
  ["AB", 1 / 2 - 1 / 3],
  ["ABCDE", 0],
])("several letters: %s earns %d", (typed, share) => {
  const key: LettersKey = { type: "selection", options: 5, items: 0, right: [0, 2], option_mistakes: [] };
  expect(judgeLetters(typed, key).share).toBeCloseTo(share);
});

test.each([
  ["BAC", 1],
  ["1: B\n2: A\n3: C", 1],
  ["joint 1 is B, joint 2 is A, joint 3 is C", 1],
  ["ABC", 1 / 3],
  ["BA", 0],
])("letters for items: %s earns %d", (typed, share) => {
  const key: LettersKey = { type: "matching", options: 4, items: 3, right: [1, 0, 2], option_mistakes: [] };
  expect(judgeLetters(typed, key).share).toBeCloseTo(share);
});

test("the mistakes behind a wrong option are reported", () => {
  expect(judgeLetters("A", CHOICE).mistake).toBe(0);
  const both = judgeLetters("B", CHOICE);
  expect([both.mistake, both.slips]).toEqual([undefined, [{ mistake: 1 }, { mistake: 2 }]]);
  for (const typed of ["C", "D"]) expect(judgeLetters(typed, CHOICE).mistake).toBeUndefined();
});

test("of several letters, each wrong one is reported, with its option", () => {
  const key: LettersKey = { type: "selection", options: 4, items: 0, right: [0], option_mistakes: [[], [5], [6], [6]] };
  expect(judgeLetters("AB", key).slips).toEqual([{ mistake: 5, where: message("slip.option", { letter: "B" }) }]);
  expect(judgeLetters("CD", key).slips).toEqual([{ mistake: 6 }]);
  expect(judgeLetters("A", { ...key, right: [0, 1] }).slips).toBeUndefined();
});

test("in matching, letters of no item or another item are explained, repeated letters are not", () => {
  const key: LettersKey = { type: "matching", options: 3, items: 2, right: [1, 0], option_mistakes: [[4], [4], [7]] };
  const item = (item: number) => message("slip.item", { item });
  expect(judgeLetters("BC", key).slips).toEqual([{ mistake: 7, where: item(2) }]);
  expect(judgeLetters("AB", key).slips).toEqual([{ mistake: 4 }]);
  expect(judgeLetters("BB", key).slips).toEqual([{ mistake: 4, where: item(2) }]);
});

test("letters are found among other signs", () => expect(parseLetters("{1: 'B', 2: 'A'}", 4)).toEqual([1, 0]));

const NUMBERS: NumbersKey = {
  type: "numbers",
  units: ["rad/s", "rad/s"],
  tolerance: 0.005,
  floor: 1e-6,
  right: [0.5, -1.25],
  mistakes: [[3, 0.5, 1.25]],
};

test.each([
  ["[0.5, -1.25]", "correct", 1],
  ["[[0.501], [-5/4]]", "correct", 1],
  ["{qd1: 0.5, qd2: -1.25}", "correct", 1],
  ["[0.5, 7]", "partial", 0.5],
  ["[-0.5, 1.25]", "partial", 0.8],
  ["[-0.5, -1.25]", "partial", 0.8],
  ["[0, 0]", "wrong", 0],
  ["[0.5, a1]", "wrong", 0],
  ["[0.5]", "wrong", 0],
  ["[blank, blank]", "missing", 0],
])("numbers: %s is %s", (typed, outcome, share) => {
  const found = judgeNumbers(typed, NUMBERS, ["qd1", "qd2"]);
  expect([found.outcome, found.share]).toEqual([outcome, share]);
});

test.each([
  ["qd2 = -1.25 m/s, qd1 = 0.5 rad/s", "read.unit-of-entry"],
  ["[0.5 rad/s, -1250 mm/s]", "read.unit-of-entry"],
  ["0.5 m, -1.25", "read.unit-of-entry"],
])("%s is in a unit that can't be right", (typed, key) => {
  const rates = { ...NUMBERS, units: ["rad/s", "rad/s"] };
  expect(judgeNumbers(typed, rates, ["qd1", "qd2"]).reasons[0]?.key).toBe(key);
});

test("a unit that can be right is accepted", () => {
  const rates = { ...NUMBERS, units: ["rad/s", "m/s"] };
  expect(judgeNumbers("qd2 = -125 cm/s, qd1 = 0.5 rad/s", rates, ["qd1", "qd2"]).outcome).toBe("correct");
});

test.each(units as [string, string, number | null][])("%s for a number in '%s' is %d", (typed, unit, value) => {
  const key = { ...NUMBERS, units: [unit], right: [value ?? 0.47], mistakes: [] };
  const verdict = judgeNumbers(typed, key, ["v"]);
  if (value === null) expect(verdict.reasons[0]?.key).toBe("read.unit");
  else expect(verdict.outcome).toBe("correct");
});

test("a mistake in numbers is reported", () => expect(judgeNumbers("[0.5, 1.25]", NUMBERS).mistake).toBe(3));

const answer = { where: message("slip.answer") };
const entry = (row: number) => ({ where: message("slip.row", { row }) });
const MIXED: NumbersKey = { ...NUMBERS, units: ["rad/s", "m/s"], mistakes: [] };

test.each([
  ["[28.65, -1.25]", [message("slip.per-degree", entry(1))]],
  ["[0.00873, -0.0218]", [message("slip.radians-twice", answer)]],
  ["[0.5, 1.25]", [message("slip.whole-sign", entry(2))]],
  ["[5, -12.5]", [message("slip.times-ten", { ...answer, factor: 10 })]],
  ["[0.005, -1.25]", [message("slip.over-ten", { ...entry(1), factor: 100 })]],
  ["[-0.5, -12.5]", [message("slip.whole-sign", entry(1)), message("slip.times-ten", { ...entry(2), factor: 10 })]],
  ["[0.5, -1.2]", [message("slip.rounded", { percent: 0.5 })]],
  ["[0.51, -1.26]", [message("slip.close", { percent: 0.5 })]],
  ["[0.5, -3.1]", undefined],
  ["[0.5, blank]", undefined],
  ["[28.65, 7]", undefined],
])("for the numbers %s, the wrong unit, sign or rounding is reported", (typed, slips) => {
  expect(judgeNumbers(typed, { ...NUMBERS, mistakes: [] }).slips).toEqual(slips);
});

test("metres differ from radians", () => {
  expect(judgeNumbers("[0.5, -1250]", MIXED).slips).toEqual([message("slip.metres-large", entry(2))]);
  expect(judgeNumbers("[0.5, -0.0125]", MIXED).slips).toEqual([message("slip.metres-small", entry(2))]);
  const area = { ...NUMBERS, units: ["m^2"], right: [0.124], mistakes: [] };
  expect(judgeNumbers("124000", area).slips).toEqual([message("slip.metres-large", answer)]);
  expect(judgeNumbers("1240", area).slips).toEqual([message("slip.metres-large", answer)]);
});

test("of two mistakes, the one that gives all digits is reported, else the nearest", () => {
  const key = { ...NUMBERS, mistakes: [[1, 2.003, 3.001], [2, 2.011, 3.004]] }; // prettier-ignore
  expect(judgeNumbers("[2.011, 3.004]", key).mistake).toBe(2);
  expect(judgeNumbers("[2.0034, 3.0012]", key).mistake).toBe(1);
  expect(judgeNumbers("[2, 3]", key).mistake).toBe(1);
  expect(judgeNumbers("[2.0064, 3.0011]", key).mistake).toBe(1);
  const one = { ...NUMBERS, units: [""], right: [0.5], mistakes: [[3, 2.003]] }; // prettier-ignore
  expect(judgeNumbers("2.003", one).mistake).toBe(3);
  expect(judgeNumbers("2.0071", one).mistake).toBeUndefined(); // which many others are as near to
});

test("for a single number with many digits, more mistakes are considered", () => {
  const key = { ...NUMBERS, units: ["m"], right: [0.5], mistakes: [], precise: [[8, 0.71342]] };
  expect(judgeNumbers("0.71342", key).mistake).toBe(8);
  for (const typed of ["0.713", "0.71301"]) expect(judgeNumbers(typed, key).mistake).toBeUndefined();
});

test("a mistake is reported together with a wrong unit, unless many such pairs could match by chance", () => {
  const key = { ...NUMBERS, mistakes: [[7, 0.81, 0.33]] };
  const both = [{ mistake: 7 }, message("slip.per-degree", answer)];
  expect(judgeNumbers("[46.41, 18.907]", key).slips).toEqual(both);
  const others = Array.from({ length: 120 }, (_, k) => [k, 30 + k, 20 + 3 * k]);
  const many = { ...key, mistakes: [...others, [200, 0.81, 0.33]] };
  expect(judgeNumbers("[46.4, 18.9]", many).slips).toBeUndefined();
  expect(judgeNumbers("[46.4096, 18.9076]", many).slips?.[0]).toEqual({ mistake: 200 });
});

test("for integers, no message mentions digits", () => {
  const rank = { ...NUMBERS, units: [""], right: [2], tolerance: 1e-9, floor: 1e-9, mistakes: [[4, 3]] };
  expect(judgeNumbers("3", rank).mistake).toBe(4);
  for (const typed of ["20", "-2", "2.01"]) expect(judgeNumbers(typed, rank).slips).toBeUndefined();
});

test("if one number is expected, a comma is a decimal comma", () => {
  const key = { ...NUMBERS, units: [""], right: [0.5], mistakes: [] };
  expect(judgeNumbers("0,5", key).outcome).toBe("correct");
});

const ALONG: ValuesKey = {
  type: "direction",
  symbols: ["a1", "theta1"],
  points: [
    [0.5, 0.3],
    [1.2, -2],
  ],
  rows: 2,
  columns: 1,
  right: [
    [Math.cos(0.3), Math.cos(-2)],
    [Math.sin(0.3), Math.sin(-2)],
  ],
  mistakes: [],
  tolerance: null,
};

test("the mistake behind a direction is reported, for vectors of any length", () => {
  const print = (vectors: readonly (readonly [number, number])[]) =>
    vectors.map(
      ([x, y]) => Math.abs(computeFingerprintWeight(0) * x + computeFingerprintWeight(1) * y) / Math.hypot(x, y),
    );
  const turned = [0.3, -2].map((angle) => [-Math.sin(angle), Math.cos(angle)] as const);
  const key = { ...ALONG, mistakes: [[6, ...print(turned)]] };
  for (const typed of ["[-s1, c1]", "[2*a1*s1, -2*a1*c1]"]) expect(judgeDirection(typed, key).mistake).toBe(6);
  expect(judgeDirection("[s1, c1]", key).mistake).toBeUndefined();
  const inNumbers = { ...ALONG, tolerance: 0.005, rows: 3, right: [[0.6], [0.8], [0]], mistakes: [[7, 0.6, -0.8, 0]] };
  expect(judgeDirection("[-3, 4, 0]", inNumbers).mistake).toBe(7);
  expect(judgeDirection("[3, 4, 1]", inNumbers).mistake).toBeUndefined();
  const flat = { ...inNumbers, rows: 2, right: [[0.6], [0.8]], mistakes: [[7, 0.6, -0.8]] };
  expect(judgeDirection("[-3, 4]", flat).mistake).toBeUndefined();
});

test.each([
  ["[cos(theta1), sin(theta1)]", "correct"],
  ["[-2*a1*c1, -2*a1*s1]", "correct"],
  ["A1 = [c1, s1]", "correct"],
  ["A1(q) := [c1, s1]", "correct"],
  ["[c1, s1] = A1", "correct"],
  ["2*A1 = [c1, s1]", "wrong"],
  ["[sin(theta1), cos(theta1)]", "wrong"],
  ["[0, 0]", "wrong"],
])("a direction: %s is %s", (typed, outcome) => expect(judgeDirection(typed, ALONG).outcome).toBe(outcome));

const SET: ConfigurationsKey = {
  type: "configurations",
  joints: ["theta1", "theta2"],
  symbols: ["a1", "theta1", "theta2"],
  pieces: [
    [
      [1, 0.4, 0],
      [0.7, -2, 0],
    ],
    [
      [1, 1.4, Math.PI],
      [0.7, 2, Math.PI],
    ],
  ],
  mistakes: [],
};
const ANGLES = new Set(["theta1", "theta2"]);
const stretched = ({ theta2 = 1 }: Readonly<Record<string, number>>) => Math.abs(Math.sin(theta2)) < 1e-5;

test.each([
  ["theta2 = 0, theta2 = pi", "correct", 1],
  ["theta2 in {0, pi}", "correct", 1],
  ["sin(theta2) = 0", "correct", 1],
  ["theta2 = k*pi", "correct", 1],
  ["{theta2: [0, -pi]}", "correct", 1],
  ["theta2 = 0", "partial", 2 / 3],
  ["theta2 = pi/2", "wrong", 0],
  ["theta2 = 0, theta2 = pi, theta1 = 0", "partial", 0.5],
  ["theta2 = 0, theta2 = pi, theta1 = 0, theta1 = pi", "partial", 0.5], // one condition, not two values
  ["theta2 = 0, theta2 = pi, theta2 = pi/2, theta1 = 0", "wrong", 0], // more are false than true
  ["theta2 = k*pi/2", "wrong", 0],
  ["theta2", "wrong", 0],
  ["sin(theta2)^2 + 1 = 0", "wrong", 0],
  ["theta1 = theta1", "wrong", 0], // always true: it covers everything, and earns nothing
  ["det(J) = 0", "wrong", 0],
  ["0 = 0", "wrong", 0],
  ["{0, pi}", "wrong", 0], // of which joint, it does not say
  ["sin(theta2)^2 = 0", "correct", 1],
  ["theta2 = 0, theta2 = pi, sin(theta1) = 2", "correct", 1],
  ["theta2 = 0, theta2 = pi, theta1 = foo", "wrong", 0],
  ["theta2 = 0, theta2 = 3.14159", "partial", 4 / 5],
])("a set: %s is %s", (typed, outcome, share) => {
  const found = judgeSet(typed, SET, ANGLES, stretched);
  expect([found.outcome, found.share]).toEqual([outcome, share]);
});

const SUM: ConfigurationsKey = {
  ...SET,
  pieces: [0, Math.PI].map((sum) => [0.4, -2, 3].map((theta1) => [1, theta1, sum - theta1])),
  conditions: [2],
};
const isSumSingular = ({ theta1 = 1, theta2 = 1 }: Readonly<Record<string, number>>) =>
  Math.abs(Math.sin(theta1 + theta2)) < 1e-5;

test.each([
  ["theta1 + theta2 = 0 or pi", "correct", 1],
  ["theta1 + theta2 = 0, pi, -pi", "correct", 1],
  ["theta1 + theta2 = k*pi", "correct", 1],
  ["[Eq(theta1 + theta2, 0), Eq(theta1 + theta2, 3*pi)]", "correct", 1],
  ["theta1 = -theta2 + 2*pi, theta2 = pi - theta1", "correct", 1],
  ["theta1 + theta2 - pi = 0, 2*theta1 + 2*theta2 = 0", "correct", 1],
  ["Eq(theta1 + theta2, 0)", "partial", 2 / 3],
  ["theta1 + theta2 = 0 or 3.14", "partial", 4 / 5],
  ["theta1 + theta2 = 0 or pi/2", "partial", 1 / 3],
  ["theta1 - theta2 = 0, pi", "wrong", 0],
  ["2*theta1 + 2*theta2 = 0, pi", "partial", 1 / 3],
  ["theta1 + theta2 = 0 and theta1 - theta2 = 0", "wrong", 0],
])("a set given by a sum of angles: %s is %s", (typed, outcome, share) => {
  const found = judgeSet(typed, SUM, ANGLES, isSumSingular);
  expect([found.outcome, found.share]).toEqual([outcome, share]);
});

test("if decimal commas are ambiguous, the message suggests decimal points", () => {
  const problem = {
    robot: { joints: ["theta1", "theta2"].map((theta) => ({ kind: "R", theta })) },
  } as unknown as Problem;
  const part = { key: SET, labels: [], columns: [], names: [] } as unknown as Part;
  const told = (typed: string) => judge(problem, part, typed, stretched).reasons.map(({ key }) => key);
  expect(told("theta2 = 0, theta1 = 0")).toContain("verdict.together");
  expect(told("theta2 = 0\ntheta1 = 0.5")).toContain("verdict.together");
  for (const other of ["theta2 = 0, theta2 = pi", "theta1 = 0, theta1 = 1", "theta2 = 0, theta2 = 1", "theta2 = 1"])
    expect(told(other)).not.toContain("verdict.together");
});

test("undefined values are reported as undefined, and numeric directions without a pose", () => {
  const values = (typed: string) => textOf(judgeValues(typed, PLAIN_KEY, []).reasons[0]!);
  expect(values("1/0")).toContain("undefined");
  const numbers: ValuesKey = { ...ALONG, symbols: [], points: [[]], rows: 2, right: [[0.6], [0.8]], tolerance: 0.01 };
  expect(judgeDirection("[1, 2]", numbers).reasons.map(({ key }) => key)).toEqual(["verdict.other-direction"]);
});

test("a difference is reported with the rates in the question, even if the answer lacks them", () => {
  const key: ValuesKey = {
    ...PLAIN_KEY,
    symbols: ["qd1", "theta1"],
    points: [
      [2, 0.5],
      [3, 1.5],
    ],
    right: [[2 * Math.sin(0.5), 3 * Math.sin(1.5)]],
  };
  const at = (mentioned?: readonly string[]) =>
    String(judgeValues("sin(theta1)", { ...key, ...(mentioned ? { mentioned } : {}) }, []).reasons[0]!.values?.["at"]);
  expect(at(["qd1"])).toContain("qd1 = 2");
  expect(at()).not.toContain("qd1");
});

test("a rounded angle is reported as rounded, and a wrong one is not", () => {
  const reasonKey = (typed: string) => judgeSet(typed, SET, ANGLES, stretched).reasons[0]?.key;
  expect(reasonKey("theta2 = 0, theta2 = 3.14159")).toBe("verdict.rounded");
  expect(reasonKey("theta2 = 0, theta2 = 179.9 deg")).toBe("verdict.rounded");
  expect(reasonKey("theta2 = 0, theta2 = 3")).toBe("verdict.unsound");
});

test("a pose is written as on the sliders: angles in degrees within a full turn, lengths in metres", () => {
  expect(writeConfiguration({ qd1: 0.5, qdd2: -1, fx: 2, mz: 3, F: 4 }, ["theta1", "d2", "F"])).toBe(
    "qd1 = 0.5 rad/s, qdd2 = −1 m/s², fx = 2 N, mz = 3 N m, F = 4",
  );
  expect(writeConfiguration({ theta1: Math.PI / 3 + 4 * Math.PI, d2: 0.25, a1: 1 })).toBe(
    "θ1 = 60°, d2 = 0.25 m, a1 = 1 m",
  );
});

test.each([
  ["0,5", "0.5"],
  ["a1*(0,06*s2 - 0,3)", "a1*(0.06*s2 - 0.3)"],
  ["(0,06*s2 - 0,3)*a1", "(0.06*s2 - 0.3)*a1"],
  ["sin(0,5)", "sin(0.5)"],
  ["[[0,5*(1,5*a1), 2]]", "[[0,5*(1.5*a1), 2]]"],
  ["(1,2)", "(1,2)"],
  ["[1,2]", "[1,2]"],
  ["atan2(1,2)", "atan2(1,2)"],
  ["2*atan2(1,2) + 1", "2*atan2(1,2) + 1"],
  ["{theta2: (0,5)}", "{theta2: (0,5)}"],
])("the decimal comma: %s is %s", (typed, read) => expect(readCommasAsPoints(typed)).toBe(read));

test.each(["hello world", "a1 + foo", "constructor"])("unknown words are reported: %s", (typed) => {
  const key: ValuesKey = { ...ALONG, type: "values", rows: 1, right: [[1, 2]] };
  const found = judgeValues(typed, key);
  expect([found.outcome, found.reasons[0]?.key]).toEqual(["wrong", "read.unknown"]);
});

test.each([
  ["-a1*theta1", 0.8, "verdict.but-sign"],
  ["theta1", 0.8, "verdict.but-factor"],
  ["-3*theta1*a1^2", 0.6, "verdict.but-both"],
  ["a1", 0, "verdict.differs"],
  ["0", 0, "verdict.differs"],
])("a formula that is right up to a factor: %s earns %d", (typed, share, said) => {
  const key: ValuesKey = {
    type: "values",
    symbols: ["a1", "theta1"],
    points: [
      [0.5, 1.5],
      [2, 0.25],
      [3, -0.7],
    ],
    rows: 1,
    columns: 1,
    right: [[0.75, 0.5, -2.1]],
    constants: ["a1"],
    moving: [0],
    mistakes: [],
  };
  const found = judgeValues(typed, key);
  expect(found.share).toBeCloseTo(share);
  expect(found.reasons[0]?.key).toBe(said);
});

test.each([
  ["[-theta1, theta1]", 0.8, "verdict.but-signs"],
  ["[-theta1, -theta1]", 0.8, "verdict.but-signs"],
  ["[2*theta1, -2*theta1]", 0.6, "verdict.but-signs-both"],
  ["[2*theta1, 2*theta1]", 0.8, "verdict.but-factor"],
  ["[theta1, -2*theta1]", 0.6, "verdict.but-signs-both"],
  ["[-theta1, -2*theta1]", 0, "verdict.entries"],
])("a vector that is right up to signs: %s earns %d", (typed, share, said) => {
  const right = [
    [1.5, 0.25],
    [1.5, 0.25],
  ];
  const points = [[1.5], [0.25]];
  const key: ValuesKey = { ...ALONG, type: "values", symbols: ["theta1"], points, rows: 2, right, moving: [0, 1] };
  const found = judgeValues(typed, key);
  expect([found.share, found.reasons[0]?.key]).toEqual([share, said]);
});

test("a difference is reported with all values needed to reproduce it", () => {
  const key: ValuesKey = {
    type: "values",
    symbols: ["a1", "fx", "qd1", "qd2", "theta1", "theta2"],
    points: [[0.5, 9, 1, 2, 0, 0.5]],
    rows: 1,
    columns: 1,
    right: [[1.5]],
    constants: ["a1"],
    mistakes: [],
  };
  const told = (typed: string, points = key.points) =>
    judgeValues(typed, { ...key, points }).reasons.find(({ key }) => key === "verdict.differs")!.values["at"];
  expect(told("a1*qd1")).toBe("a1 = 0.5 m, qd1 = 1 rad/s, qd2 = 2 rad/s, θ1 = 0°, θ2 = 28.6°");
  expect(told("sin(theta2)")).toBe("a1 = 0.5 m, θ1 = 0°, θ2 = 28.6°");
  expect(told("a1", [[0.5, 9, 1, 2, -Math.PI, 0.5]])).toContain("θ1 = 180°"); // as the slider shows it
});

test("for integers, no percentage is reported", () => {
  const whole = { ...NUMBERS, units: ["", ""], tolerance: 1e-9, right: [2, 3] };
  expect(judgeNumbers("[2, 3]", whole).reasons).toEqual([]);
  expect(judgeNumbers("[0.5, -1.25]", NUMBERS).reasons.map(({ key }) => key)).toEqual(["verdict.numbers"]);
});

test("a wrong number has an index if there are several", () => {
  const subjectOf = (typed: string, key: typeof NUMBERS) => judgeNumbers(typed, key).reasons.at(-1)!.values["which"];
  expect(subjectOf("[0.5, 7]", NUMBERS)).toEqual(message("verdict.nth-number", { n: 2 }));
  expect(subjectOf("7", { ...NUMBERS, units: [""], right: [1] })).toMatchObject({ key: "answer.label" });
  expect(textOf(judgeNumbers("[0.5, 7]", NUMBERS).reasons.at(-1)!)).toMatch(
    /^Number 2 is wrong: you gave 7, the right value is −1\.25 rad\/s\.$/,
  );
});

test("an answer that can't be parsed does not count as a try", () => {
  expect(isParsed(judgeNumbers("[0.5, a1", NUMBERS))).toBe(false);
  expect(isParsed(judgeNumbers("", NUMBERS))).toBe(false);
  expect(isParsed(judgeNumbers("[0.5, 7]", NUMBERS))).toBe(true);
});

test("if large terms hide an entry, the browser is unsure", () => {
  const key: ValuesKey = { ...ALONG, type: "values", rows: 1, right: [[0.5, 1.2]] };
  expect(judgeValues("a1 + x - x", key)).toMatchObject({ outcome: "correct", isSure: true });
  for (const typed of ["a1 + 1e-12", "a1 + 9^9*(x - x)", "a1 + 1/10^12"])
    expect(judgeValues(typed, key)).toMatchObject({ outcome: "correct", isSure: false });
});

test("a matrix is marked entry by entry, zeros earn nothing, and the mistake is reported", () => {
  const key: ValuesKey = {
    type: "values",
    symbols: ["a1"],
    points: [[0.5], [2], [3]],
    rows: 2,
    columns: 2,
    right: [
      [0.5, 2, 3],
      [0, 0, 0],
      [1, 1, 1],
      [-0.5, -2, -3],
    ],
    mistakes: [[4, 0, 0, 0]],
  };
  expect(judgeValues("[[a1, 0], [1, -a1]]", key)).toMatchObject({ outcome: "correct", isSure: true });
  expect(judgeValues("[[a1, 0], [2, -a1]]", key)).toMatchObject({ outcome: "partial", share: 2 / 3 });
  expect(judgeValues("[[0, 0], [0, 0]]", key)).toMatchObject({ outcome: "wrong", share: 0, mistake: 4 });
  expect(judgeValues("[[a1, blank], [1, -a1]]", key).outcome).toBe("partial");
  expect(judgeValues("[[a1, 0]]", key).outcome).toBe("wrong");
  expect(judgeValues("[[blank, blank], [blank, blank]]", key).outcome).toBe("missing");
});

test.each([["omega = [1, 2, 3], v = [4, 5, 6]"], ["v: [4, 5, 6]; ω: [1, 2, 3]"], ["[1, 2, 3, 4, 5, 6]"]])(
  "a twist of angular velocity first, by its halves: %s",
  (typed) => {
    const right = [[1], [2], [3], [4], [5], [6]].map(([value]) => [value as number, value as number]);
    const key: ValuesKey = { ...ALONG, type: "values", rows: 6, right };
    const labels = ["omegax", "omegay", "omegaz", "vx", "vy", "vz"];
    expect(judgeValues(typed, key, labels).outcome).toBe("correct");
  },
);

const RATES = {
  labels: ["qd1", "qd2"],
  shape: [2, 1],
  key: { type: "numbers", right: [-1.09, 1.35], units: ["", ""], tolerance: 1e-3, floor: 0, mistakes: [] },
} as unknown as Part;

test.each(["[-1,09 , 1,35]", "-1,09, 1,35", "[-1,09; 1,35]", "-1,09\n1,35"])(
  "decimal commas are read where a blank or a semicolon parts the numbers: %j",
  (typed) => expect(judge({} as Problem, RATES, typed, () => false).outcome).toBe("correct"),
);

test.each([
  ["-1.08, 1.35", "correct"],
  ["-1.09, 1.36", "partial"],
  ["-1.06, 1.35", "partial"],
])("each number may have its own tolerance: %s is %s", (typed, outcome) => {
  const key = { ...RATES.key, units: ["rad/s", "m/s"], tolerance: 0, floor: 0.001, floors: [0.02, 0.001] };
  expect(judge({} as Problem, { ...RATES, key } as Part, typed, () => false).outcome).toBe(outcome);
});

test("if commas are ambiguous, the message explains how to separate numbers", () => {
  const { reasons } = judge({} as Problem, RATES, "[-1,09,1,35]", () => false);
  expect(reasons.map((reason) => textOf(reason))).toEqual([
    "The size of your answer is 4 × 1 (rows × columns), but 2 × 1 is expected. If 0,5 is a number, separate the entries with " +
      "semicolons, or with a comma and a space, for example [0,5; 1,25].",
  ]);
});

test("the preview shows the answer as it is judged, also for a table", () => {
  const known = new Set(["a", "b", "c", "d"]);
  const part = { shape: [2, 2], key: { type: "values" } } as unknown as Part;
  for (const typed of ["a b\nc d", "a, b\nc, d", "[a b; c d]", "[[a, b], [c, d]]"])
    expect(canonical(parseAnswer(typed, known, part))).toBe("(list (list a b) (list c d))");
  expect(canonical(parseAnswer("[-1,09 , 1,35]", new Set(), RATES))).toBe("(list (neg #109e-2) #135e-2)");
});

test.each([
  ["M = m*a1", "correct"],
  ["M := a1*m", "correct"],
  ["M = M*a1", "correct"],
  ["M = 2*m*a1", "wrong"],
  ["m = m*a1", "wrong"],
])("a formula may have a capital name although the small letter is a symbol: %s is %s", (typed, outcome) => {
  const key = { ...PLAIN_KEY, symbols: ["a1", "m"], points: [[1, 2]], right: [[2]], mistakes: [] };
  expect(judgeValues(typed, key).outcome).toBe(outcome);
});

test.each([
  [[], "a1, theta1"],
  [["qd1"], "a1, qd1, theta1"],
])("beside an unknown name, the symbols of the question are listed: with %j %s", (mentioned, known) => {
  const symbols = ["a1", "fx", "qd1", "theta1", "vx"];
  const key = { ...PLAIN_KEY, symbols, points: [[1, 2, 3, 0.5, 4]], right: [[0.5]], constants: ["a1"], mentioned };
  for (const verdict of [
    judgeValues("l1*theta1", key),
    judgeDirection("[l1, 1]", { ...key, type: "direction", rows: 2, right: [[1], [2]] }),
  ])
    expect(verdict.reasons.map((reason) => textOf(reason))).toContain(
      `This problem doesn't contain l1. Its symbols are ${known}.`,
    );
});
