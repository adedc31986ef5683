// Straight paths: the point stays on the line, the rates are J^-1 v, and the arm stops where it cannot go on.

import { describe, expect, it } from "vitest";

import { armOf, reachOf, stateAt } from "../../src/arm/model.js";
import { limitCrossings, follow, whyNoPath, pathTo, pointOn, stationOn, suggestTarget } from "../../src/arm/path.js";
import { firstPose } from "../../src/arm/ranges.js";
import { norm, subtract, multiply } from "../../src/arm/vector.js";
import { PLAIN, ROBOTS } from "./robots.js";

describe.each(Object.entries({ ...ROBOTS, PLAIN }))("paths of %s", (_, robot) => {
  const arm = armOf(robot);
  const pose = firstPose(arm);

  it("stay on the line, with the rates that follow from J", () => {
    const target = suggestTarget(arm, pose, reachOf(arm), true);
    const journey = follow(arm, pose, pathTo(arm, pose, target));
    expect(journey.reachesEnd).toBe(true);
    expect(journey.stations.length).toBeGreaterThan(20);
    for (const { s, pose: now, slopes } of journey.stations) {
      const state = stateAt(arm, now);
      const due = pointOn(journey.path, s);
      arm.task.filter((row) => row < 3).forEach((row) => expect(state.point[row]).toBeCloseTo(due[row]!, 8));
      const moved = multiply(state.taskJacobian, slopes);
      arm.task.forEach((row, k) => expect(moved[k]).toBeCloseTo(journey.path.unit[row] ?? 0, 8));
    }
    const half = stationOn(journey, journey.path.length / 2);
    expect(norm(subtract(stateAt(arm, half.pose).point, pointOn(journey.path, half.s)))).toBeLessThan(1e-3);
  });

  it("end near a singularity, where the rates become very large", () => {
    const target = suggestTarget(arm, pose, reachOf(arm), false);
    const journey = follow(arm, pose, pathTo(arm, pose, target));
    const most = journey.stations.map(({ slopes }) => Math.max(...slopes.map(Math.abs)));
    expect(Math.max(...most)).toBeGreaterThan(2 * most[0]!);
  });
});

describe("a path out of reach", () => {
  const arm = armOf(PLAIN);
  const pose = [0, Math.PI / 2];

  it("stops at the boundary, and shows where limits are exceeded", () => {
    const journey = follow(arm, pose, pathTo(arm, pose, [1.5, 0.4, 0]));
    expect(journey.reachesEnd).toBe(false);
    const end = journey.stations.at(-1)!;
    const edge = Math.sqrt(0.81 - 0.16) - 0.5;
    expect(end.s).toBeLessThan(edge);
    expect(end.s).toBeGreaterThan(edge - 0.005);
    const [, second] = limitCrossings(journey, 0.1, [Infinity, 1]);
    const there = stationOn(journey, second!);
    expect(Math.abs(there.slopes[1]!) * 0.1).toBeCloseTo(1, 6);
    expect(limitCrossings(journey, 0.1, [Infinity, Infinity])).toEqual([null, null]);
  });

  it("is not offered for an arm whose task counts only rotations", () => {
    expect(whyNoPath({ ...arm, task: [5] })).toBe("turns");
    expect(whyNoPath({ ...arm, task: [0, 1, 2] })).toBe("rows");
    expect(whyNoPath(arm)).toBeNull();
  });
});
