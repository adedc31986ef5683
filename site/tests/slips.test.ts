// Slips that are made in right answers, and what they are called: only what was made is named.
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";

import type { ConfigurationsKey, ValuesKey } from "../src/bank.js";
import { limitVerdict } from "../src/grade/levels.js";
import { judgeSet } from "../src/grade/sets.js";
import { judgeValues, computeFingerprintWeight } from "../src/grade/values.js";
import type { Verdict } from "../src/grade/verdict.js";
import { describeMissingFactor } from "../src/practice/feedback.js";
import { evaluate } from "../src/read/evaluate.js";
import { parse } from "../src/read/reader.js";
import { message, textOf, type TextKey } from "../src/text/text.js";
import { type Slipped, outcomesOf } from "./slips.js";

const PROBLEMS = JSON.parse(readFileSync(new URL("./slips.json", import.meta.url), "utf-8")) as readonly Slipped[];

/** What a slip may be called; an angle's sign is an angle, and in one sine or cosine throughout is once. */
const EXPECTED_KEYS: Readonly<Record<string, readonly string[]>> = {
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
  "contribution dropped": ["slip.symbol-missing", "slip.term-missing", "slip.terms-missing", "slip.zero"],
  "term dropped, one place": ["slip.symbol-missing", "slip.term-missing", "slip.terms-missing", "slip.zero"],
  "factor missing": ["slip.length-missing", "slip.lengths-missing", "slip.factor-missing"],
  "condition left out": ["slip.half-turn", "slip.tie-left-out", "slip.values-left-out"],
  "degrees for radians": ["slip.degrees"],
  "quarter turn": ["slip.quarter-turn"],
  "another joint": ["slip.other-joint", "slip.half-turn", "slip.angle", "slip.called-singular"],
};

test.each(PROBLEMS.map((problem) => [problem.id, problem] as const))(
  "most slips in answers to %s are reported, and never as another slip",
  (_, problem) => {
    const outcomes = outcomesOf(problem);
    const slips = problem.slips.map(([part, slip], i) => ({
      part,
      slip: slip.replace(/ \w+ missing/, " missing"),
      mistake: outcomes[i]![1],
      called: outcomes[i]![2].find((key) => key.startsWith("slip.")) ?? null,
    }));
    expect(outcomes.filter(([outcome]) => outcome === "correct")).toEqual([]);
    const others = slips.filter(({ slip, called }) => called !== null && !EXPECTED_KEYS[slip]?.includes(called));
    expect(others).toEqual([]);
    const named = slips.filter(({ mistake, called }) => mistake !== null || called !== null);
    expect(named.length).toBeGreaterThan(0.88 * slips.length);
  },
);

/** The same as the sign of a column. */
const ORDER = "z x p in the wrong order";

test.each(PROBLEMS.map((problem) => [problem.id, problem] as const))(
  "of two slips at once in answers to %s, mostly both are reported, and never as other slips",
  (_, problem) => {
    const pairs = problem.pairs ?? [];
    const outcomes = outcomesOf({ ...problem, slips: pairs });
    const others = pairs.flatMap(([part, slip], i) => {
      const may = slip.split(" & ").flatMap((each) => EXPECTED_KEYS[each === ORDER ? "sign of a column" : each] ?? []);
      const called = outcomes[i]![2].filter((key) => key.startsWith("slip."));
      return called.filter((key) => !may.includes(key)).map((key) => [part, slip, key]);
    });
    expect(others).toEqual([]);
    const named = outcomes.filter(([, , , left]) => left === 0);
    expect(named.length).toBeGreaterThan(0.88 * pairs.length);
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
  const worth = (text: string) => POINTS.map((_, k) => evaluate(parse(text, new Set(SYMBOLS)), at(k)).re);
  const right = rows.flat().map(worth);
  const [columns, mistakes] = [rows[0]!.length, []];
  return { type: "values", symbols: SYMBOLS, points: POINTS, rows: rows.length, columns, right, mistakes };
}

const JACOBIAN = keyOf([
  ["-a1*s1 - a2*s12", "-a2*s12"],
  ["a1*c1 + a2*c12", "a2*c12"],
]);

/** The messages about slips. */
const messagesOf = ({ slips = [] }: Verdict): string[] =>
  slips.map((slip) => ("mistake" in slip ? `mistake ${slip.mistake}` : textOf(slip)));

test.each([
  ["[[-a1*s1 - a2*s12, -a2*s2], [a1*c1 + a2*c12, a2*c2]]", "Column 2: one angle does not include"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*s12, a2*c12]]", "Entry (2, 1): you have a sine instead of a cosine"],
  ["[[-s1 - a2*s12, -a2*s12], [c1 + a2*c12, a2*c12]]", "Column 1: the length a1 is missing"],
  ["[[-a2*s12, -a2*s12], [a2*c12, a2*c12]]", "Column 1: a term with a1 is missing"],
  ["[[a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12]]", "Entry (1, 1): one sign"],
  ["[[-s1 - s12, -a2*s12], [c1 + c12, a2*c12]]", "Column 1: several lengths are missing"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, 0]]", "Entry (2, 2): you have zero"],
  ["[[-a1*s1 - a2*s12, 0], [a1*c1 + a2*c12, 0]]", "Column 2 of your answer contains only zeros"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a1*c12, a2*c12]]", "Entry (2, 1): one symbol"],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*(c1 + c12), a2*c12]]", undefined],
  ["[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12 + a2*c2, a2*c12]]", "Entry (2, 1): there is one term too"],
  ["[[3*a1*s2, 7], [a1^3, 7*a2*s1*s2]]", undefined],
])("for %s, the message is: %s", (typed, says) => {
  const verdict = judgeValues(typed, JACOBIAN);
  expect(verdict.outcome).not.toBe("correct");
  const told = messagesOf(verdict);
  if (says === undefined) expect(told).toEqual([]);
  else expect(told).toEqual([expect.stringContaining(says)]);
});

test.each([
  [
    "[[-a1*s1 - a2*s12, -a2*s2], [0, 0]]", // where column 1 is right in its first entry
    ["Entry (1, 2): one angle does not include", "Entries (2, 1), (2, 2): you have zero"],
  ],
  [
    "[[-a1*c1 - a2*s12, a2*s12], [a1*s1 + a2*c12, -a2*c12]]",
    ["Column 1: you have a sine instead of a cosine", "Column 2: the overall sign seems to be wrong"],
  ],
  [
    "[[-a1*s1 - a2*s2, 0], [a1*c1 + a2*c2, 0]]",
    [
      "Column 2 of your answer contains only zeros",
      "Column 1: one angle does not include the angles of earlier joints",
    ],
  ],
  ["[[-a1*s1, -a2*s12], [a2*c12, a2*c12]]", ["Entry (1, 1): a term with a2", "Entry (2, 1): a term with a1"]],
  [
    "[[-a1*s1 + a2*s12, -a2*c12], [a1*c1 + a2*c12, 7*a1*s1]]",
    ["Entry (1, 2): you have a sine instead of a cosine", "Entry (1, 1): one sign"],
  ],
])("in %s, each entry's own slip is reported: %s", (typed, says) => {
  const told = messagesOf(judgeValues(typed, JACOBIAN));
  expect(told).toHaveLength(says.length);
  for (const each of says) expect(told).toContainEqual(expect.stringContaining(each));
});

test("of two wrong entries in a column, only the one with a known slip is reported", () => {
  const [only, ...others] = messagesOf(judgeValues("[[-a1*s1 - a2*c12, -a2*s12], [7*a1^3, a2*c12]]", JACOBIAN));
  expect(others).toEqual([]);
  expect(only).toContain("Entry (1, 1): you have a sine instead of a cosine");
});

/** The sum of an answer's entries in numbers, as keys have it of what mistakes give. */
const print = (rows: readonly (readonly string[])[]) =>
  POINTS.map((_, k) =>
    keyOf(rows).right.reduce((sum, values, i) => sum + computeFingerprintWeight(i) * (values[k] as number), 0),
  );

test("a known mistake in one column is reported beside a slip in another, with its place", () => {
  const next = [
    ["-a2*s12", "-a2*s12"],
    ["a2*c12", "a2*c12"],
  ];
  const key = { ...JACOBIAN, mistakes: [[5, ...print(next)]] };
  const both = judgeValues("[[-a2*s12, a2*s12], [a2*c12, -a2*c12]]", key);
  expect(both.mistake).toBeUndefined();
  expect(both.slips).toHaveLength(2);
  expect(both.slips).toContainEqual({ mistake: 5, where: message("slip.column", { row: 1, column: 1 }) });
  expect(messagesOf(both)).toContainEqual(expect.stringContaining("Column 2: the overall sign seems to be wrong"));
  expect(judgeValues("[[-a2*s12, -a2*s12], [a2*c12, a2*c12]]", key).mistake).toBe(5);
});

test("two known mistakes are reported with their columns", () => {
  const first = [
    ["a1^2", "-a2*s12"],
    ["a2^3", "a2*c12"],
  ];
  const second = [
    ["-a1*s1 - a2*s12", "a2^3*s1"],
    ["a1*c1 + a2*c12", "a1^2*c1"],
  ];
  const key = { ...JACOBIAN, mistakes: [first, second].map((rows, i) => [i, ...print(rows)]) };
  const { slips } = judgeValues("[[a1^2, a2^3*s1], [a2^3, a1^2*c1]]", key);
  expect(slips).toEqual([0, 1].map((i) => ({ mistake: i, where: message("slip.column", { row: 1, column: i + 1 }) })));
});

const WIDE = keyOf([
  ["-a1*s1 - a2*s12", "-a2*s12", "0"],
  ["a1*c1 + a2*c12", "a2*c12", "1"],
]);

test("the transpose of a matrix that is not square differs from a transpose with wrong entries", () => {
  const turned = judgeValues("[[-a1*s1 - a2*s12, a1*c1 + a2*c12], [-a2*s12, a2*c12], [0, 1]]", WIDE);
  expect(turned.reasons.map(({ key }) => key)).toEqual(["read.shape"]);
  expect(turned.slips).toEqual([message("slip.transposed")]);
  const other = judgeValues("[[-a1*s1 - a2*s12, a1*c1 + a2*c12], [a2*s12, a2*c12], [0, 1]]", WIDE);
  expect(other.slips).toEqual([message("slip.turned")]);
  expect(judgeValues("[[1, 2], [3, 4]]", WIDE).slips).toBeUndefined();
  expect(limitVerdict(turned, "outcome").slips).toBeUndefined();
});

test("for an entry that should be zero, neither a wrong angle nor a missing term is reported", () => {
  for (const typed of ["a1*s2", "a1*s2*s12", "a1*c1*s2"]) {
    const rows = `[[-a1*s1 - a2*s12, -a2*s12, ${typed}], [a1*c1 + a2*c12, a2*c12, 1]]`;
    expect(messagesOf(judgeValues(rows, WIDE))).toEqual([]);
  }
});

test("angles with constants are compared with the right ones", () => {
  const key = keyOf([["a1*cos(theta1 + pi/6) + a2*cos(theta1 + theta2 + pi/4)"]]);
  const says = (typed: string) => messagesOf(judgeValues(typed, key));
  expect(says("a1*cos(theta1 + pi/6) + a2*cos(theta2 + pi/4)")).toEqual([
    expect.stringContaining("one angle does not include the angles of earlier joints"),
  ]);
  expect(says("a1*cos(theta1 + pi/6) + a2*cos(theta1 + theta2)")).toEqual([
    expect.stringContaining("the angle in one sine or cosine"),
  ]);
  expect(says("a1*cos(theta1 + pi/6) + a2*cos(theta2)")).toEqual([]); // which lacks both
});

test("missing terms with constants in their angles are reported if the answer has such angles elsewhere", () => {
  const key = keyOf([["a1*cos(theta1 + pi/6) + a2*c12"], ["a1*sin(theta1 + pi/6) + a2*s12"]]);
  expect(messagesOf(judgeValues("[a2*c12, a1*sin(theta1 + pi/6) + a2*s12]", key))).toEqual([
    expect.stringContaining("Entry 1: a term with a1 is missing"),
  ]);
});

test("two missing terms are described by their symbols", () => {
  const key = keyOf([["a1*c1 + a2*c12 + a1*a2"], ["a1*s1 + a2*s12"]]);
  expect(messagesOf(judgeValues("[a1*a2, a1*s1 + a2*s12]", key))).toEqual([
    expect.stringContaining("Entry 1: two terms with a1, a2 are missing"),
  ]);
});

/** The velocity of the arm's tip, with what its rates are multiplied by. */
const [RATES, AT] = [["qd1", "qd2"], [[0.7, -1.3], [-0.4, 1.1], [0.9, 0.6]]] as const; // prettier-ignore
const VELOCITY: ValuesKey = {
  ...JACOBIAN,
  symbols: [...SYMBOLS, ...RATES],
  points: POINTS.map((point, k) => [...point, ...AT[k]!]),
  columns: 1,
  right: [0, 2].map((i) => AT.map(([one, two], k) => one * JACOBIAN.right[i]![k]! + two * JACOBIAN.right[i + 1]![k]!)),
  linear: Object.fromEntries(
    RATES.map((rate, c) => [rate, [c, 2 + c].map((i) => JACOBIAN.right[i]!.slice(0, 2) as number[])]),
  ),
};
const [X, Y] = ["-(a1*s1 + a2*s12)*qd1 - a2*s12*qd2", "(a1*c1 + a2*c12)*qd1 + a2*c12*qd2"];

test.each([
  [`[-a2*s12*qd2, ${Y}]`, "Entry 1: all terms with qd1 are missing"],
  [`[${X}, -(a1*c1 + a2*c12)*qd1 + a2*c12*qd2]`, "Entry 2: one sign is wrong"],
  [`[${X}, a1*c1 + a2*c12 + a2*c12*qd2]`, "Entry 2: the factor qd1 is missing from the terms"],
  [`[${X}, a2*c12*qd2 - (1 + a1)*c1*qd1 - a2*c12*qd1 + c1*qd1]`, "Entry 2: all terms with qd1 have the wrong sign"],
  [`[0.5*a1 - 0.5*a1, ${Y}]`, "Entry 1: all terms with qd1, qd2 are missing"],
  ["[-a2*s12*qd2, a2*c12*qd2]", "In your answer: all terms with qd1 are missing"],
  [`[-a2*s12*qd2 + a1*qd1, ${Y}]`, undefined],
])("about the terms with one rate in %s, the message is: %s", (typed, says) => {
  const told = messagesOf(judgeValues(typed, VELOCITY)).map((each) => each.replace("Entries 1, 2", "In your answer"));
  expect(told).toEqual(says === undefined ? [] : [expect.stringContaining(says)]);
});

test("a mistake made everywhere is reported if slips in single places explain less", () => {
  const split = [
    ["-a1*s1 - a2*(s1 + s2)", "-a2*(s1 + s2)"],
    ["a1*c1 + a2*(c1 + c2)", "a2*(c1 + c2)"],
  ];
  const key = { ...JACOBIAN, throughout: [[4, ...print(split)]] };
  const typed = `[${split.map((row) => `[${row.join(", ")}]`).join(", ")}]`;
  expect(judgeValues(typed, key).mistake).toBe(4);
  expect(judgeValues(typed, JACOBIAN).mistake).toBeUndefined();
  const relative = [
    ["-a1*s1 - a2*s2", "-a2*s2"],
    ["a1*c1 + a2*c2", "a2*c2"],
  ];
  const told = judgeValues(`[${relative.map((row) => `[${row.join(", ")}]`).join(", ")}]`, {
    ...JACOBIAN,
    throughout: [[4, ...print(relative)]],
  });
  expect([told.mistake, messagesOf(told)]).toEqual([
    undefined,
    [expect.stringContaining("one angle does not include the angles")],
  ]);
});

test("a missing term is described by its symbols, and a missing factor by its joints", () => {
  expect(textOf(describeMissingFactor("a1", true))).toBe("The missing part contains a1.");
  expect(textOf(describeMissingFactor("theta2, theta3", false))).toBe("The missing part contains θ2, θ3.");
  expect(textOf(describeMissingFactor("theta2", true))).toContain(
    "contains θ2. The arm is also singular where this factor is zero",
  );
});

test.each([
  ["a1*a2*c2", "In your answer: you have a sine instead of a cosine"],
  ["a1*s2", "In your answer: the length a2 is missing"],
  ["s2", "In your answer: several lengths are missing"],
  ["a1*a2", "In your answer: a sine or cosine with θ2"],
  ["2*a1*a2*s2", "In your answer: there is one factor too many"],
  ["a1*a2*s1*c2", undefined],
])("for the determinant %s, the message is: %s", (typed, says) => {
  const told = messagesOf(judgeValues(typed, keyOf([["a1*a2*s2"]])));
  expect(told).toEqual(says === undefined ? [] : [expect.stringContaining(says)]);
});

test("a missing bracket in a quotient is reported", () => {
  const { slips } = judgeValues("a1*c1 + c12", keyOf([["a1*(c1 + c12)"]]));
  expect(slips).toEqual([message("slip.bracket", { where: message("slip.answer") })]);
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
  ["theta1 = 1", "slip.called-singular"],
])("for the set %s, the message is %s", (typed, key) => {
  const slips = judgeSet(typed, SET, ANGLES, straight).slips;
  expect(slips?.map((slip) => "key" in slip && slip.key)).toEqual(key === undefined ? undefined : [key]);
});

const DEGREE = Math.PI / 180;
const IN_SPACE = ["a1", "a2", "a3", "theta1", "theta2", "theta3"];
const aboutJoint = (key: string, joint: string) => message(key as TextKey, { joint: joint.replace("theta", "θ") });

/** An elbow with an offset: theta3 = -30° or 150°, or a1 + a2 c2 + a3 c23 = 0. */
const ELBOW: ConfigurationsKey = {
  type: "configurations",
  joints: IN_SPACE.slice(3),
  symbols: IN_SPACE,
  mistakes: [],
  pieces: [
    ...[-30, 150].map((value) =>
      [0.2, 0.5, -0.9].map((free) => [0.1, 0.5, 0.4, free, free ** 2 + 0.3, value * DEGREE]),
    ),
    [0.3, 0.45, 0.7].map((a1, k) => [a1, 0.5, 0.4, 0.2 * k, ...shoulder(a1, 0.3 + k)]),
  ],
};

/** Values of theta2 and theta3 with a1 + 0.5 cos(theta2) + 0.4 cos(theta2 + theta3) = 0, theta2 + theta3 near pi. */
function shoulder(a1: number, bend: number): number[] {
  const both = Math.PI - bend / 10;
  const theta2 = Math.acos((-a1 - 0.4 * Math.cos(both)) / 0.5);
  return [theta2, both - theta2];
}

const folded = (at: Readonly<Record<string, number>>) => {
  const reach = at["a1"]! + at["a2"]! * Math.cos(at["theta2"]!) + at["a3"]! * Math.cos(at["theta2"]! + at["theta3"]!);
  return Math.abs(Math.sin(at["theta3"]! + 30 * DEGREE) * reach) < 1e-6;
};

test.each([
  ["theta3 = -pi/6, theta3 = 5*pi/6", [message("slip.tie-left-out")]],
  ["a1 + a2*c2 + a3*c23 = 0", [message("slip.values-left-out")]],
  ["theta3 = -pi/6, a1 + a2*c2 + a3*c23 = 0", [aboutJoint("slip.half-turn", "theta3")]],
  ["theta3 = 0, theta3 = pi, a1 + a2*c2 + a3*c23 = 0", [aboutJoint("slip.offset", "theta3")]],
  ["theta3 = pi/6, theta3 = -5*pi/6, a1 + a2*c2 + a3*c23 = 0", [aboutJoint("slip.offset-sign", "theta3")]],
  ["theta3 = -pi/12, theta3 = 5*pi/6, a1 + a2*c2 + a3*c23 = 0", [aboutJoint("slip.half-radians", "theta3")]],
  ["theta3 = -30, theta3 = 150, a1 + a2*c2 + a3*c23 = 0", [message("slip.degrees")]],
  ["theta3 = -pi/6*pi/180, theta3 = 5*pi/6, a1 + a2*c2 + a3*c23 = 0", [message("slip.radians")]],
  [
    "theta3 = -pi/6, theta3 = 5*pi/6, theta1 = 0, a1 + a2*c2 + a3*c23 = 0",
    [aboutJoint("slip.called-singular", "theta1")],
  ],
  [
    "theta3 = -pi/6 and theta1 = 0, theta3 = 5*pi/6, a1 + a2*c2 + a3*c23 = 0",
    [aboutJoint("slip.too-narrow", "theta1")],
  ],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a1 + a2*c2 - a3*c23 = 0", [inCondition("slip.sign")]],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a1 + a2*c2 + a3*c3 = 0", [inCondition("slip.relative")]],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a2*c2 + a3*c23 = 0", [inCondition("slip.term-missing", "a1")]],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a1 + a2*s2 + a3*s23 = 0", [inCondition("slip.all-waves")]],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a1 + a2*c2 + a3*c23 + a1*a2 = 0", [inCondition("slip.term-extra")]],
  ["theta3 = -pi/6, theta3 = 5*pi/6, a1^3 + a2*s2 = 0", undefined],
  [
    "theta3 = -pi/6, theta3 = 5*pi/6, a1 + a2*c1 + a3*cos(theta1 + theta3) = 0",
    [aboutJoint("slip.other-joint", "theta1")],
  ],
  ["theta1 + theta2 = 0", undefined], // sin(theta3 + pi/6) times this vanishes, too
])("for an elbow arm's set %s, the mistake is reported", (typed, slips) => {
  const offsets = new Map([["theta3", 30 * DEGREE]]);
  expect(judgeSet(typed, ELBOW, new Set(ELBOW.joints), folded, offsets).slips).toEqual(slips);
});

function inCondition(key: string, what?: string) {
  return message(key as TextKey, { where: message("slip.tie"), ...(what ? { what } : {}) });
}

test("if values must hold together, a claim with only one is reported", () => {
  const both: ConfigurationsKey = { ...SET, pieces: [SET.pieces[0]!.map(([a1, a2]) => [a1!, a2!, 0, 0])] };
  const straight = (at: Readonly<Record<string, number>>) =>
    Math.abs(Math.sin(at["theta1"]! / 2)) + Math.abs(Math.sin(at["theta2"]! / 2)) < 1e-6;
  const slipsOf = (typed: string) => judgeSet(typed, both, ANGLES, straight).slips;
  expect(slipsOf("theta2 = 0")).toEqual([aboutJoint("slip.and-missing", "theta2")]);
  expect(slipsOf("theta1 = 0 and theta2 = 0")).toBeUndefined();
});

/** Singular where the second joint or the third is at 0 or pi; the third joint's pieces come first. */
const TWO: ConfigurationsKey = {
  ...SET,
  joints: ["theta1", "theta2", "theta3"],
  symbols: ["theta1", "theta2", "theta3"],
  pieces: [
    ...[0, Math.PI].map((value) => [0.4, -1.3].map((other) => [other, 0.7 + other, value])),
    ...[0, Math.PI].map((value) => [0.4, -1.3].map((other) => [other, value, 0.7 + other])),
  ],
};

test.each([
  ["theta2 = 0, theta3 = 0", "theta2"],
  ["theta2 = 0, theta2 = pi, theta3 = 0", "theta3"],
  ["theta2 = pi/2, theta1 = 1", "theta2"],
])("for %s, the shown pose belongs to the first reported slip: %s", (typed, joint) => {
  const isSingular = (at: Readonly<Record<string, number>>) =>
    ["theta2", "theta3"].some((each) => Math.abs(Math.sin(at[each]!)) < 1e-6);
  const { slips, counterexample } = judgeSet(typed, TWO, new Set(TWO.joints), isSingular);
  expect(slips![0]).toEqual(expect.objectContaining({ values: { joint: joint.replace("theta", "θ") } }));
  const value = Math.abs(counterexample![joint]!);
  expect([Math.PI, Math.PI / 2].some((due) => Math.abs(value - due) < 1e-6)).toBe(true);
});

test("a level without mistakes hides slips", () => {
  const verdict = judgeValues("a1*s2", keyOf([["a1*a2*s2"]]));
  expect(verdict.slips).toHaveLength(1);
  expect(limitVerdict(verdict, "outcome").slips).toBeUndefined();
  expect(limitVerdict(verdict, "mistake").slips).toEqual(verdict.slips);
});
