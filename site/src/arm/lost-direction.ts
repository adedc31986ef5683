// The direction in which an arm cannot move at a singularity, or is slowest near one.

import type { Arm, Measures, State } from "./model.js";
import { decompose } from "./svd.js";
import { norm, transpose, unit, type Vec3 } from "./vector.js";

/** The line is drawn if the ratio of the least singular value to the largest is smaller. */
const MAX_LOST_RATIO = 0.03;

/** Return the direction of the dashed line along which P can hardly move; null if no line is drawn. */
export function drawnLostDirection(arm: Arm, state: State, { ratio }: Measures, isConcealed: boolean): Vec3 | null {
  return ratio < MAX_LOST_RATIO && !isConcealed ? lostDirection(arm, state) : null;
}

/** Return the direction in space along which P is slowest; null if the slowest motion is a rotation. */
export function lostDirection(arm: Arm, state: State): Vec3 | null {
  if (state.taskJacobian.length > arm.joints.length) return null;
  const slowest = decompose(transpose(state.taskJacobian)).v.at(-1);
  if (!slowest) return null;
  const velocities = [0, 0, 0, 0, 0, 0];
  arm.task.forEach((row, k) => (velocities[row] = slowest[k]!));
  const linear: Vec3 = [velocities[0]!, velocities[1]!, velocities[2]!];
  return norm(linear) > 0.7 ? unit(linear) : null; // less than half of the squared motion is linear: a rotation
}
