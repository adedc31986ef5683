// One's own arm against Python: tables of all kinds, J to twelve digits, the usual task, and the file for `qdot solve`.
import { describe, expect, test } from "vitest";

import { armOf, measuresOf, stateAt } from "../src/arm/model.js";
import { writeToml } from "../src/own/file.js";
import { writeFragment, parseFragment, type Fragment } from "../src/own/link.js";
import { makeRobot } from "../src/own/standard.js";
import {
  type Faults,
  makeRow,
  findUnitWarning,
  parseTable,
  type Numbers,
  type Table,
  changeKind,
  removeRow,
  ZEROS,
} from "../src/own/table.js";
import arms from "./arms.json" with { type: "json" };

interface Case {
  readonly table: Table;
  readonly toml: string;
  readonly task: readonly string[];
  readonly q: readonly number[];
  readonly jacobian: readonly (readonly number[])[];
  readonly det: number | null;
  readonly sigma: readonly number[];
}

const CASES = (arms as unknown as readonly Case[]).map((each): [string, Case] => [each.table.name, each]);
const EXACT = 1e-12;

function read(table: Table): Numbers {
  const numbers = parseTable(table);
  if (numbers instanceof Map) throw new Error(JSON.stringify([...numbers]));
  return numbers as Numbers;
}

describe("a typed table describes the same arm as in Python:", () => {
  test.each(CASES)("%s", (_, { table, task, q, jacobian, det, sigma }) => {
    const robot = makeRobot(table, read(table));
    expect(robot.task).toEqual(task);
    const arm = armOf(robot);
    const state = stateAt(arm, q);
    const most = Math.max(1, ...jacobian.flat().map(Math.abs));
    const off = jacobian.map((row, k) => row.map((value, i) => Math.abs(value - state.jacobian[k]![i]!)));
    expect(Math.max(...off.flat())).toBeLessThan(EXACT * most);
    const measures = measuresOf(arm, state);
    if (det === null) expect(measures.det).toBeNull();
    else expect(Math.abs(measures.det! - det)).toBeLessThan(EXACT * Math.max(1, sigma[0]! ** sigma.length));
    expect(measures.sigma.length).toBe(sigma.length);
    sigma.forEach((value, i) =>
      expect(Math.abs(measures.sigma[i]! - value)).toBeLessThan(1e-7 * Math.max(1, sigma[0]!)),
    );
  });
});

test.each(CASES)("the ROBOT.toml of %s is the one that was read", (_, { table, toml }) =>
  expect(writeToml(table)).toBe(toml),
);

const ONE: Table = {
  name: "mine",
  convention: "dh",
  angles: "radians",
  rows: [makeRow("R", 0), makeRow("R", 1)],
  tool: ZEROS,
  place: ZEROS,
  turn: ZEROS,
  task: null,
};
const withCell = (entry: "theta" | "d" | "a" | "alpha", text: string, angles: Table["angles"] = "radians") =>
  parseTable({ ...ONE, angles, rows: [{ ...makeRow("R", 0), [entry]: text }] });

describe("a cell", () => {
  test.each([
    ["a", "0,4", 0.4],
    ["a", "200 mm", 0.2],
    ["a", "½", 0.5],
    ["a", "", 0],
    ["a", "−0.5", -0.5],
    ["alpha", "π/2", Math.PI / 2],
    ["alpha", "90°", Math.PI / 2],
    ["a", "0,4 m", 0.4],
    ["a", "40cm - 5 mm", 0.395],
    ["theta", "q1 + 90°", Math.PI / 2],
    ["theta", "theta1 - pi/2", -Math.PI / 2],
    ["theta", "pi/2 + q1", Math.PI / 2],
    ["theta", "0", 0],
    ["theta", "θ1", 0],
  ] as const)("%s is read: %s", (entry, text, value) => {
    const found = withCell(entry, text);
    expect(found).not.toBeInstanceOf(Map);
    expect((found as Numbers).rows[0]![entry]).toBeCloseTo(value, 14);
  });

  test.each([
    ["theta", "2*q1", "radians", "own.moves"],
    ["theta", "sin(q1)", "radians", "own.moves"],
    ["theta", "q1**2", "radians", "own.moves"],
    ["theta", "q2", "radians", "own.letters"],
    ["a", "a1", "radians", "own.letters"],
    ["a", "constructor", "radians", "own.letters"],
    ["a", "q1", "radians", "own.letters"],
    ["a", "1/0", "radians", "own.not-real"],
    ["a", "sqrt(-1)", "radians", "own.not-real"],
    ["a", "1e7", "radians", "own.out-of-range"],
    ["a", "pi", "radians", "own.pi"],
    ["alpha", "90", "radians", "own.in-radians"],
    ["alpha", "pi/2", "degrees", "own.in-degrees"],
    ["alpha", "0.4 m", "degrees", "own.no-angle"],
    ["a", "90°", "degrees", "own.no-length"],
    ["theta", "q1 + atan(1)", "degrees", "own.in-degrees"],
    ["a", "[1, 2]", "radians", "read.no-expression"],
    ["a", "(1", "radians", "read.at"],
    ["a", "fetch('x')", "radians", "read.at"],
    ["a", "1+".repeat(60) + "1", "radians", "read.long"],
  ] as const)("%s is refused: %s in %s", (entry, text, angles, key) => {
    const found = withCell(entry, text, angles);
    expect(found).toBeInstanceOf(Map);
    const faults = [...(found as Faults)].map(([cell, { key }]) => [cell, key]);
    expect(faults).toEqual([[`rows/0/${entry}`, key]]);
  });
});

test.each([
  ["90°", "90", 90],
  ["45 deg + 0.5°", "45 + 0.5", 45.5],
  ["0,5 rad", `0.5*${180 / Math.PI}`, 90 / Math.PI],
] as const)("in degrees, %s is accepted, and saved for `qdot solve` without its unit", (text, saved, degrees) => {
  const found = withCell("alpha", text, "degrees") as Numbers;
  expect(found.rows[0]!.alpha).toBeCloseTo((degrees * Math.PI) / 180, 14);
  const toml = writeToml({ ...ONE, angles: "degrees", rows: [{ ...makeRow("R", 0), a: "400mm", alpha: text }] });
  expect(toml).toContain(`a = "400/1000"\nalpha = "${saved}"`);
});

test.each([
  ["alpha", "1.5708", "degrees", "own.looks-radians"],
  ["theta", "q1 - 3.1416", "degrees", "own.looks-radians"],
  ["alpha", "1.57", "radians", "own.rounded"],
  ["a", "400", "radians", "own.millimetres"],
  ["alpha", "pi/2", "radians", undefined],
  ["alpha", "1.5", "degrees", undefined],
] as const)("%s = %s in %s is probably in another unit or rounded: %s", (entry, text, angles, key) =>
  expect(findUnitWarning(withCell(entry, text, angles) as Numbers, angles)?.key).toBe(key),
);

test("after a joint is changed or removed, each joint variable has its own number", () => {
  expect(changeKind(makeRow("R", 1), "P", 1)).toEqual({ kind: "P", theta: "0", d: "q2", a: "0", alpha: "0" });
  const rows = [makeRow("R", 0), makeRow("P", 1), { ...makeRow("R", 2), theta: "-q3 + pi/2" }];
  expect(removeRow(rows, 0).map(({ theta, d }) => [theta, d])).toEqual([
    ["0", "q1"],
    ["-q2 + pi/2", "0"],
  ]);
});

describe("a link", () => {
  test.each(CASES)("to %s is parsed back to the same table", (_, { table }) => {
    const pose = table.rows.map((_, i) => 10 * i - 12.25);
    const fragment = writeFragment(table, null, pose);
    expect(fragment).toMatch(/^#[\w.~%&=+()!*'-]+$/);
    expect(parseFragment(fragment)).toEqual({ robot: null, table, pose });
  });

  test("contains the name of a known robot", () => {
    expect(parseFragment(writeFragment(ONE, "panda", [1, 2.5]))).toEqual({
      robot: "panda",
      table: null,
      pose: [1, 2.5],
    });
  });

  test.each(["", "#", "#main"])("without a table is ignored: %s", (fragment) =>
    expect(parseFragment(fragment)).toBeNull(),
  );

  test.each([
    "#dh=",
    "#dh=R",
    "#dh=X_1_2_3_4",
    "#dh=R_1_2_3",
    "#dh=R_1_2_3_4_5",
    "#dh=R_%E0%A4%A_0_0_0",
    `#dh=${"R_q_0_0_0~".repeat(12)}R_q_0_0_0`,
    `#dh=R_${"1".repeat(500)}_0_0_0`,
    `#dh=${"x".repeat(30000)}`,
    "#dh=R_0_0_0_0&tool=1_2",
  ])("that is no table says so: %s", (fragment) => {
    expect(parseFragment(fragment)).toBe("unreadable");
  });

  test("with an invalid pose or task keeps the table", () => {
    const found = parseFragment("#dh=R_q1_0_1_0&at=1_x&task=foo_vx_vx&angles=turns&__proto__=1") as Fragment;
    expect(found.pose).toBeNull();
    expect(found.table!.task).toEqual(["vx"]);
    expect(found.table!.angles).toBe("radians");
    expect((parseFragment("#dh=R_q1_0_1_0&at=1_2_3") as Fragment).pose).toBeNull();
  });
});
