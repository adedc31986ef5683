// How joints follow a hand: a link that is dragged on the page, or the point of interest that is pulled along.

import { type Arm, placesAt, type Pose, reachOf, signedVolume, type State, stateAt } from "./model.js";
import { poseWithin, rangeOf, within } from "./ranges.js";
import { axesOf, right } from "./svd.js";
import { add, along, cross, dot, norm, subtract, type Vec3 } from "./vector.js";
import { drawn, type Pixel, type View } from "./view.js";

/** The pose after one joint has carried a place on its link along with a step on the page, as far as it can. */
export function linkDragged(arm: Arm, state: State, view: View, joint: number, place: Vec3, step: Pixel): Pose {
  const { z, o } = state.frames[joint]!;
  const moved = arm.joints[joint]!.kind === "R" ? cross(z, subtract(place, o)) : z;
  const [gx, gy] = drawn(view, moved);
  const size = gx * gx + gy * gy;
  const least = (0.05 * view.scale) ** 2; // a link that points at the reader does not fly off
  const change = (gx * step[0] + gy * step[1]) / Math.max(size, least);
  return poseWithin(arm, state.pose.with(joint, state.pose[joint]! + change));
}

/** Steps of one motion: it comes to rest within a few, more where the arm has to turn round for it. */
const STEPS = 40;
/** The furthest that a joint goes in a step (rad or m). */
const FURTHEST = 0.3;
/** What keeps a step short where the point hardly moves with a joint, and the share of the curvature that does. */
const [FIRM, SHARE] = [0.04 ** 2, 0.03];
/** What an arm that stands exactly between two ways is moved by (rad or m), so that it takes one of them. */
const NUDGE = 1e-3;
/** How far from straight an arm stands that is told to be straight (rad or m): nobody sees it. */
const HAIR = 1e-7;

/**
 * The pose in which the point is `step` (m) further, or as near to that as it gets. Out of its reach the arm comes to
 * rest stretched out or folded back, on the side on which it was bent.
 *
 * It goes down D = |p - goal|^2 / 2. Gauss's J^T J alone is no measure of a step where the goal is out of reach: what
 * remains of the error e then weighs on how p curves, the whole of D's second derivatives is J^T J - e . d2p, and
 * without that term a stretched arm oscillates about its stretched pose.
 */
export function pointMoved(arm: Arm, pose: Pose, step: Vec3, seen?: View): Pose {
  const goal = add(stateAt(arm, pose).point, step);
  const missing = (point: Vec3): Vec3 => onPage(subtract(goal, point), seen);
  const reach = reachOf(arm);
  let now = poseWithin(arm, pose);
  for (let k = 0; k < STEPS; k += 1) {
    const state = stateAt(arm, now);
    const error = missing(state.point);
    const away = norm(error);
    if (away < 1e-9) break;
    const next = nearer(arm, now, stepDown(arm, state, error, reach, seen), (point) => {
      return norm(missing(point)) < away;
    });
    if (!next) break;
    const change = Math.max(...next.map((value, i) => Math.abs(value - now[i]!)));
    now = next;
    if (change < 1e-7) break;
  }
  return poseWithin(arm, onItsSide(arm, pose, now));
}

/** Move a nearly singular pose a hair to the side on which the arm was bent, so that it bends to that side again. */
function onItsSide(arm: Arm, before: Pose, now: Pose): Pose {
  const side = sideOf(arm, before);
  if (sideOf(arm, now) === side) return now;
  const still = stillMotion(arm, now, 1e-4);
  if (!still) return now; // it has gone through, and on
  const beside = [HAIR, -HAIR, 100 * HAIR, -100 * HAIR].map((by) => now.map((value, i) => value + by * still[i]!));
  return beside.find((next) => sideOf(arm, next) === side) ?? now;
}

/** Which way an arm is bent: the sign of det J, always the same where J is not square. */
const sideOf = (arm: Arm, pose: Pose): boolean => signedVolume(arm, pose) < 0;

/** The motion (of unit size) that leaves everything where it is, if the pose is as near to singular as that. */
function stillMotion(arm: Arm, pose: Pose, share: number): readonly number[] | null {
  const { counted } = stateAt(arm, pose);
  const { sigma, v } = right(counted);
  return sigma.at(-1)! < share * sigma[0]! ? v.at(-1)! : null;
}

/** The pose after a step or a part of it that brings the point nearer, if possible bent as before; null without one. */
function nearer(arm: Arm, pose: Pose, step: readonly number[], isNearer: (point: Vec3) => boolean): Pose | null {
  const side = sideOf(arm, pose);
  const after = (motion: readonly number[], share: number): Pose =>
    pose.map((value, i) => {
      const moved = value + share * motion[i]!;
      return arm.joints[i]!.kind === "P" ? within(arm, i, moved) : moved; // turns are counted on meanwhile
    });
  const serves = (next: Pose): boolean => isNearer(placesAt(arm, next).point);
  let over: Pose | null = null;
  for (let share = 1; share > (over ? 0.1 : 1e-3); share /= 3) {
    const next = after(step, share);
    if (!serves(next)) continue;
    if (sideOf(arm, next) === side) return next;
    over ??= next;
  }
  const still = over && stillMotion(arm, pose, 0.02);
  if (!still) return over;
  const turned = (motion: readonly number[]): number =>
    (signedVolume(arm, after(motion, 1e-3)) - signedVolume(arm, pose)) / 1e-3;
  const by = (2 * turned(step)) / turned(still); // as far to its own side as the step leads to the other
  if (!(Math.abs(by) < 2)) return over;
  const mirrored = after(
    step.map((value, i) => value - by * still[i]!),
    1,
  );
  return sideOf(arm, mirrored) === side && serves(mirrored) ? mirrored : over;
}

/** Newton's step down |error|^2 / 2 along each axis of its second derivatives, whichever way it is curved there. */
function stepDown(arm: Arm, state: State, error: Vec3, reach: number, seen?: View): number[] {
  const columns = arm.joints.map((_, j): Vec3 => {
    const [x, y, z] = state.jacobian.map((row) => row[j]!) as [number, number, number];
    return [x, y, z];
  });
  const drawn = columns.map((column) => onPage(column, seen));
  const downhill = drawn.map((column) => dot(column, error));
  // A slide at its end stays there while it is pulled on.
  const free = downhill.map((force, i) => {
    const { low, high } = rangeOf(arm, i);
    return arm.joints[i]!.kind === "R" || (force > 0 ? state.pose[i]! < high : state.pose[i]! > low);
  });
  const away = norm(error);
  const curved = columns.map((_, i) =>
    columns.map((__, j) => {
      if (!free[i] || !free[j]) return 0;
      const [first, last] = i < j ? [i, j] : [j, i];
      // d J_last / d q_first: what is further out is turned along.
      const turned = arm.joints[first]!.kind === "R" ? dot(cross(state.frames[first]!.z, columns[last]!), error) : 0;
      return dot(drawn[i]!, drawn[j]!) - turned;
    }),
  );
  const firm = FIRM * Math.min(1, reach) ** 2 + SHARE * away * reach;
  const change = columns.map(() => 0);
  for (const { value, vector } of axesOf(curved)) {
    const slope = vector.reduce((sum, part, i) => sum + (free[i] ? part * downhill[i]! : 0), 0);
    const between = value < -0.01 * away * reach && Math.abs(slope) < NUDGE * Math.abs(value);
    const by = between ? (slope < 0 ? -NUDGE : NUDGE) : slope / (1.05 * Math.abs(value) + firm);
    vector.forEach((part, i) => (change[i] = change[i]! + by * part));
  }
  const most = Math.max(...change.map(Math.abs), 1e-12);
  return change.map((value) => value * Math.min(1, FURTHEST / most));
}

/** What of a vector is seen on the page, where depth does not count. */
const onPage = (v: Vec3, seen?: View): Vec3 => (seen ? along(v, seen.toward, -dot(v, seen.toward)) : v);
