// How joints follow a hand: a link that is dragged on the page, or the point of interest that is pulled along.

import { type Arm, type Pose, type State, stateAt } from "./model.js";
import { poseWithin } from "./ranges.js";
import { leastSquares } from "./svd.js";
import { add, cross, norm, subtract, type Vec3 } from "./vector.js";
import { drawn, type Pixel, type View } from "./view.js";

/** The pose after one joint has carried a place on its link along with a step on the page, as far as it can. */
export function linkDragged(
  arm: Arm,
  state: State,
  view: View,
  joint: number,
  place: Vec3,
  step: Pixel,
): Pose {
  const { z, o } = state.frames[joint]!;
  const moved = arm.joints[joint]!.kind === "R" ? cross(z, subtract(place, o)) : z;
  const [gx, gy] = drawn(view, moved);
  const size = gx * gx + gy * gy;
  const least = (0.05 * view.scale) ** 2; // a link that points at the reader does not fly off
  const change = (gx * step[0] + gy * step[1]) / Math.max(size, least);
  return poseWithin(
    arm,
    state.pose.map((value, i) => (i === joint ? value + change : value)),
  );
}

/** The pose in which the point is `step` (m) further, or as near to that as small motions bring it. */
export function pointMoved(arm: Arm, pose: Pose, step: Vec3, seen?: View): Pose {
  let now = pose;
  const start = stateAt(arm, pose).point;
  const goal = add(start, step);
  for (let k = 0; k < 8; k += 1) {
    const state = stateAt(arm, now);
    const error = subtract(goal, state.point);
    if (norm(error) < 1e-9) break;
    const linear = state.jacobian.slice(0, 3);
    const [rows, wanted] = seen ? onPage(seen, linear, error) : [linear, [...error]];
    const change = leastSquares(rows, wanted, 0.04 * (seen ? seen.scale : 1));
    const most = Math.max(...change.map(Math.abs), 1e-12);
    now = now.map((value, i) => value + change[i]! * Math.min(1, 0.3 / most));
  }
  return poseWithin(arm, now);
}

/** Rows of a Jacobian and an error as they are seen on the page, where depth does not count. */
function onPage(view: View, linear: readonly (readonly number[])[], error: Vec3): [number[][], number[]] {
  const columns = linear[0]!.map((_, j): Vec3 => [linear[0]![j]!, linear[1]![j]!, linear[2]![j]!]);
  const seen = columns.map((column) => drawn(view, column));
  return [[seen.map(([x]) => x), seen.map(([, y]) => y)], [...drawn(view, error)]];
}
