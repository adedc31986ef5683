// The point of interest pulled: as far as the arm reaches, and further.
import { describe, expect, it } from "vitest";

import { type Arm, armOf, measuresOf, type Pose, reachOf, signedVolume, stateAt } from "../../src/arm/model.js";
import { movePoint } from "../../src/arm/moves.js";
import { makeRandomPoses } from "../../src/random.js";
import { extentOf, firstPose } from "../../src/arm/ranges.js";
import { add, dot, norm, scaleVector, subtract, type Vec3 } from "../../src/arm/vector.js";
import { FIRST_ORBIT, viewOf } from "../../src/arm/view.js";
import { classifyNearness } from "../../src/arm/descriptions.js";
import { ELBOW, PLAIN, ROBOTS } from "./robots.js";

const viewFor = (arm: Arm) => viewOf(arm, extentOf(arm), 560, 420, FIRST_ORBIT);

/** The arm's poses while a pointer pulls P through places, one event for each. */
function pulled(arm: Arm, pose: Pose, places: readonly Vec3[]): Pose[] {
  const view = viewFor(arm);
  const poses = [pose];
  for (const place of places) {
    const now = poses.at(-1)!;
    poses.push(movePoint(arm, now, subtract(place, stateAt(arm, now).point), view));
  }
  return poses.slice(1);
}

const ray = (from: Vec3, to: Vec3, events: number): Vec3[] =>
  Array.from({ length: events }, (_, k) => add(from, scaleVector(subtract(to, from), (k + 1) / events)));

const ratioAt = (arm: Arm, pose: Pose): number => measuresOf(arm, stateAt(arm, pose)).ratio;

describe("pulling P straight out past the reach", () => {
  const arm = armOf(PLAIN);
  const start: Pose = [0.4, 1.2];
  const { point } = stateAt(arm, start);

  it.each([1, 2, 5, 40])("leaves the arm straight after %i events, and does not flip it", (events) => {
    const places = ray(point, scaleVector(point, 4 / norm(point)), events);
    const poses = pulled(arm, start, places);
    poses.forEach((pose, k) => {
      expect(pose[1]).toBeGreaterThan(0);
      if (norm(places[k]!) < 0.9 + 1e-6) return;
      expect(classifyNearness(arm, measuresOf(arm, stateAt(arm, pose)))).toBe("singular");
      expect(Math.abs(signedVolume(arm, pose))).toBeLessThan(1e-4);
    });
  });

  it("bends the arm to its own side again on the way back", () => {
    const far = scaleVector(point, 4 / norm(point));
    const [, back] = pulled(arm, start, [far, point]);
    expect(subtract(stateAt(arm, back!).point, point).every((part) => Math.abs(part) < 1e-6)).toBe(true);
    expect(back![1]).toBeCloseTo(1.2, 5);
  });

  it("keeps the arm straight while the pointer circles outside", () => {
    const round = Array.from({ length: 50 }, (_, k): Vec3 => {
      const angle = 0.6 + (2 * Math.PI * k) / 50;
      return [2 * Math.cos(angle), 2 * Math.sin(angle), 0];
    });
    for (const pose of pulled(arm, start, round)) {
      expect(Math.abs(pose[1]!)).toBeLessThan(1e-4);
      expect(pose[1]).toBeGreaterThan(0);
    }
  });

  it("folds the arm back over the hole in its workspace", () => {
    for (const events of [1, 3, 30]) {
      const poses = pulled(arm, start, ray(point, scaleVector(point, 0.02), events));
      expect(Math.abs(poses.at(-1)![1]!)).toBeCloseTo(Math.PI, 4);
      expect(signedVolume(arm, poses.at(-1)!)).toBeGreaterThan(0);
    }
  });
});

it("a straight arm bends if P is pulled in", () => {
  const arm = armOf(PLAIN);
  const [pose] = pulled(arm, [0.3, 0], [[0.5, 0.2, 0]]);
  expect(norm(subtract(stateAt(arm, pose!).point, [0.5, 0.2, 0]))).toBeLessThan(1e-6);
});

describe.each(Object.entries({ ...ROBOTS, plain: PLAIN, elbow: ELBOW }))("P of %s", (_, robot) => {
  const arm = armOf(robot);
  const start = firstPose(arm);
  const view = viewFor(arm);
  const { point } = stateAt(arm, start);

  it("ends at a singularity or a joint limit if it is dragged far away", () => {
    const base = arm.base.o;
    for (const [right, up] of [
      [1, 0.3],
      [-1, 0.4],
      [0.2, 1],
    ] as const) {
      const way = add(scaleVector(view.right, right), scaleVector(view.up, up));
      const far = add(base, scaleVector(way, 5 * reachOf(arm)));
      for (const events of [1, 10]) {
        const end = pulled(arm, start, [...ray(point, far, events), far, far]).at(-1)!;
        expect(ratioAt(arm, end)).toBeLessThan(0.004);
      }
    }
  });

  it("follows the pointer within the reach", () => {
    const seen = (v: Vec3): number => norm([dot(view.right, v), dot(view.up, v)]);
    const off = makeRandomPoses(20, arm.joints.length, 12).map((turns) => {
      const pose = turns.map((value, i) => (arm.joints[i]!.kind === "R" ? value : 0.2 + 0.05 * value));
      const place = stateAt(arm, pose).point;
      const end = pulled(arm, start, [...ray(point, place, 4), place, place]).at(-1)!;
      return seen(subtract(stateAt(arm, end).point, place));
    });
    expect(off.filter((value) => value > 1e-4)).toEqual([]);
  });
});

it("a planar arm that comes back into its reach is bent to the same side as before", () => {
  const arm = armOf(PLAIN);
  for (const [one, two] of makeRandomPoses(60, 2, 5) as [number, number][]) {
    const bent = 0.3 + 0.8 * Math.abs(two); // not all but folded
    const start: Pose = [one, two < 0 ? -bent : bent];
    const out = scaleVector(stateAt(arm, start).point, 6);
    const home = stateAt(arm, [one + 0.8, start[1]!]).point;
    const poses = pulled(arm, start, [...ray(stateAt(arm, start).point, out, 3), ...ray(out, home, 4), home]);
    for (const pose of poses) expect(pose[1]! > 0).toBe(two > 0);
    expect(norm(subtract(stateAt(arm, poses.at(-1)!).point, home))).toBeLessThan(1e-6);
  }
});
