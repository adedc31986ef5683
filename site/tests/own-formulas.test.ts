// Formulas of J and det J from a typed table: they agree with the arm's numbers, and are factored as in textbooks.
import { describe, expect, it } from "vitest";

import { armOf, stateAt } from "../src/arm/model.js";
import { determinant } from "../src/arm/vector.js";
import { deriveFormulas, evaluateProduct, type Formulas, MAX_FORMULA_JOINTS } from "../src/own/formulas.js";
import { writeMatrix, writeProduct } from "../src/own/formula-latex.js";
import { makeRobot } from "../src/own/standard.js";
import { type Numbers, parseTable, type Table, type TypedRow, ZEROS } from "../src/own/table.js";
import { makeRandomNumbers } from "../src/random.js";

const table = (rows: string, more: Partial<Table> = {}): Table => ({
  ...{ name: "", convention: "dh", angles: "degrees", task: null, tool: ZEROS, place: ZEROS, turn: ZEROS },
  rows: rows.split(" ~ ").map((cells): TypedRow => {
    const [kind, theta, d, a, alpha] = cells.split(" ") as ["R" | "P", string, string, string, string];
    return { kind, theta, d, a, alpha };
  }),
  ...more,
});

function derive(typed: Table) {
  const numbers = parseTable(typed) as Numbers;
  const arm = armOf(makeRobot(typed, numbers));
  const formulas = deriveFormulas(
    arm,
    numbers.rows.map(({ isReversed }) => isReversed),
  );
  return { arm, formulas };
}

const det = (typed: Table): string => {
  const { determinant, ...names } = derive(typed).formulas as Formulas;
  return writeProduct(determinant as never, names).replace(/[{}_]/g, "");
};

describe("the determinant", () => {
  it.each([
    ["planar 2R", "R q1 0 0.5 0 ~ R q2 0 0.4 0", "a1 a2 s2"],
    ["planar 2R, equal lengths", "R q1 0 0.5 0 ~ R q2 0 0.5 0", "a1 a2 s2"],
    ["elbow", "R q1 0.4 0.2 -90 ~ R q2 0 0.34 0 ~ R q3 0 0.3 0", "a2 a3 s3 (a1 + a2 c2 + a3 c23)"],
    ["polar", "R q1 0.4 0 90 ~ R q2+90 0 0 90 ~ P 0 q3 0 0", "d3^2 c2"],
    ["SCARA", "R q1 0.4 0.3 0 ~ R q2 0 0.2 180 ~ P 0 q3 0 0 ~ R q4 0.1 0 0", "a1 a2 s2"],
    ["cylindrical", "R q1 0.4 0 0 ~ P 0 q2 0 -90 ~ P 0 q3 0 0", "d3"],
    ["one plane only", "R q1 0 0 0 ~ R q2 0 0.4 0", "0"],
  ])("of a %s arm is factored", (_, rows, expected) => {
    expect(det(table(rows)).replaceAll("  ", " ")).toBe(expected);
  });
});

it("a Jacobian is written row by row", () => {
  const { formulas } = derive(table("R q1 0 0.5 0 ~ P 90 q2 0 90"));
  expect(writeMatrix((formulas as Formulas).jacobian, formulas as Formulas)).toBe(
    "\\begin{bmatrix} -a_{1} s_{1} & 0 \\\\ a_{1} c_{1} & 0 \\\\ 0 & 1 \\end{bmatrix}",
  );
});

describe("random tables", () => {
  const next = makeRandomNumbers(57);
  const pick = <T>(...choices: readonly T[]): T => choices[Math.floor(next() * choices.length)]!;
  const length = (): string => pick("0", "0", (0.1 + next()).toFixed(2), `-${(0.1 + next()).toFixed(2)}`);
  const angle = (): string => pick("0", "0", "90", "-90", "180");
  const makeRow = (i: number): TypedRow => {
    const variable = pick(`q${i}`, `q${i}`, `-q${i}`);
    return pick<"R" | "P">("R", "R", "P") === "R"
      ? { kind: "R", theta: `${variable}+${pick("0", "90", "-90", "180")}`, d: length(), a: length(), alpha: angle() }
      : { kind: "P", theta: angle(), d: `${variable}+${pick("0", "0.2")}`, a: length(), alpha: angle() };
  };
  const tables = Array.from({ length: 60 }, (_, k) =>
    table("", {
      rows: Array.from({ length: 1 + (k % 3) }, (_, i) => makeRow(i + 1)),
      convention: pick("dh", "modified-dh"),
      tool: [length(), length(), "0"],
      place: [length(), "0", length()],
      turn: [angle(), angle(), angle()],
    }),
  );
  it("have formulas that agree with the arm's numbers", () => {
    let determinants = 0;
    for (const typed of tables) {
      const { arm, formulas } = derive(typed);
      if (typeof formulas === "string") {
        expect(formulas).toBe("long");
        continue;
      }
      const pose = arm.joints.map(() => 4 * next() - 2);
      const { taskJacobian } = stateAt(arm, pose);
      const isAngle = ({ kind }: { kind: string }): boolean => kind === "R";
      const variables = pose.filter((_, i) => !isAngle(arm.joints[i]!));
      const angles = pose.filter((_, i) => isAngle(arm.joints[i]!));
      const lengths = formulas.lengths.map(({ value }) => value ?? variables.shift()!);
      const values = formulas.jacobian.map((row) => row.map((entry) => evaluateProduct(entry, angles, lengths)));
      values.forEach((row, k) => row.forEach((value, j) => expect(value).toBeCloseTo(taskJacobian[k]![j]!, 9)));
      if (!formulas.determinant || formulas.determinant === "long") continue;
      determinants += 1;
      expect(evaluateProduct(formulas.determinant, angles, lengths)).toBeCloseTo(determinant(taskJacobian), 9);
    }
    expect(determinants).toBeGreaterThan(20);
  });

  it("have d with the sign of the table, also where a joint counts the other way", () => {
    const { formulas } = derive(table("R -q1 0.3 0 90 ~ R q2 0.2 0.4 0"));
    expect((formulas as Formulas).lengths.map(({ latex, value }) => `${latex} ${value}`)).toEqual([
      ...["d_{1} 0.3", "a_{2} 0.4", "d_{2} 0.2"],
    ]);
  });
});

it("other arms have none", () => {
  const reason = (typed: Table): unknown => derive(typed).formulas;
  expect(reason(table("R q1 0 0.5 30 ~ R q2 0 0.4 0"))).toBe("angles");
  expect(reason(table("R q1+10 0 0.5 0"))).toBe("angles");
  expect(reason(table("R q1 0 0.5 0", { turn: ["0", "0", "20"] }))).toBe("angles");
  const rows = Array.from({ length: MAX_FORMULA_JOINTS + 1 }, (_, i) => `R q${i + 1} 0 0.5 0`);
  expect(reason(table(rows.join(" ~ ")))).toBe("joints");
  const long = "R q1 0.1 0.2 90 ~ R q2 0.3 0.4 90 ~ R q3 0.2 0.3 90 ~ R q4 0.1 0.2 0";
  expect(reason(table(long, { tool: ["0.1", "0.2", "0.3"] }))).toBe("long");
});
