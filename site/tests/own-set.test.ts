// Sets of configurations that an instructor asks for: sets other than that of the singular configurations.
import { expect, test } from "vitest";

import type { ConfigurationsKey } from "../src/bank.js";
import { limitVerdict } from "../src/grade/levels.js";
import { createZeroTest, judgeSet } from "../src/grade/sets.js";
import { textOf } from "../src/text/text.js";

/** The height of P is zero: d3 = 0 or theta2 = +-pi/2, although J is regular there. */
const KEY: ConfigurationsKey = {
  type: "configurations",
  joints: ["theta1", "theta2", "d3"],
  symbols: ["d3", "theta1", "theta2"],
  zeros: ["d3*cos(theta2)"],
  pieces: [[[0, 0.3, 1.1]], [[0.7, -1.2, Math.PI / 2]], [[0.4, 2.2, -Math.PI / 2]]],
  conditions: [1, 2],
  mistakes: [],
};

const judge = (typed: string) => ({
  ...judgeSet(typed, KEY, new Set(["theta1", "theta2"]), createZeroTest(KEY.zeros ?? [], KEY.symbols)),
  ofOwnSet: true,
});

test.each(["d3 = 0, theta2 = pi/2, theta2 = -pi/2", "d3*cos(theta2) = 0", "cos(theta2) = 0 or d3 = 0"])(
  "%s is the whole set",
  (typed) => expect(judge(typed).outcome).toBe("correct"),
);

test("a product earns what its factors earn", () => {
  expect(judge("d3*sin(theta2) = 0").share).toBe(judge("d3 = 0, sin(theta2) = 0").share);
  expect(judge("0 = d3*sin(theta2)").share).toBe(judge("d3*sin(theta2) = 0").share);
  expect(judge("d3*sin(theta2) = 0").share).toBeGreaterThan(0);
  expect(judge("d3*tan(theta1) = 0").share).toBe(judge("d3 = 0, tan(theta1) = 0").share);
  expect(judge("d3*tan(theta1) = 0").share).toBeGreaterThan(0);
  expect(judge("d3*tan(theta1)*tan(theta1) = 0").share).toBe(judge("d3*tan(theta1) = 0").share);
  expect(judge("d3*sin(theta1)/cos(theta1)^2 = 0").share).toBe(judge("d3*tan(theta1)^2 = 0").share);
  expect(judge("d3*tan(theta2)*cos(theta2) = 0").share).toBe(0); // tan(theta2)*cos(theta2) is not 0 at 90 degrees
});

test.each(["d3 = 0", "theta2 = pi/2", "d3 = 0, theta1 = 0", "d3 = 0, theta2 = 1.57, theta2 = -1.57"])(
  "no message on %s speaks of singular configurations",
  (typed) => {
    const { reasons, slips = [] } = limitVerdict(judge(typed), "counterexample");
    const texts = [...reasons, ...slips].map((item) => ("key" in item ? textOf(item) : ""));
    expect(texts.join(" ")).not.toMatch(/singular|\bJ\b|full rank/);
    expect(reasons.length).toBeGreaterThan(0);
  },
);
