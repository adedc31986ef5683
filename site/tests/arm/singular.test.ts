// Singular sets on a map: where the lines run, and which of them are boundaries.

import { describe, expect, it } from "vitest";

import { kindAt, canDecideKind } from "../../src/arm/classify.js";
import { armOf, measuresOf, signedVolume, stateAt } from "../../src/arm/model.js";
import {
  gridOf,
  type Spot,
  cutByKind,
  findZeroMinima,
  findZeroMinimumLines,
  findZeroLines,
} from "../../src/arm/zeros.js";
import { ELBOW, PLAIN, ROBOTS, SIX } from "./robots.js";

const CIRCLE: Spot = [-Math.PI, Math.PI];

describe("the planar 2R arm", () => {
  const arm = armOf(PLAIN);
  const value = (u: number, v: number): number => signedVolume(arm, [u, v]);

  it("is singular on theta2 = 0 and pi, where its point is at the boundary", () => {
    const lines = findZeroLines(gridOf(CIRCLE, [-1, 5], 36, value), value);
    expect(lines).toHaveLength(2);
    const levels = lines.map((line) => line[0]![1]).sort((a, b) => a - b);
    expect(levels[0]).toBeCloseTo(0, 9);
    expect(levels[1]).toBeCloseTo(Math.PI, 9);
    for (const line of lines) {
      for (const [, v] of line) expect(Math.abs(v - line[0]![1])).toBeLessThan(1e-9);
      expect(line.length).toBeGreaterThanOrEqual(37);
      const found = cutByKind(line, 9, ([u, v]) => kindAt(arm, [u, v]));
      expect(found.map(({ kind }) => kind)).toEqual(["boundary"]);
    }
  });

  it("is regular elsewhere", () => {
    expect(kindAt(arm, [0.3, 0.7])).toBe("regular");
    expect(canDecideKind(arm)).toBe(true);
  });

  it("with equal links and folded back has an internal singularity, because there is no hole", () => {
    const even = armOf({ ...PLAIN, values: { a1: 0.4, a2: 0.4 } });
    expect(kindAt(even, [0.4, 0])).toBe("boundary");
    expect(kindAt(even, [0.4, Math.PI])).toBe("internal");
  });
});

describe("the elbow", () => {
  const arm = armOf(ELBOW);
  const onAxis = [0.3, Math.PI / 2 + 0.4, -Math.atan2(0.5 * Math.sin(0.4), 0)];

  it("is stretched out at the boundary", () => {
    expect(kindAt(arm, [0.3, 0.7, 0])).toBe("boundary");
    expect(kindAt(arm, [0.3, 0.7, Math.PI])).toBe("boundary");
  });

  it("has an internal shoulder singularity", () => {
    // P on the first axis: 0.5 cos(theta2) + 0.4 cos(theta2 + theta3) = 0.
    const theta2 = 1.2;
    const sum = Math.acos((-0.5 * Math.cos(theta2)) / 0.4);
    const pose = [onAxis[0]!, theta2, sum - theta2];
    expect(measuresOf(arm, stateAt(arm, pose)).ratio).toBeLessThan(1e-12);
    expect(kindAt(arm, pose)).toBe("internal");
  });

  it("has the same kinds in any size, also near a singularity", () => {
    const theta2 = 1.2;
    const theta3 = Math.acos((-0.5 * Math.cos(theta2)) / 0.4) - theta2;
    for (const scale of [0.001, 1000]) {
      const sized = armOf({ ...ELBOW, values: { a2: 0.5 * scale, a3: 0.4 * scale } });
      expect(kindAt(sized, [0.3, theta2, theta3 + 1e-3], 0.005)).toBe("internal");
      expect(kindAt(sized, [0.3, theta2, 1e-3], 0.005)).toBe("boundary");
      expect(kindAt(sized, [0.3, theta2, 0.5], 0.005)).toBe("regular");
    }
  });

  it("shows both kinds on the map of theta2 and theta3", () => {
    const value = (u: number, v: number): number => signedVolume(arm, [0, u, v]);
    const lines = findZeroLines(gridOf(CIRCLE, [-3, 3.3], 40, value), value);
    const kinds = lines
      .flatMap((line) => cutByKind(line, Math.ceil(line.length / 10), ([u, v]) => kindAt(arm, [0, u, v])))
      .map(({ kind }) => kind);
    expect(new Set(kinds)).toEqual(new Set(["boundary", "internal"]));
  });
});

describe("an arm with six joints and a wrist", () => {
  const arm = armOf(SIX);

  it("has an internal wrist singularity, and is at the boundary if its wrist centre is", () => {
    expect(canDecideKind(arm)).toBe(true);
    expect(kindAt(arm, [0.2, 0.5, 0.6, 0.7, 0, 0.3])).toBe("internal");
    expect(kindAt(arm, [0.2, 0.5, 0.6, 0.7, 0.4, 0.3])).toBe("regular");
    expect(kindAt(arm, [0.2, 0.5, Math.PI / 2, 0.7, 0.4, 0.3])).toBe("boundary");
  });
});

describe("redundant arms", () => {
  const arm = armOf(ROBOTS["planar-3r"]!);

  it("have singular spots, not lines", () => {
    const value = (u: number, v: number): number => signedVolume(arm, [0.3, u, v]);
    const grid = gridOf(CIRCLE, CIRCLE, 48, value);
    expect(findZeroLines(grid, value)).toEqual([]);
    const spots = findZeroMinima(grid, value, 1e-6);
    expect(spots.length).toBeGreaterThanOrEqual(4);
    for (const [u, v] of spots) expect(measuresOf(arm, stateAt(arm, [0.3, u, v])).ratio).toBeLessThan(1e-4);
    const kinds = spots.map(([u, v]) => kindAt(arm, [0.3, u, v], 1e-4));
    expect(kinds).toContain("boundary");
  });
});

describe("the SCARA arm", () => {
  it("is singular where its elbow is straight, at the boundary", () => {
    const arm = armOf(ROBOTS["scara"]!);
    expect(canDecideKind(arm)).toBe(true);
    expect(kindAt(arm, [0.3, -Math.PI / 4, 0.3, 0.2])).toBe("boundary");
  });
});

describe("lines on a grid", () => {
  const SQUARE: Spot = [-1, 1];

  it("are separate if two run through the same cell, and cross where they should", () => {
    const value = (u: number, v: number): number => (v - 0.3) * (v - 0.3 - 0.06 * (u - 0.004));
    const lines = findZeroLines(gridOf(SQUARE, SQUARE, 20, value), value);
    const ends = lines.flatMap((line) => [line[0]!, line.at(-1)!]).map(([u, v]) => [Math.abs(u), v] as const);
    const near = (level: number): boolean => ends.some(([u, v]) => u > 0.95 && Math.abs(v - level) < 5e-3);
    expect([near(0.3), near(0.3 + 0.06), near(0.3 - 0.06)]).toEqual([true, true, true]);
  });

  it("are found where a value touches zero and keeps its sign", () => {
    const value = (u: number, v: number): number => Math.abs(v - 0.31 * u) * (2 + u);
    const lines = findZeroMinimumLines(gridOf(SQUARE, SQUARE, 20, value), value, 1e-7);
    expect(lines).toHaveLength(1);
    expect(lines[0]!.length).toBeGreaterThan(20);
    for (const [u, v] of lines[0]!) expect(Math.abs(v - 0.31 * u)).toBeLessThan(1e-6);
    const spot = (u: number, v: number): number => Math.hypot(u - 0.11, v);
    expect(findZeroMinimumLines(gridOf(SQUARE, SQUARE, 20, spot), spot, 1e-7)).toEqual([]);
    const never = (u: number, v: number): number => Math.abs(v - 0.31 * u) + 0.01;
    expect(findZeroMinimumLines(gridOf(SQUARE, SQUARE, 20, never), never, 1e-7)).toEqual([]);
  });
});
