// The orientation of a frame in angles: of its x axis in a planar arm's plane, else yaw, pitch and roll.

import type { Arm, Frame } from "./model.js";
import { dot } from "./vector.js";
import { planeAxesOf } from "./view.js";

/** R = Rz(yaw) Ry(pitch) Rx(roll) (rad). */
export interface RotationAngles {
  readonly yaw: number;
  readonly pitch: number;
  readonly roll: number;
}

/** If cos(pitch) is smaller, yaw and roll rotate about the same axis, and all of it counts as yaw. */
const GIMBAL_LOCK_COSINE = 1e-9;

/** Return the ZYX angles of a frame in the world. */
export function rotationAnglesOf({ x, y, z }: Frame): RotationAngles {
  const cosine = Math.hypot(x[0], x[1]);
  const pitch = Math.atan2(-x[2], cosine);
  if (cosine < GIMBAL_LOCK_COSINE) return { yaw: Math.atan2(-y[0], y[1]), pitch, roll: 0 };
  return { yaw: Math.atan2(x[1], x[0]), pitch, roll: Math.atan2(y[2], z[2]) };
}

/** Return the angle of a frame's x axis in a planar arm's plane, as it is drawn (rad); null for other arms. */
export function angleInPlane(arm: Arm, { x }: Frame): number | null {
  const axes = planeAxesOf(arm);
  return axes && Math.atan2(dot(x, axes.up), dot(x, axes.right));
}
