// @vitest-environment happy-dom
// The dots of a lesson: as many as there are right answers needed in a row.
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { expect, test } from "vitest";

import { Dots } from "../src/learn/dots.js";
import { NEW_SKILL } from "../src/practice/skills.js";

test.each([
  [1, "●", "1 of 1 right in a row"],
  [2, "●○", "1 of 2 right in a row"],
  [5, "●○○", "1 of 3 right in a row"],
])("a class of %i arms", (count, dots, words) => {
  const items = Array.from({ length: count }, (_, i) => ({ family: "planar-2r", key: `00${i}`, question: "jacobian" }));
  const skill = { ...NEW_SKILL, row: ["planar-2r/000"] };
  void act(() => render(h(Dots, { skill, classes: [{ name: "plain", items }] }), document.body));
  expect(document.querySelector(".dots")!.textContent).toBe(dots + words);
  render(null, document.body);
});
