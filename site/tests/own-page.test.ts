// @vitest-environment happy-dom
// The page of one's own arm: its pose stays while the table is typed, and a table of one's own can be begun with.

import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";

import type { KnownArm } from "../src/own/known-arms.js";
import { OwnArm } from "../src/own/own-arm.js";
import { makeRow, ZEROS } from "../src/own/table.js";

// All at once: what is shown is tested here, not when.
vi.mock("../src/scheduling.js", async (real) => ({
  ...(await real<typeof import("../src/scheduling.js")>()),
  useSteps: (last: number) => last,
}));

const ARM: KnownArm = {
  ...{ key: "plain", name: "Plain", convention: "dh", angles: "radians", task: null },
  rows: [0, 1, 2].map((row) => ({ ...makeRow("R", row), a: "0.5" })),
  ...{ tool: ZEROS, place: ZEROS, turn: ZEROS },
};
const angles = (): string[] =>
  [...document.querySelectorAll<HTMLInputElement>(".arm-joint-row input[type=number]")].map(({ value }) => value);
const lengths = (): HTMLInputElement[] =>
  [...document.querySelectorAll<HTMLInputElement>('.own-row input[aria-label^="a"]')].filter(
    ({ ariaLabel, value }) => !ariaLabel?.includes("alpha") && value === "0.5",
  );

afterEach(() => {
  render(null, document.body);
  window.location.hash = "";
});

test("an arm that was not moved keeps its pose while a length is typed", () => {
  void act(() => render(h(OwnArm, { knownArms: { format: 1, plain: [ARM], robots: [] } }), document.body));
  const before = angles();
  expect(before).toHaveLength(3);
  const [first] = lengths();
  first!.value = "0.05";
  void act(() => void first!.dispatchEvent(new Event("input", { bubbles: true })));
  expect(lengths()).toHaveLength(2);
  expect(angles()).toEqual(before);
});

test("a student can begin with an empty table", () => {
  void act(() => render(h(OwnArm, { knownArms: { format: 1, plain: [ARM], robots: [] } }), document.body));
  const choice = document.querySelector<HTMLSelectElement>(".own-begin select")!;
  const [own] = choice.options;
  expect(own!.disabled).toBe(false);
  choice.value = "";
  void act(() => void choice.dispatchEvent(new Event("change", { bubbles: true })));
  expect(document.querySelectorAll(".own-row")).toHaveLength(2);
  expect(angles()).toHaveLength(2);
});

test("sliders and the table have the chosen unit, at first degrees", () => {
  void act(() => render(h(OwnArm, { knownArms: { format: 1, plain: [ARM], robots: [] } }), document.body));
  const units = (): string[] => [...document.querySelectorAll(".arm-unit")].map((each) => each.textContent!);
  const chosen = (): HTMLInputElement[] => [
    ...document.querySelectorAll<HTMLInputElement>(".own-choice:nth-child(2) input"),
  ];
  const degrees = angles().map(Number);
  expect([units(), chosen().map(({ checked }) => checked)]).toEqual([Array(3).fill("°"), [false, true]]);
  void act(() => chosen()[0]!.click());
  expect(units()).toEqual(Array(3).fill("rad"));
  angles().forEach((value, i) => expect(Number(value)).toBeCloseTo((degrees[i]! * Math.PI) / 180, 3));
});
