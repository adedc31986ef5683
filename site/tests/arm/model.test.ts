// The arm in numbers against finite differences, closed forms and known singular values.

import { describe, expect, it } from "vitest";

import { armOf, measuresOf, pStar, signedVolume, stateAt } from "../../src/arm/model.js";
import { makeRandomNumbers, makeRandomPoses } from "../../src/random.js";
import { extentOf, firstPose, rangeOf, limitToRange } from "../../src/arm/ranges.js";
import { leastSquares, decompose, singularValues } from "../../src/arm/svd.js";
import { add, dot, norm, subtract, multiply, transpose } from "../../src/arm/vector.js";
import { FIRST_ORBIT, nearestOnLine, planeNormalOf, toPixel, viewOf } from "../../src/arm/view.js";
import { ELBOW, PLAIN, ROBOTS, SIX } from "./robots.js";

const ALL = { ...ROBOTS, PLAIN, ELBOW, SIX };

describe.each(Object.entries(ALL))("the Jacobian of %s", (_, robot) => {
  const arm = armOf(robot);

  it("equals finite differences of the position, and has the axes as angular parts", () => {
    for (const pose of makeRandomPoses(20, arm.joints.length, 4)) {
      const { jacobian } = stateAt(arm, pose);
      const step = 1e-6;
      arm.joints.forEach((joint, i) => {
        const [ahead, behind] = [1, -1].map((side) =>
          stateAt(
            arm,
            pose.map((value, k) => (k === i ? value + side * step : value)),
          ),
        );
        const moved = subtract(ahead!.point, behind!.point);
        moved.forEach((value, row) => expect(jacobian[row]![i]).toBeCloseTo(value / (2 * step), 6));
        const [x0, x1] = [behind!.frames.at(-1)!.x, ahead!.frames.at(-1)!.x];
        const turned = [3, 4, 5].map((row) => jacobian[row]![i]!);
        const rate = subtract(x1, x0).map((value) => value / (2 * step));
        const [wx, wy, wz] = turned as [number, number, number];
        const x = stateAt(arm, pose).frames.at(-1)!.x;
        expect(rate[0]).toBeCloseTo(wy * x[2] - wz * x[1], 6);
        expect(rate[1]).toBeCloseTo(wz * x[0] - wx * x[2], 6);
        expect(joint.kind === "P" ? norm(turned) : norm(turned) - 1).toBeCloseTo(0, 9);
      });
    }
  });

  it("is accompanied by the vectors p* from every origin to the point", () => {
    const state = stateAt(arm, makeRandomPoses(1, arm.joints.length, 2)[0]!);
    pStar(arm, state).forEach((p, i) => expect(norm(subtract(add(state.frames[i]!.o, p), state.point))).toBeCloseTo(0));
  });

  it("is regular in the first pose, which is within the ranges", () => {
    const pose = firstPose(arm);
    pose.forEach((value, i) => expect(limitToRange(arm, i, value)).toBeCloseTo(value, 9));
    expect(measuresOf(arm, stateAt(arm, pose)).ratio).toBeGreaterThan(0.05);
  });
});

describe("determinants", () => {
  it("of the planar 2R arm are a1 a2 sin(theta2)", () => {
    const arm = armOf(PLAIN);
    for (const pose of makeRandomPoses(30, 2, 9)) {
      expect(measuresOf(arm, stateAt(arm, pose)).det).toBeCloseTo(0.5 * 0.4 * Math.sin(pose[1]!), 12);
    }
  });

  it("of the sample arm follow from its table", () => {
    const arm = armOf(ROBOTS["planar-2r"]!);
    const [a1, bend, reach] = [0.47, Math.atan2(0.18, 0.47), Math.hypot(0.47, 0.18)];
    for (const [t1, t2] of makeRandomPoses(10, 2, 3)) {
      const det = measuresOf(arm, stateAt(arm, [t1!, t2!])).det!;
      expect(Math.abs(det)).toBeCloseTo(Math.abs(a1 * reach * Math.sin(t2! + Math.PI + bend)), 9);
    }
  });

  it("are replaced by products of singular values if J is not square", () => {
    const arm = armOf(ROBOTS["planar-3r"]!);
    for (const pose of makeRandomPoses(10, 3, 3)) {
      const { taskJacobian } = stateAt(arm, pose);
      const gram = taskJacobian.map((row) => taskJacobian.map((other) => dot(row, other)));
      const area = Math.sqrt(gram[0]![0]! * gram[1]![1]! - gram[0]![1]! ** 2);
      expect(signedVolume(arm, pose)).toBeCloseTo(area, 10);
      expect(measuresOf(arm, stateAt(arm, pose)).det).toBeNull();
    }
  });
});

describe("singular values", () => {
  it("are known for small matrices", () => {
    expect(
      singularValues([
        [3, 0],
        [0, -2],
      ]),
    ).toEqual([3, 2]);
    const [a, b] = singularValues([
      [1, 1],
      [0, 1],
    ]);
    expect(a).toBeCloseTo((1 + Math.sqrt(5)) / 2, 14);
    expect(b).toBeCloseTo((Math.sqrt(5) - 1) / 2, 14);
    expect(
      singularValues([
        [1, 2],
        [2, 4],
      ])[1],
    ).toBeLessThan(1e-15);
    expect(singularValues([[3, 4, 0]])).toEqual([5]);
  });

  it("belong to vectors that A stretches by them, and to a null space", () => {
    const next = makeRandomNumbers(8);
    const a = Array.from({ length: 3 }, () => Array.from({ length: 5 }, () => next() - 0.5));
    const { sigma, v } = decompose(a);
    v.forEach((vector, k) => {
      expect(norm(multiply(a, vector))).toBeCloseTo(k < 3 ? sigma[k]! : 0, 12);
      v.forEach((other, j) => expect(dot(vector, other)).toBeCloseTo(j === k ? 1 : 0, 12));
    });
    const left = decompose(transpose(a)).sigma;
    left.forEach((value, k) => expect(value).toBeCloseTo(sigma[k]!, 12));
  });

  it("give the shortest least-squares solution", () => {
    expect(leastSquares([[1, 1]], [2])).toEqual([expect.closeTo(1, 12), expect.closeTo(1, 12)]);
    expect(
      leastSquares(
        [
          [2, 0],
          [0, 4],
        ],
        [2, 2],
      ),
    ).toEqual([1, 0.5]);
  });
});

describe("the drawing", () => {
  it("is flat for planar arms", () => {
    const planes = Object.values(ALL).map((robot) => planeNormalOf(armOf(robot)));
    expect(planes).toEqual(["z", "z", null, null, "z", null, null]);
  });

  it("is centred beside the buttons, also on a phone", () => {
    for (const robot of [ROBOTS["scara"]!, ROBOTS["elbow-3r"]!]) {
      const arm = armOf(robot);
      const view = viewOf(arm, extentOf(arm), 362, 286, FIRST_ORBIT);
      const across = makeRandomPoses(200, arm.joints.length, 5).map(
        (pose) =>
          toPixel(
            view,
            stateAt(
              arm,
              pose.map((value, i) => limitToRange(arm, i, value)),
            ).point,
          )[0],
      );
      expect(Math.max(...across)).toBeLessThan(362 - 45);
      expect(Math.min(...across)).toBeGreaterThan(0);
    }
  });

  it("has limits for prismatic joints, and full turns for revolute joints", () => {
    const arm = armOf(ROBOTS["scara"]!);
    expect(limitToRange(arm, 0, 4)).toBeCloseTo(4 - 2 * Math.PI);
    expect(limitToRange(arm, 2, 40)).toBe(rangeOf(arm, 2).high);
  });
});

it.each<[place: [number, number], share: number, distance: number]>([
  [[-3, 4], 0, 5],
  [[5, 2], 0.5, 2],
  [[12, 5], 1.5, 2],
  [[10, 13], 2, 3],
])("the place on a line nearest to %s is at share %d of its corners", (place, share, distance) => {
  const corners = [[0, 0], [10, 0], [10, 10]] as const; // prettier-ignore
  expect(nearestOnLine(corners, place)).toEqual({ share, distance });
  expect(nearestOnLine([[0, 0]], place)).toEqual({ share: 0, distance: Math.hypot(...place) });
});
