// Where parts of the arm are drawn: the links as polylines in space, and the places of the joints' symbols.

import { type Arm, type Frame, fromFrame, type State } from "./model.js";
import { thicknessOf } from "./ranges.js";
import { add, addScaled, norm, scaleVector, subtract, type Vec3 } from "./vector.js";

/** The corners of link i (from 1): O_{i-1}, O_{i-1} + d_i z_{i-1}, O_i, and P if the link carries it. */
export function linkOf(arm: Arm, state: State, i: number): readonly Vec3[] {
  const points = [state.frames[i - 1]!.o, state.corners[i - 1]!, state.frames[i]!.o];
  if (arm.point.frame === i) points.push(...wayToPoint(state.frames[i]!, arm.point.offset));
  return points.filter((point, k) => k === 0 || norm(subtract(point, points[k - 1]!)) > 1e-9);
}

/** Return the corners of the way from a frame's origin to P, along the frame's axes one after the other. */
export function wayToPoint(frame: Frame, [u, v, w]: Vec3): Vec3[] {
  const steps: Vec3[] = [
    [u, 0, 0],
    [u, v, 0],
    [u, v, w],
  ];
  return steps.map((step) => add(frame.o, fromFrame(frame, step)));
}

/** Return the place of each joint's symbol: O_{i-1}, shifted along the axis if the joint before has the same origin. */
export function jointCentresOf(arm: Arm, state: State, reach: number): readonly Vec3[] {
  let sharedCount = 0;
  return arm.joints.map((joint, i) => {
    const { o, z } = state.frames[i]!;
    const previous = arm.joints[i - 1];
    const isShared =
      previous !== undefined && previous.a === 0 && previous.kind === "R" && previous.otherConstant === 0;
    sharedCount = isShared ? sharedCount + 1 : 0;
    if (!isShared && joint.kind === "R") return o;
    if (joint.kind === "P") {
      const displacement = subtract(state.corners[i]!, o);
      return add(o, scaleVector(displacement, 0.45));
    }
    if (joint.otherConstant !== 0) return addScaled(o, z, 0.45 * joint.otherConstant);
    return addScaled(o, z, 0.13 * reach * (sharedCount % 2 === 1 ? 1 : -1));
  });
}

/** Return both ends of a joint's body along its axis in space; `joint` counts from 0. */
export function bodyOf(arm: Arm, state: State, joint: number, place: Vec3): readonly [low: Vec3, high: Vec3] {
  const { z } = state.frames[joint]!;
  const halfLength = (arm.joints[joint]!.kind === "R" ? 1.25 : 1.9) * thicknessOf(arm);
  return [addScaled(place, z, -halfLength), addScaled(place, z, halfLength)];
}

/** Return the point at a share of a line's corners, as `nearestOnLine` returns it. */
export function pointAtShare(corners: readonly Vec3[], share: number): Vec3 {
  const k = Math.min(Math.floor(share), corners.length - 2);
  const [a, b] = [corners[Math.max(0, k)]!, corners[Math.max(0, k) + 1] ?? corners[Math.max(0, k)]!];
  return addScaled(a, subtract(b, a), share - k);
}
