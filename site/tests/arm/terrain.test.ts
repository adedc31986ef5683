// The map of det J in numbers: where rank is lost all over it, nothing is left to be shaded.
import { describe, expect, it } from "vitest";

import { armOf } from "../../src/arm/model.js";
import { terrainOf } from "../../src/arm/terrain.js";
import { SIX } from "./robots.js";

const large = armOf(SIX);
const small = armOf({ ...SIX, values: { a2: 0.02, d4: 0.015 } });

describe.each(["det", "least"] as const)("a map of %s over theta2 and theta3", (shown) => {
  it.each([0, Math.PI, -Math.PI, 1e-7])("is empty where theta5 is %d, and J has no full rank", (theta5) => {
    const { max, lines, spots } = terrainOf(large, [0.3, 0, 0, 0.5, theta5, 0.2], [1, 2], shown);
    expect([max, lines, spots]).toEqual([0, [], []]);
  });

  it("is not empty at a visible angle, however small the arm", () => {
    for (const arm of [large, small]) {
      const { max, lines } = terrainOf(arm, [0.3, 0, 0, 0.5, 0.02, 0.2], [1, 2], shown);
      expect(max).toBeGreaterThan(0);
      expect(lines.length).toBeGreaterThan(0);
    }
  });
});
