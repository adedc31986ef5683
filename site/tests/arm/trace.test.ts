// The trace of P, and the orientation of the last frame.
import { expect, test } from "vitest";

import { armOf, stateAt } from "../../src/arm/model.js";
import { angleInPlane, rotationAnglesOf } from "../../src/arm/orientation.js";
import { extendTrace, NO_TRACE } from "../../src/arm/trace.js";
import { norm, subtract, type Vec3 } from "../../src/arm/vector.js";
import { makeRandomPoses } from "../../src/random.js";
import { PLAIN, ROBOTS, SIX } from "./robots.js";

const plain = armOf(PLAIN);

test("the trace of a move is the arc of P, also across 180°, and continues where P is", () => {
  const [from, to] = [
    [3, 0],
    [-3, 0],
  ] as const;
  const [arc] = extendTrace(NO_TRACE, plain, from, to);
  for (const point of arc!) {
    expect(norm(point)).toBeCloseTo(0.9);
    expect(point[0]).toBeLessThan(-0.88); // the short way, through 180°
  }
  expect(arc![0]).toEqual(stateAt(plain, from).point);
  expect(subtract(arc!.at(-1)!, stateAt(plain, to).point).every((gap) => Math.abs(gap) < 1e-12)).toBe(true);
  const longer = extendTrace([arc!], plain, to, [-3, 1]);
  expect(longer).toHaveLength(1);
  expect(extendTrace(longer, plain, [1, 1], [1, 1.5])).toHaveLength(2); // the arm jumped in between
});

test("a trace forgets its oldest points", () => {
  let trace = NO_TRACE;
  for (let k = 0; k < 40; k += 1) trace = extendTrace(trace, plain, [k, 0.5], [k + 3, 0.5]);
  expect(trace.flat().length).toBeLessThanOrEqual(1500);
  expect(norm(subtract(trace.at(-1)!.at(-1)!, stateAt(plain, [42, 0.5]).point))).toBeLessThan(1e-9);
});

test("yaw, pitch and roll give the last frame's axes, also with the axis vertical", () => {
  const six = armOf(SIX);
  for (const pose of [...makeRandomPoses(20, 6, 4), [0, Math.PI / 2, 0, 0, 0, 0.3], [0.2, 0, -Math.PI / 2, 0, 0, 1]]) {
    const frame = stateAt(six, pose).frames[6]!;
    const { yaw, pitch, roll } = rotationAnglesOf(frame);
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const [cr, sr] = [Math.cos(roll), Math.sin(roll)];
    const axes: Record<"x" | "y" | "z", Vec3> = {
      x: [cy * cp, sy * cp, -sp],
      y: [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
      z: [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
    };
    for (const name of ["x", "y", "z"] as const) expect(norm(subtract(frame[name], axes[name]))).toBeLessThan(1e-9);
  }
});

test("a planar arm has the sum of its joint angles, a spatial arm has no such angle", () => {
  expect(angleInPlane(plain, stateAt(plain, [0.3, -1]).frames[2]!)).toBeCloseTo(-0.7);
  const elbow = armOf(ROBOTS["elbow-3r"]!);
  expect(angleInPlane(elbow, stateAt(elbow, [0.3, 0.4, -1]).frames[3]!)).toBeNull();
});
