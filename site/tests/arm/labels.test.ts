// Where letters stand: beside what they name, and not under words that lie over the drawing.
import { expect, test } from "vitest";

import { placeLabels, type WantedLabel } from "../../src/arm/labels.js";

const P: WantedLabel = { name: "P", className: "", place: [50, 92], direction: [0, 1] };
const room = { width: 200, height: 120, covered: [] };
const words = { left: 0, right: 120, top: 96, bottom: 120 };

test("a label is placed on the wanted side, unless texts cover it", () => {
  expect(placeLabels([P], [], room)[0]!.y).toBeGreaterThan(96);
  const [clear] = placeLabels([P], [], { ...room, covered: [words] });
  expect(clear!.y + 9).toBeLessThanOrEqual(96);
  expect(placeLabels([P], [], { ...room, covered: [{ ...words, left: 130, right: 200 }] })[0]!.y).toBeGreaterThan(96);
});

test("a label without a visible place is omitted", () =>
  expect(placeLabels([P], [], { ...room, covered: [{ left: 0, right: 200, top: 0, bottom: 120 }] })).toEqual([]));

test("a label avoids an arrow that is much longer than the page, and is placed at once", () => {
  const start = performance.now();
  const [label] = placeLabels(
    [{ name: "P", className: "", place: [100, 100], direction: [1, 0] }],
    [
      [
        [100, 100],
        [1e9, 100],
      ],
    ],
    { width: 400, height: 300, covered: [] },
  );
  expect(Math.abs(label!.y - 100)).toBeGreaterThan(8);
  expect(performance.now() - start).toBeLessThan(200);
});
