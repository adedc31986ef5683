// Where the names of joint rates stand beside their curves.
import { describe, expect, it } from "vitest";

import { countColumns, spreadNames } from "../../src/arm/chart.js";

const HEIGHTS = [
  [60, 60, 60, 60, 60, 60, 60],
  [10, 12, 14, 100, 101, 102, 103],
  [-40, 300, 20, 21, 22, 23, 24],
  [50, 20],
];

describe.each(HEIGHTS)("the names of curves that end at %i, %i, …", (...heights) => {
  it.each([[40], [80], [180]])("do not overlap in %i pixels, and have the order of the curves", (room) => {
    const columns = countColumns(heights.length, room);
    const names = spreadNames(heights, [16, 16 + room], columns);
    for (const { height } of names) expect(height >= 16 - 1e-9 && height <= 16 + room + 1e-9).toBe(true);
    names.forEach((one, i) =>
      names.forEach((other, k) => {
        if (i !== k && one.column === other.column)
          expect(Math.abs(one.height - other.height)).toBeGreaterThanOrEqual(15);
        if (heights[i]! < heights[k]!) expect(one.height).toBeLessThanOrEqual(other.height);
      }),
    );
  });
});

it("form a second column if one has no room", () => {
  expect([countColumns(2, 60), countColumns(7, 180), countColumns(7, 80), countColumns(7, 40)]).toEqual([1, 1, 2, 3]);
});
