// Classify singularities as boundary or internal, as in ../../../exercises/singularities/classification.py.
//
// Let u span the directions that J cannot produce (u J = 0) and k the motions that do not move the task (J k = 0). To
// second order the arm moves by u . (dJ/dk k) along u. It is a boundary of the reach if that has one sign for all k and
// no other configuration leads to the far side; else the singularity is internal. Unlimited joint travel is assumed.

import { type Arm, firstJoints, type Pose, reachOf, stateAt } from "./model.js";
import { beyond } from "./beyond.js";
import { evenNumbers, randomPoses } from "./random.js";
import { axesOf, right } from "./svd.js";
import { dot, type Matrix, norm, subtract, transposed } from "./vector.js";

export type Kind = "regular" | "boundary" | "internal";

const REGULAR = 1e-7;
const STEP = 1e-4;
const TURNS = 24;

/** Whether boundary or internal can be established, and means something: the rows are rates of coordinates. */
export function kindIsSure(arm: Arm): boolean {
  const n = arm.joints.length;
  if (n === 6 && arm.task.length === 6) return wristCentre(arm) !== null;
  return arm.task.length <= Math.min(4, n) && hasCoordinates(arm);
}

function hasCoordinates(arm: Arm): boolean {
  const turns = arm.task.filter((row) => row > 2);
  if (turns.length === 0 || turns.length === 3) return true;
  if (turns.length !== 1) return false;
  return randomPoses(3, arm.joints.length, 5).every((pose) => {
    const { jacobian } = stateAt(arm, pose);
    return [3, 4, 5].every((row) => row === turns[0] || norm(jacobian[row]!) < 1e-9);
  });
}

/** The frame whose origin lies on the axes of the last three joints, whatever they do; null without one. */
export function wristCentre(arm: Arm): number | null {
  const n = arm.joints.length;
  const [first, second, third] = arm.joints.slice(-3);
  if (n < 4 || !first || !second || !third) return null;
  if ([first, second, third].some((joint) => joint.kind !== "R")) return null;
  const meet = [first.a, second.a, second.other].every((length) => Math.abs(length) < 1e-12);
  const bent = [first, second].every((joint) => Math.abs(Math.sin(joint.alpha)) > REGULAR);
  return meet && bent ? n - 2 : null;
}

/** The kind of a pose. A hand on a spherical wrist is at the boundary where the wrist's centre is. */
export function kindAt(arm: Arm, pose: Pose, tolerance = REGULAR): Kind {
  const carrying = withoutWrist(arm);
  if (!carrying) return kindOfPlace(arm, pose, tolerance);
  if (rankOf(arm, pose, tolerance) === 6) return "regular";
  const kind = kindOfPlace(carrying, pose.slice(0, 3), tolerance);
  return kind === "regular" ? "internal" : kind;
}

function withoutWrist(arm: Arm): Arm | null {
  if (arm.joints.length !== 6 || arm.task.length !== 6 || wristCentre(arm) === null) return null;
  if ([3, 4].some((i) => Math.abs(Math.cos(arm.joints[i]!.alpha)) > REGULAR)) return null;
  return firstJoints(arm, 3, [0, 0, arm.joints[3]!.other], [0, 1, 2]);
}

function rankIn(matrix: Matrix, sigma: readonly number[], reach: number, tolerance: number): number {
  const least = tolerance * Math.max(sigma[0] ?? 0, Math.min(reach, 1));
  const most = Math.min(matrix.length, matrix[0]?.length ?? 0);
  return Math.min(most, sigma.filter((value) => value > least).length);
}

function rankOf(arm: Arm, pose: Pose, tolerance: number): number {
  const { counted } = stateAt(arm, pose);
  return rankIn(counted, right(counted).sigma, reachOf(arm), tolerance);
}

/** The kind of a place; where a joint can turn without moving the point, of the worst configuration it turns to. */
function kindOfPlace(arm: Arm, pose: Pose, tolerance: number): Kind {
  const kind = kindSeen(arm, pose, tolerance);
  if (kind !== "internal" || arm.task.some((row) => row > 2)) return kind;
  const start = stateAt(arm, pose).point;
  for (let joint = 1; joint < Math.min(arm.joints.length, arm.point.frame); joint += 1) {
    if (arm.joints[joint]!.kind !== "R") continue;
    const turned = Array.from({ length: TURNS }, (_, k) => pose.with(joint, pose[joint]! + (2 * Math.PI * k) / TURNS));
    if (turned.every((other) => norm(subtract(stateAt(arm, other).point, start)) < Math.max(REGULAR, tolerance))) {
      return turned.some((other) => kindSeen(arm, other, tolerance) === "boundary") ? "boundary" : "internal";
    }
  }
  return kind;
}

function kindSeen(arm: Arm, pose: Pose, tolerance: number): Kind {
  const { counted } = stateAt(arm, pose);
  const ahead = right(counted);
  const rank = rankIn(counted, ahead.sigma, reachOf(arm), tolerance);
  if (rank === Math.min(counted.length, arm.joints.length)) return "regular";
  const lost = right(transposed(counted)).v.slice(rank);
  const still = ahead.v.slice(rank);
  if (counted.length > arm.joints.length) return "internal";
  return directions(lost).some((u) => isEdge(arm, pose, u, still)) ? "boundary" : "internal";
}

/** Unit vectors among the lost directions: the only one, or a dozen mixed of several. */
function directions(lost: Matrix): Matrix {
  if (lost.length === 1) return lost;
  const next = evenNumbers(11);
  return Array.from({ length: 12 }, () => {
    const shares = lost.map(() => 2 * next() - 1);
    const mixed = lost[0]!.map((_, i) => lost.reduce((sum, u, k) => sum + shares[k]! * u[i]!, 0));
    return mixed.map((value) => value / norm(mixed));
  });
}

/** Whether no configuration reaches beyond the place, on a side to which small motions do not lead. */
function isEdge(arm: Arm, pose: Pose, lost: readonly number[], still: Matrix): boolean {
  const [forward, backward] = folds(arm, pose, lost, still);
  const [ahead, behind] = [[...lost], lost.map((value) => -value)];
  let sides: number[][] = [];
  if (forward || backward) sides = forward && backward ? [] : forward ? [behind] : [ahead];
  else if (arm.task.every((row) => row < 3) && arm.task.length <= arm.joints.length) sides = [ahead, behind];
  return sides.some((side) => !beyond(arm, pose, side));
}

/** Whether still motions lead, to second order, forward along `lost`, and whether they lead backward. */
function folds(arm: Arm, pose: Pose, lost: readonly number[], still: Matrix): readonly [boolean, boolean] {
  const form = still.map((k) => {
    const [ahead, behind] = [1, -1].map((side) => {
      const { counted } = stateAt(
        arm,
        pose.map((value, i) => value + side * STEP * k[i]!),
      );
      return still.map((other) =>
        dot(
          lost,
          counted.map((row) => dot(row, other)),
        ),
      );
    });
    return ahead!.map((value, j) => (value - behind![j]!) / (2 * STEP));
  });
  const even = form.map((row, i) => row.map((value, j) => (value + form[j]![i]!) / 2));
  const axes = axesOf(even);
  return [axes.some(({ value }) => value > 1e-5), axes.some(({ value }) => value < -1e-5)];
}
