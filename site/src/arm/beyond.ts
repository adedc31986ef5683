// Whether some configuration of an arm reaches a place just beyond where it is: damped Newton from many starts.

import { type Arm, type Frame, type Pose, reachOf, type State, stateAt } from "./model.js";
import { randomPoses } from "./random.js";
import { damped } from "./svd.js";
import { cross, norm, scaled, subtract, type Vec3 } from "./vector.js";

const STARTS = 60;
const STEPS = 40;
const EARLY = 8;
const KEPT = 15;
const BEYOND = 1e-4;

/** What brings the task from a state to a goal, by rows: differences of position, small rotation vectors. */
export function taskError(arm: Arm, goal: Pick<State, "point" | "frames">, now: State): number[] {
  const linear = subtract(goal.point, now.point);
  const turn = rotationBetween(now.frames.at(-1)!, goal.frames.at(-1)!);
  const rows = [...linear, ...turn];
  return arm.task.map((row) => rows[row]!);
}

/** The antisymmetric part of the rotation from one frame to another, as a vector: small for small rotations. */
function rotationBetween(from: Frame, to: Frame): Vec3 {
  const [a, b, c] = [cross(from.x, to.x), cross(from.y, to.y), cross(from.z, to.z)];
  return scaled([a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]], 0.5);
}

/** Whether a configuration reaches what lies beyond a pose in a direction (one number for each row of the task). */
export function beyond(arm: Arm, pose: Pose, direction: readonly number[]): boolean {
  const reach = reachOf(arm);
  const goal = stateAt(arm, pose);
  const shift = direction.map((value, k) => BEYOND * value * (arm.task[k]! < 3 ? reach : 1));
  let tried = randomPoses(STARTS, arm.joints.length, 77).map((q) => ({ q, away: Infinity }));
  for (let step = 0; step < STEPS; step += 1) {
    for (const one of tried) {
      const now = stateAt(arm, one.q);
      const residual = taskError(arm, goal, now).map((value, k) => value + shift[k]!);
      one.away = norm(residual);
      if (one.away < 1e-6 * reach) return true;
      const move = damped(now.counted, residual, 3e-5);
      const most = Math.max(...move.map(Math.abs), 1e-12);
      one.q = one.q.map((value, i) => value + move[i]! * Math.min(1, 0.6 / most));
    }
    if (step === EARLY) tried = [...tried].sort((a, b) => a.away - b.away).slice(0, KEPT);
  }
  return false;
}
