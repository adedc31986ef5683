// Decide whether an arm can reach points just beyond a boundary candidate: damped Newton steps from many starts.

import { makeRandomPoses } from "../random.js";
import { type Arm, type Frame, type Pose, reachOf, type State, stateAt } from "./model.js";
import { solveDamped } from "./svd.js";
import { add, cross, norm, scaleVector, subtract, type Vec3 } from "./vector.js";

/** Number of starts, and of steps from each; after the early steps, only the nearest starts continue. */
const [START_COUNT, STEP_COUNT] = [60, 40];
const [EARLY_STEP_COUNT, CONTINUED_COUNT] = [8, 15];
/** Damping of a step, and the maximum change of a joint in a step (rad or m). */
const [DAMPING, MAX_JOINT_CHANGE] = [3e-5, 0.6];
/** How far beyond the pose the goal is (share of the reach, or rad). */
const GOAL_DISTANCE = 1e-4;

/** Return the task error from the current state to a goal: position differences (m) and a rotation vector (rad). */
export function taskError(arm: Arm, goal: Pick<State, "point" | "frames">, current: State): number[] {
  const linear = subtract(goal.point, current.point);
  const angular = rotationBetween(current.frames.at(-1)!, goal.frames.at(-1)!);
  const rows = [...linear, ...angular];
  return arm.task.map((row) => rows[row]!);
}

/** The antisymmetric part of the rotation from one frame to another, as a vector: small for small rotations. */
function rotationBetween(start: Frame, end: Frame): Vec3 {
  return scaleVector(add(add(cross(start.x, end.x), cross(start.y, end.y)), cross(start.z, end.z)), 0.5);
}

/** Return whether some configuration reaches slightly beyond a pose in a direction (one number for each task row). */
export function reachesBeyond(arm: Arm, pose: Pose, direction: readonly number[]): boolean {
  const reach = reachOf(arm);
  const goal = stateAt(arm, pose);
  const shift = direction.map((value, k) => GOAL_DISTANCE * value * (arm.task[k]! < 3 ? reach : 1));
  let candidates = makeRandomPoses(START_COUNT, arm.joints.length, 77).map((start) => ({
    pose: start,
    distance: Infinity,
  }));
  for (let step = 0; step < STEP_COUNT; step += 1) {
    for (const candidate of candidates) {
      const current = stateAt(arm, candidate.pose);
      const residual = taskError(arm, goal, current).map((value, k) => value + shift[k]!);
      candidate.distance = norm(residual);
      if (candidate.distance < 1e-6 * reach) return true;
      const changes = solveDamped(current.taskJacobian, residual, DAMPING);
      const share = Math.min(1, MAX_JOINT_CHANGE / Math.max(...changes.map(Math.abs), 1e-12));
      candidate.pose = candidate.pose.map((value, i) => value + share * changes[i]!);
    }
    if (step === EARLY_STEP_COUNT)
      candidates = [...candidates].sort((a, b) => a.distance - b.distance).slice(0, CONTINUED_COUNT);
  }
  return false;
}
