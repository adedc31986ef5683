// @vitest-environment happy-dom
// The scale of drawings is measured once, not at each move of the arm, and again after the window or its font changed.
import { expect, test, vi } from "vitest";

import { drawingScale } from "../../src/arm/size.js";

test("the scale is measured once for each size of the window", () => {
  window.dispatchEvent(new Event("resize"));
  const measure = vi.spyOn(globalThis, "getComputedStyle");
  document.documentElement.style.fontSize = "17px";
  expect([drawingScale(), drawingScale()]).toEqual([1, 1]);
  expect(measure).toHaveBeenCalledTimes(1);
  document.documentElement.style.fontSize = "34px";
  window.dispatchEvent(new Event("resize"));
  expect([drawingScale(), drawingScale()]).toEqual([2, 2]);
  expect(measure).toHaveBeenCalledTimes(2);
  document.documentElement.style.fontSize = "";
  window.dispatchEvent(new Event("resize"));
  measure.mockRestore();
});
