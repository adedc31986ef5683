// A Jacobian as it was typed, in numbers: the right one is the arm's own, a wrong one differs where it is wrong.
import { expect, test } from "vitest";

import { armOf, stateAt } from "../src/arm/model.js";
import type { Part, Problem } from "../src/bank.js";
import { parseTypedColumns } from "../src/grade/typed-jacobian.js";
import { PLAIN } from "./arm/robots.js";

const role = (name: string) => ({ role: name.startsWith("theta") ? "joint" : "length", unit: "", latex: name });
const problem = {
  robot: { ...PLAIN, values: { a1: 0.5, a2: 0.4 } },
  symbols: Object.fromEntries(["theta1", "theta2", "a1", "a2"].map((name) => [name, role(name)])),
} as unknown as Problem;
const part = (kind: string): Part =>
  ({ kind, labels: [], key: { type: "values", rows: 2, columns: 2 } }) as unknown as Part;
const RIGHT = "[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12]]";

test("a right Jacobian has the arm's columns at every pose", () => {
  const columns = parseTypedColumns(problem, part("jacobian"), RIGHT)!;
  for (const [theta1, theta2] of [
    [0.3, 1.1],
    [-2, 0.4],
  ] as const) {
    const { jacobian } = stateAt(armOf(problem.robot), [theta1, theta2]);
    const found = columns({ theta1, theta2 })!;
    found.forEach((column, i) => column.forEach((value, row) => expect(value).toBeCloseTo(jacobian[row]![i]!)));
  }
});

test("a wrong Jacobian differs, and other answers have no columns", () => {
  const columns = parseTypedColumns(problem, part("jacobian"), RIGHT.replace("-a2*s12]", "a2*s12]"))!;
  expect(columns({ theta1: 0.3, theta2: 1.1 })![1]![0]).toBeCloseTo(0.4 * Math.sin(1.4));
  expect(
    parseTypedColumns(problem, part("jacobian"), "[[1/0, 1], [1, 1]]")?.({ theta1: 0, theta2: 0 }) ?? null,
  ).toBeNull();
  for (const typed of ["", "a1", "[[1, 2]]", "[[a1,", "[[a1, blank], [blank, blank]]"])
    expect(parseTypedColumns(problem, part("jacobian"), typed)).toBeNull();
  expect(parseTypedColumns(problem, part("position"), RIGHT)).toBeNull();
});
