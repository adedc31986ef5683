// The direction that an arm loses at a singularity, or is slowest along near one.

import type { Arm, Measures, State } from "./model.js";
import { right } from "./svd.js";
import { norm, transposed, unit, type Vec3 } from "./vector.js";

const LOST = 0.03;

/** The direction along which the line is drawn that P can hardly leave; null where none is drawn. */
export function shownLost(arm: Arm, state: State, { ratio }: Measures, concealed: boolean): Vec3 | null {
  return ratio < LOST && !concealed ? lostDirection(arm, state) : null;
}

/** The direction in space along which the arm is slowest; null where what is slowest is a turn. */
export function lostDirection(arm: Arm, state: State): Vec3 | null {
  if (state.counted.length > arm.joints.length) return null;
  const slowest = right(transposed(state.counted)).v.at(-1);
  if (!slowest) return null;
  const all = [0, 0, 0, 0, 0, 0];
  arm.task.forEach((row, k) => (all[row] = slowest[k]!));
  const linear: Vec3 = [all[0]!, all[1]!, all[2]!];
  return norm(linear) > 0.7 ? unit(linear) : null;
}
