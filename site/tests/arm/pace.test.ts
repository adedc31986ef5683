// @vitest-environment happy-dom
// During a drag, one part of the numbers is redrawn per frame; otherwise all are redrawn at once.

import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";

import { startAnimation, withPace } from "../../src/pace.js";

const drawings: string[] = [];
const Part = withPace(
  ({ name, value }: { name: string; value: number }) => {
    drawings.push(`${name}${value}`);
    return h("p", null, value);
  },
  { atOnce: ["name"], inTurn: ["value"] },
);
const frames: (() => void)[] = [];
const frame = (): void => {
  for (const due of frames.splice(0)) void act(due);
};
const show = (value: number, names = ["a", "b", "c"]): void =>
  void act(() =>
    render(
      names.map((name, key) => h(Part, { key, name, value })),
      document.body,
    ),
  );
const pointer = (event: string): void => void dispatchEvent(new Event(event));
const since = (): string[] => drawings.splice(0);

beforeEach(() => {
  document.body.textContent = "";
  vi.stubGlobal("requestAnimationFrame", (due: () => void) => frames.push(due));
  show(0);
  since();
});

afterEach(() => {
  pointer("pointerup");
  for (let i = 0; i < 9; i += 1) frame();
  render(null, document.body);
});

it("shows all parts at once while nothing is dragged", () => {
  show(1);
  expect(since()).toEqual(["a1", "b1", "c1"]);
});

it("shows one part, with its latest value, in every other frame of a drag", () => {
  pointer("pointerdown");
  show(1);
  expect(since()).toEqual([]);
  const found: string[][] = [];
  for (let value = 2; value < 10; value += 1) {
    frame();
    found.push(since());
    show(value);
  }
  expect(found).toEqual([["a1"], [], ["b3"], [], ["c5"], [], ["a7"], []]);
});

it("shows all parts at the end of a drag", () => {
  pointer("pointerdown");
  for (let value = 1; value < 5; value += 1) show(value);
  void act(() => pointer("pointerup"));
  expect(since()).toEqual(["a4", "b4", "c4"]);
});

it("shows the latest value of each part once nothing changes", () => {
  pointer("pointerdown");
  for (let value = 1; value < 5; value += 1) show(value);
  for (let i = 0; i < 6; i += 1) frame();
  expect(since()).toEqual(["a4", "b4", "c4"]);
  expect(document.body.textContent).toBe("444");
});

it("shows other properties at once, also during a drag", () => {
  pointer("pointerdown");
  show(1, ["d", "e", "f"]);
  expect(since()).toEqual(["d1", "e1", "f1"]);
  frame();
  frame();
  expect(since()).toEqual([]);
});

it("forgets a part that was removed", () => {
  pointer("pointerdown");
  show(1);
  render(null, document.body);
  for (let i = 0; i < 6; i += 1) frame();
  expect(since()).toEqual([]);
});

it("slows down the parts while an arm moves by itself, too", () => {
  const stopped = startAnimation();
  show(1);
  expect(since()).toEqual([]);
  stopped();
  show(2);
  expect(since()).toEqual(["a2", "b2", "c2"]);
});
