// Decide whether an arm can reach points just beyond a boundary candidate: damped Newton steps from many starts.

import { makeRandomPoses } from "../random.js";
import { type Arm, type Frame, type Pose, reachOf, type State, stateAt } from "./model.js";
import { solveDamped } from "./svd.js";
import { cross, norm, scaleVector, subtract, type Vec3 } from "./vector.js";

/** Number of starts, and of steps from each; after `EARLY_STEPS`, only the `NEAREST` starts continue. */
const [START_COUNT, STEP_COUNT] = [60, 40];
const [EARLY_STEPS, CONTINUED_COUNT] = [8, 15];
/** How far beyond the pose the goal is (share of the reach, or rad). */
const GOAL_DISTANCE = 1e-4;

/** Return the task error from the current state to a goal: position differences (m) and a rotation vector (rad). */
export function taskError(arm: Arm, goal: Pick<State, "point" | "frames">, current: State): number[] {
  const linear = subtract(goal.point, current.point);
  const turn = rotationBetween(current.frames.at(-1)!, goal.frames.at(-1)!);
  const rows = [...linear, ...turn];
  return arm.task.map((row) => rows[row]!);
}

/** The antisymmetric part of the rotation from one frame to another, as a vector: small for small rotations. */
function rotationBetween(from: Frame, to: Frame): Vec3 {
  const [a, b, c] = [cross(from.x, to.x), cross(from.y, to.y), cross(from.z, to.z)];
  return scaleVector([a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]], 0.5);
}

/** Return whether some configuration reaches slightly beyond a pose in a direction (one number for each task row). */
export function reachesBeyond(arm: Arm, pose: Pose, direction: readonly number[]): boolean {
  const reach = reachOf(arm);
  const goal = stateAt(arm, pose);
  const shift = direction.map((value, k) => GOAL_DISTANCE * value * (arm.task[k]! < 3 ? reach : 1));
  let candidates = makeRandomPoses(START_COUNT, arm.joints.length, 77).map((q) => ({ q, distance: Infinity }));
  for (let step = 0; step < STEP_COUNT; step += 1) {
    for (const candidate of candidates) {
      const current = stateAt(arm, candidate.q);
      const residual = taskError(arm, goal, current).map((value, k) => value + shift[k]!);
      candidate.distance = norm(residual);
      if (candidate.distance < 1e-6 * reach) return true;
      const move = solveDamped(current.taskJacobian, residual, 3e-5);
      const largestMove = Math.max(...move.map(Math.abs), 1e-12);
      candidate.q = candidate.q.map((value, i) => value + move[i]! * Math.min(1, 0.6 / largestMove));
    }
    if (step === EARLY_STEPS)
      candidates = [...candidates].sort((a, b) => a.distance - b.distance).slice(0, CONTINUED_COUNT);
  }
  return false;
}
