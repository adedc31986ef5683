// @vitest-environment happy-dom
// The place for an answer: a box for each entry, one box for a formula or for a matrix of too many entries.

import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test } from "vitest";

import type { Part, Problem } from "../src/bank.js";
import { Answer } from "../src/practice/answer.js";

const problem = { symbols: {} } as unknown as Problem;

function boxes(shape: Part["shape"]): number {
  const part = {
    ...{ kind: "jacobian", shape, key: { type: "formulas" }, grid: [[], []], names: [], labels: [] },
    columns: [],
  } as unknown as Part;
  const nothing = (): void => undefined;
  void act(() => render(h(Answer, { problem, part, onAnswer: nothing, onCheck: nothing }), document.body));
  return document.querySelectorAll(".answer input, .answer textarea").length;
}

afterEach(() => {
  render(null, document.body);
});

test.each([
  [null, 1],
  [[1, 1], 1],
  [[2, 1], 2],
  [[2, 2], 4],
  [[6, 7], 42],
  [[6, 8], 1],
] as const)("an answer of the shape %j has so many boxes: %i", (shape, count) => {
  expect(boxes(shape)).toBe(count);
});

test("a number has its unit beside its box, and no symbols are offered for it", () => {
  const part = { shape: null, key: { type: "numbers", units: ["m/s"] }, names: [] } as unknown as Part;
  const nothing = (): void => undefined;
  void act(() => render(h(Answer, { problem, part, onAnswer: nothing, onCheck: nothing }), document.body));
  expect(document.querySelector(".cell:has(> input) > .unit")!.textContent).toBe("m/s");
  expect(document.querySelector(".symbols")).toBeNull();
});
