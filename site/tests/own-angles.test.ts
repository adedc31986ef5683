// A table's angles in the other unit are the same angles, and what can't be read stays as it was typed.
import { expect, test } from "vitest";

import { convertAngles } from "../src/own/angles.js";
import { makeRow, parseTable, type Numbers, type Table, ZEROS } from "../src/own/table.js";

const TABLE: Table = {
  ...{ name: "", convention: "dh", angles: "radians", task: null },
  rows: [
    { ...makeRow("R", 0), theta: "pi/2 - q1", a: "0.5", alpha: "-pi/2" },
    { ...makeRow("R", 1), theta: "q2 + 0.3", alpha: "2*pi/3" },
    { ...makeRow("P", 2), theta: "pi", alpha: "0.123456" },
  ],
  ...{ tool: ZEROS, place: ZEROS, turn: ["0", "pi/4", "-0.2"] },
};

const flat = ({ rows, turn }: Numbers): number[] => [
  ...rows.flatMap(({ theta, d, a, alpha, isReversed }) => [theta, d, a, alpha, Number(isReversed)]),
  ...turn,
];

test("typed angles are converted, and have the same values", () => {
  const degrees = convertAngles(TABLE, "degrees");
  expect(degrees.angles).toBe("degrees");
  expect(degrees.rows.map(({ theta, alpha }) => [theta, alpha])).toEqual([
    ["-q1 + 90", "-90"],
    ["q2 + 17.1887339", "120"],
    ["180", "7.07350776"],
  ]);
  const back = convertAngles(degrees, "radians");
  expect(back.rows[0]).toMatchObject({ theta: "-q1 + pi/2", alpha: "-pi/2", a: "0.5" });
  expect(back.turn).toEqual(["0", "pi/4", "-0.2"]);
  const due = flat(parseTable(TABLE) as Numbers);
  for (const table of [degrees, back])
    flat(parseTable(table) as Numbers).forEach((value, i) => expect(value).toBeCloseTo(due[i]!, 8));
});

test("an invalid or empty cell stays unchanged, and may be valid in the other unit", () => {
  const wrong = {
    ...TABLE,
    rows: [
      { ...makeRow("R", 0), alpha: "90" },
      { ...makeRow("R", 1), alpha: "" },
    ],
  };
  expect(convertAngles(wrong, "degrees").rows.map(({ alpha }) => alpha)).toEqual(["90", ""]);
});
