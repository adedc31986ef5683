// How the joints follow the hand that drags a link on the page, or pulls the point P along.

import { type Arm, pointsAt, type Pose, reachOf, signedVolume, type State, stateAt } from "./model.js";
import { limitPose, rangeOf, limitToRange } from "./ranges.js";
import { axesOf, decompose } from "./svd.js";
import { add, addScaled, cross, dot, norm, subtract, type Vec3 } from "./vector.js";
import { vectorInPixels, type Pixel, type View } from "./view.js";

/** Return the pose after one joint has moved a point on its link by a step on the page (pixels), as far as it can. */
export function dragLink(arm: Arm, state: State, view: View, joint: number, place: Vec3, step: Pixel): Pose {
  const { z, o } = state.frames[joint]!;
  const velocity = arm.joints[joint]!.kind === "R" ? cross(z, subtract(place, o)) : z;
  const [gx, gy] = vectorInPixels(view, velocity);
  const size = gx * gx + gy * gy;
  const minSize = (0.05 * view.scale) ** 2; // a link that points at the reader must not jump
  const change = (gx * step[0] + gy * step[1]) / Math.max(size, minSize);
  return limitPose(arm, state.pose.with(joint, state.pose[joint]! + change));
}

/** Maximum number of steps of one motion: it needs a few, more if the arm must rotate far. */
const MAX_STEPS = 40;
/** Maximum motion of a joint in one step (rad or m). */
const MAX_JOINT_MOTION = 0.3;
/** Regularisation of steps: a constant part, and a share of the curvature that grows with the distance to the goal. */
const [CONSTANT_REGULARISATION, CURVATURE_SHARE] = [0.04 ** 2, 0.03];
/** Motion (rad or m) by which an arm leaves an unstable equilibrium, from which it could go either way. */
const NUDGE = 1e-3;
/** Distance (rad or m) from the singular pose at which an arm stops instead of in it: too small to be seen. */
const SIDE_DISTANCE = 1e-7;

/**
 * Return the pose in which P has moved by `step` (m), or as near to that as possible. With a `view`, only the visible
 * part of the error counts. If the goal is out of reach, the arm comes to rest stretched out or folded back, and keeps
 * the side on which it was bent.
 *
 * The steps descend D = |p - goal|^2 / 2. If the goal is out of reach, Gauss's J^T J alone does not measure a step: the
 * remaining error e weights the curvature of p, so D's second derivatives are J^T J - e . d2p. Without the second term,
 * a stretched arm oscillates about its stretched pose.
 */
export function movePoint(arm: Arm, pose: Pose, step: Vec3, view?: View): Pose {
  const goal = add(stateAt(arm, pose).point, step);
  const errorAt = (point: Vec3): Vec3 => projectToPage(subtract(goal, point), view);
  const reach = reachOf(arm);
  let currentPose = limitPose(arm, pose);
  for (let k = 0; k < MAX_STEPS; k += 1) {
    const state = stateAt(arm, currentPose);
    const error = errorAt(state.point);
    const distance = norm(error);
    if (distance < 1e-9) break;
    const step = newtonStep(arm, state, error, reach, view);
    const next = takeStep(arm, currentPose, step, (point) => norm(errorAt(point)) < distance);
    if (!next) break;
    const change = Math.max(...next.map((value, i) => Math.abs(value - currentPose[i]!)));
    currentPose = next;
    if (change < 1e-7) break;
  }
  return limitPose(arm, keepSide(arm, pose, currentPose));
}

/** Move a nearly singular pose slightly to the side on which the arm was bent, so that it bends to that side again. */
function keepSide(arm: Arm, startPose: Pose, endPose: Pose): Pose {
  const side = hasNegativeSide(arm, startPose);
  if (hasNegativeSide(arm, endPose) === side) return endPose;
  const selfMotion = selfMotionAt(arm, endPose, 1e-4);
  if (!selfMotion) return endPose; // the arm has passed through the singularity
  const posesBeside = [SIDE_DISTANCE, -SIDE_DISTANCE, 100 * SIDE_DISTANCE, -100 * SIDE_DISTANCE].map((size) =>
    endPose.map((value, i) => value + size * selfMotion[i]!),
  );
  return posesBeside.find((next) => hasNegativeSide(arm, next) === side) ?? endPose;
}

/** Return whether det J is negative: its sign says to which side an arm bends. Return false if J is not square. */
const hasNegativeSide = (arm: Arm, pose: Pose): boolean => signedVolume(arm, pose) < 0;

/** Return the unit self-motion, which leaves P in place, if the pose is nearly singular (sigma ratio below `share`). */
function selfMotionAt(arm: Arm, pose: Pose, share: number): readonly number[] | null {
  const { taskJacobian } = stateAt(arm, pose);
  const { sigma, v } = decompose(taskJacobian);
  return sigma.at(-1)! < share * sigma[0]! ? v.at(-1)! : null;
}

/** Return the pose after a step, or part of it, that brings P nearer, preferably bent as before; null if none does. */
function takeStep(arm: Arm, pose: Pose, step: readonly number[], isNearer: (point: Vec3) => boolean): Pose | null {
  const side = hasNegativeSide(arm, pose);
  const poseAfter = (motion: readonly number[], share: number): Pose =>
    pose.map((value, i) => {
      const moved = value + share * motion[i]!;
      return arm.joints[i]!.kind === "P" ? limitToRange(arm, i, moved) : moved; // angles may exceed a turn during the motion
    });
  const isAccepted = (next: Pose): boolean => isNearer(pointsAt(arm, next).point);
  let crossing: Pose | null = null;
  for (let share = 1; share > (crossing ? 0.1 : 1e-3); share /= 3) {
    const next = poseAfter(step, share);
    if (!isAccepted(next)) continue;
    if (hasNegativeSide(arm, next) === side) return next;
    crossing ??= next;
  }
  const selfMotion = crossing && selfMotionAt(arm, pose, 0.02);
  if (!selfMotion) return crossing;
  const volumeRate = (motion: readonly number[]): number =>
    (signedVolume(arm, poseAfter(motion, 1e-3)) - signedVolume(arm, pose)) / 1e-3;
  const size = (2 * volumeRate(step)) / volumeRate(selfMotion); // mirrors the step to the arm's own side
  if (!(Math.abs(size) < 2)) return crossing;
  const mirroredStep = step.map((value, i) => value - size * selfMotion[i]!);
  const mirrored = poseAfter(mirroredStep, 1);
  return hasNegativeSide(arm, mirrored) === side && isAccepted(mirrored) ? mirrored : crossing;
}

/** Return Newton's step that reduces |error|^2 / 2, downhill along each axis of its second derivatives. */
function newtonStep(arm: Arm, state: State, error: Vec3, reach: number, view?: View): number[] {
  const columns = arm.joints.map((_, j) => state.jacobian.map((row) => row[j]!).slice(0, 3) as unknown as Vec3);
  const visibleColumns = columns.map((column) => projectToPage(column, view));
  const downhill = visibleColumns.map((column) => dot(column, error));
  // A prismatic joint at its end stays there while it is pulled outward.
  const isFree = downhill.map((force, i) => {
    const { low, high } = rangeOf(arm, i);
    return arm.joints[i]!.kind === "R" || (force > 0 ? state.pose[i]! < high : state.pose[i]! > low);
  });
  const distance = norm(error);
  const hessian = columns.map((_, i) =>
    columns.map((__, j) => {
      if (!isFree[i] || !isFree[j]) return 0;
      const [innerJoint, outerJoint] = i < j ? [i, j] : [j, i];
      // d J_last / d q_first: the first joint rotates what is further out.
      const curvature =
        arm.joints[innerJoint]!.kind === "R" ? dot(cross(state.frames[innerJoint]!.z, columns[outerJoint]!), error) : 0;
      return dot(visibleColumns[i]!, visibleColumns[j]!) - curvature;
    }),
  );
  const regularisation = CONSTANT_REGULARISATION * Math.min(1, reach) ** 2 + CURVATURE_SHARE * distance * reach;
  const change = columns.map(() => 0);
  for (const { value, vector } of axesOf(hessian)) {
    const slope = vector.reduce((sum, part, i) => sum + (isFree[i] ? part * downhill[i]! : 0), 0);
    const isUnstable = value < -0.01 * distance * reach && Math.abs(slope) < NUDGE * Math.abs(value);
    const size = isUnstable ? (slope < 0 ? -NUDGE : NUDGE) : slope / (1.05 * Math.abs(value) + regularisation);
    vector.forEach((part, i) => (change[i] = change[i]! + size * part));
  }
  const largest = Math.max(...change.map(Math.abs), 1e-12);
  return change.map((value) => value * Math.min(1, MAX_JOINT_MOTION / largest));
}

/** Return the part of a vector that is visible on the page, without its depth; the whole vector without a view. */
const projectToPage = (v: Vec3, view?: View): Vec3 =>
  view ? addScaled(v, view.towardReader, -dot(v, view.towardReader)) : v;
