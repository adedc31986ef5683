// Classify singularities as boundary or internal, as in ../../../exercises/singularities/classification.py.
//
// Let u span the directions that J cannot produce (u J = 0) and k the motions that do not move the task (J k = 0). To
// second order, the arm moves by u . (dJ/dk k) along u. The pose is at the boundary of the reach if this has one sign
// for all k and no other configuration reaches the far side; else the singularity is internal. Joints are unlimited.

import { type Arm, type Joint, type Pose, reachOf, stateAt } from "./model.js";
import { reachesBeyond } from "./reach.js";
import { makeRandomNumbers, makeRandomPoses } from "../random.js";
import { axesOf, decompose } from "./svd.js";
import { dot, type Matrix, norm, scaleVector, subtract, multiply, transpose } from "./vector.js";

export type SingularityKind = "regular" | "boundary" | "internal";

/** Tolerance for the rank of J; step of numeric derivatives (rad, or share of the reach); and rotations in a turn. */
const [RANK_TOLERANCE, DIFFERENCE_STEP, ROTATION_COUNT] = [1e-7, 1e-4, 24];

/** Return whether the kind of a singularity can be decided for an arm and its task. */
export function canDecideKind(arm: Arm): boolean {
  const n = arm.joints.length;
  if (n === 6 && arm.task.length === 6) return wristCentre(arm) !== null;
  return arm.task.length <= Math.min(4, n) && hasCoordinates(arm);
}

/** Return whether the task's rows are rates of coordinates: an angular row alone must be the only rotation axis. */
function hasCoordinates(arm: Arm): boolean {
  const angularRows = arm.task.filter((row) => row > 2);
  if (angularRows.length === 0 || angularRows.length === 3) return true;
  if (angularRows.length !== 1) return false;
  return makeRandomPoses(3, arm.joints.length, 5).every((pose) => {
    const { jacobian } = stateAt(arm, pose);
    return [3, 4, 5].every((row) => row === angularRows[0] || norm(jacobian[row]!) < 1e-9);
  });
}

/** Return the index of the frame at the wrist centre, on the axes of the last three joints; null without one. */
function wristCentre(arm: Arm): number | null {
  const n = arm.joints.length;
  const [first, second, third] = arm.joints.slice(-3);
  if (n < 4 || !first || !second || !third) return null;
  if ([first, second, third].some((joint) => joint.kind !== "R")) return null;
  const axesMeet = [first.a, second.a, second.otherConstant].every((length) => Math.abs(length) < 1e-12);
  const axesDiffer = [first, second].every((joint) => Math.abs(Math.sin(joint.alpha)) > RANK_TOLERANCE);
  return axesMeet && axesDiffer ? n - 2 : null;
}

/** Return an arm and a pose with lengths in units of the arm's reach, so that tolerances fit arms of any size. */
function scaleToReach(arm: Arm, pose: Pose): [Arm, Pose] {
  const scale = 1 / reachOf(arm);
  const joints = arm.joints.map((joint): Joint => {
    const length = joint.kind === "R" ? "otherConstant" : "offset"; // d, or the constant in it
    return { ...joint, [length]: scale * joint[length], a: scale * joint.a };
  });
  const base = { ...arm.base, o: scaleVector(arm.base.o, scale) };
  const point = { ...arm.point, offset: scaleVector(arm.point.offset, scale) };
  const scaledPose = pose.map((value, i) => (joints[i]!.kind === "P" ? scale * value : value));
  return [{ ...arm, joints, base, point }, scaledPose];
}

/** Return the kind of a pose. An arm with a spherical wrist is at its boundary if the wrist centre is at its own. */
export function kindAt(armInMetres: Arm, poseInMetres: Pose, tolerance = RANK_TOLERANCE): SingularityKind {
  const [arm, pose] = scaleToReach(armInMetres, poseInMetres);
  const positioner = withoutWrist(arm);
  if (!positioner) return kindForWorstRotation(arm, pose, tolerance);
  if (rankOf(arm, pose, tolerance) === 6) return "regular";
  const kind = kindForWorstRotation(positioner, pose.slice(0, 3), tolerance);
  return kind === "regular" ? "internal" : kind;
}

/** Return the first three joints of a six-joint arm with a spherical wrist, for its wrist centre; else null. */
function withoutWrist(arm: Arm): Arm | null {
  if (arm.joints.length !== 6 || arm.task.length !== 6 || wristCentre(arm) === null) return null;
  if ([3, 4].some((i) => Math.abs(Math.cos(arm.joints[i]!.alpha)) > RANK_TOLERANCE)) return null;
  const wristPoint = { frame: 3, offset: [0, 0, arm.joints[3]!.otherConstant] as const };
  return { ...arm, joints: arm.joints.slice(0, 3), point: wristPoint, task: [0, 1, 2] };
}

function countRank(matrix: Matrix, sigma: readonly number[], tolerance: number): number {
  const minSize = tolerance * Math.max(sigma[0] ?? 0, 1);
  const fullRank = Math.min(matrix.length, matrix[0]?.length ?? 0);
  return Math.min(fullRank, sigma.filter((value) => value > minSize).length);
}

function rankOf(arm: Arm, pose: Pose, tolerance: number): number {
  const { taskJacobian } = stateAt(arm, pose);
  return countRank(taskJacobian, decompose(taskJacobian).sigma, tolerance);
}

/** Return the kind of a pose. If a joint can rotate without moving P, it is "boundary" if it is for some rotation. */
function kindForWorstRotation(arm: Arm, pose: Pose, tolerance: number): SingularityKind {
  const kind = kindFromJacobian(arm, pose, tolerance);
  if (kind !== "internal" || arm.task.some((row) => row > 2)) return kind;
  const startPoint = stateAt(arm, pose).point;
  for (let joint = 1; joint < Math.min(arm.joints.length, arm.point.frame); joint += 1) {
    if (arm.joints[joint]!.kind !== "R") continue;
    const rotatedPoses = Array.from({ length: ROTATION_COUNT }, (_, k) =>
      pose.with(joint, pose[joint]! + (2 * Math.PI * k) / ROTATION_COUNT),
    );
    if (
      rotatedPoses.every(
        (rotatedPose) =>
          norm(subtract(stateAt(arm, rotatedPose).point, startPoint)) < Math.max(RANK_TOLERANCE, tolerance),
      )
    ) {
      return rotatedPoses.some((other) => kindFromJacobian(arm, other, tolerance) === "boundary")
        ? "boundary"
        : "internal";
    }
  }
  return kind;
}

function kindFromJacobian(arm: Arm, pose: Pose, tolerance: number): SingularityKind {
  const { taskJacobian } = stateAt(arm, pose);
  const decomposition = decompose(taskJacobian);
  const rank = countRank(taskJacobian, decomposition.sigma, tolerance);
  if (rank === Math.min(taskJacobian.length, arm.joints.length)) return "regular";
  const lostDirections = decompose(transpose(taskJacobian)).v.slice(rank);
  const selfMotions = decomposition.v.slice(rank);
  if (taskJacobian.length > arm.joints.length) return "internal";
  return sampleDirections(lostDirections).some((u) => isEdge(arm, pose, u, selfMotions)) ? "boundary" : "internal";
}

/** Return unit vectors among the lost directions: the only one, or twelve random combinations of several. */
function sampleDirections(lostDirections: Matrix): Matrix {
  if (lostDirections.length === 1) return lostDirections;
  const nextRandom = makeRandomNumbers(11);
  return Array.from({ length: 12 }, () => {
    const shares = lostDirections.map(() => 2 * nextRandom() - 1);
    const mixed = lostDirections[0]!.map((_, i) => lostDirections.reduce((sum, u, k) => sum + shares[k]! * u[i]!, 0));
    return mixed.map((value) => value / norm(mixed));
  });
}

/** Return whether the reach ends, along the lost direction, on a side to which small motions do not lead. */
function isEdge(arm: Arm, pose: Pose, lostDirection: readonly number[], selfMotions: Matrix): boolean {
  const [leadsForward, leadsBackward] = secondOrderMotion(arm, pose, lostDirection, selfMotions);
  const [aheadDirection, behindDirection] = [[...lostDirection], lostDirection.map((value) => -value)];
  let candidateSides: number[][] = [];
  if (leadsForward || leadsBackward)
    candidateSides = leadsForward && leadsBackward ? [] : leadsForward ? [behindDirection] : [aheadDirection];
  else if (arm.task.every((row) => row < 3) && arm.task.length <= arm.joints.length)
    candidateSides = [aheadDirection, behindDirection];
  return candidateSides.some((side) => !reachesBeyond(arm, pose, side));
}

/** Return whether self-motions lead, to second order, forward along the lost direction, and whether backward. */
function secondOrderMotion(
  arm: Arm,
  pose: Pose,
  lostDirection: readonly number[],
  selfMotions: Matrix,
): readonly [boolean, boolean] {
  const lostRatesAfter = (k: readonly number[], step: number): number[] => {
    const movedPose = pose.map((value, i) => value + step * k[i]!);
    const { taskJacobian } = stateAt(arm, movedPose);
    return selfMotions.map((other) => dot(lostDirection, multiply(taskJacobian, other)));
  };
  const secondDerivatives = selfMotions.map((k) => {
    const [ahead, behind] = [lostRatesAfter(k, DIFFERENCE_STEP), lostRatesAfter(k, -DIFFERENCE_STEP)];
    return ahead.map((value, j) => (value - behind[j]!) / (2 * DIFFERENCE_STEP));
  });
  const symmetric = secondDerivatives.map((row, i) => row.map((value, j) => (value + secondDerivatives[j]![i]!) / 2));
  const principalAxes = axesOf(symmetric);
  return [principalAxes.some(({ value }) => value > 1e-5), principalAxes.some(({ value }) => value < -1e-5)];
}
