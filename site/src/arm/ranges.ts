// The ranges of an arm's joints on the page, its extent, and the pose in which it is shown first.

import type { Arm, Pose, State } from "./model.js";
import { isMixed, longestPartOf, measuresOf, pointsAt, reachOf, stateAt } from "./model.js";
import { makeRandomPoses } from "../random.js";
import { clamp, dot, norm, subtract, type Vec3 } from "./vector.js";
import { axesOfOrbit, FIRST_ORBIT, planeNormalOf } from "./view.js";

type Range = { readonly low: number; readonly high: number };

/** Return the range of a joint: a full turn; for a prismatic joint, more than figures show (the chapter: no limit). */
export function rangeOf(arm: Arm, index: number): Range {
  const joint = arm.joints[index]!;
  if (joint.kind === "R") return { low: -Math.PI, high: Math.PI };
  const longestPart = longestPartOf(arm);
  const round = (value: number): number => Math.round(value * 20) / 20;
  const maxLength = (planeNormalOf(arm) ? 2.05 : 1.3) * longestPart; // figures of planar arms show prismatic joints that far out
  const shownValues = (arm.shownPoses ?? []).map((pose) => pose[index]!);
  return {
    low: Math.min(round(-longestPart - joint.offset), ...shownValues),
    high: Math.max(round(maxLength - joint.offset), ...shownValues),
  };
}

/** Return the arm with wider ranges of prismatic joints, if some of the poses that must be shown need them. */
export function widenRanges(arm: Arm, poses: readonly Pose[]): Arm {
  const exceedsRange = (pose: Pose): boolean =>
    pose.some((value, i) => arm.joints[i]!.kind === "P" && limitToRange(arm, i, value) !== value);
  const shownPoses = poses.filter(exceedsRange);
  return shownPoses.length > 0 ? { ...arm, shownPoses } : arm;
}

/** Return a value within a joint's range: modulo a turn, or limited to the ends of a prismatic joint. */
export function limitToRange(arm: Arm, index: number, value: number): number {
  const { low, high } = rangeOf(arm, index);
  if (arm.joints[index]!.kind === "P") return clamp(value, low, high);
  if (value >= low && value <= high) return value;
  return value - 2 * Math.PI * Math.round(value / (2 * Math.PI));
}

export const limitPose = (arm: Arm, pose: Pose): Pose => pose.map((value, i) => limitToRange(arm, i, value));

/** Candidate values (degrees) of revolute joints, and of prismatic joints (shares of the longest part). */
const CANDIDATE_ANGLES = [40, 60, 35, -50, 75, -35, 100, 140, -80, -110];
const CANDIDATE_DISPLACEMENTS = [0.7, 0.5, 0.9];
const CANDIDATE_COUNT = 250;
/** Maximum score for the distance from singularities. */
const REGULAR_SCORE = 0.4;

/** Return the first pose: among fixed candidates, one far from singularities, with P above the base. */
export function firstPose(arm: Arm): Pose {
  const longestPart = longestPartOf(arm);
  const regularRatio = isMixed(arm) ? 0.1 : 0.4;
  let bestPose: Pose = arm.joints.map(() => 0);
  let bestScore = -Infinity;
  const seenPoses = new Set<string>(); // an arm with few joints has fewer poses
  for (let k = 0; k < CANDIDATE_COUNT; k += 1) {
    let digits = (k * 7919) % 1_000_003;
    const pose = arm.joints.map((joint, i) => {
      const choices = joint.kind === "R" ? CANDIDATE_ANGLES : CANDIDATE_DISPLACEMENTS;
      const choice = choices[digits % choices.length]!;
      digits = Math.floor(digits / choices.length);
      const entry = joint.kind === "R" ? (choice * Math.PI) / 180 : choice * longestPart;
      return round(limitToRange(arm, i, entry - joint.offset), joint.kind === "R" ? Math.PI / 180 : 0.01);
    });
    const key = pose.join(" ");
    if (seenPoses.has(key)) continue;
    seenPoses.add(key);
    const state = stateAt(arm, pose);
    const scoreOfPlace = placeScore(arm, state, longestPart);
    if (scoreOfPlace + REGULAR_SCORE <= bestScore) continue; // can't become the best pose; singular values take longest to compute
    const score = scoreOfPlace + REGULAR_SCORE * Math.min(measuresOf(arm, state).ratio / regularRatio, 1);
    if (score > bestScore + 1e-9) [bestPose, bestScore] = [pose, score];
  }
  return bestPose;
}

const round = (value: number, step: number): number => Math.round(value / step) * step;

/** The extent of an arm from its base (m): from the base's axis, and above and below along it. */
export interface Extent {
  readonly radius: number;
  readonly above: number;
  readonly below: number;
  /** The extent on the page in the first view: up, down and to the sides, including the circles of the ground. */
  readonly up: number;
  readonly down: number;
  readonly sideways: number;
}

const EXTENTS = new WeakMap<Arm, Extent>();

/** Return half the width of a joint's body in space (m). */
export function thicknessOf(arm: Arm): number {
  const { radius, above, below } = extentOf(arm);
  return 0.06 * Math.max(radius, 0.6 * above, 0.6 * below);
}

/** Return the extent of an arm, sampled over the ranges of its joints. */
export function extentOf(arm: Arm): Extent {
  const cachedExtent = EXTENTS.get(arm);
  if (cachedExtent) return cachedExtent;
  const { o, z } = arm.base;
  const page = axesOfOrbit(FIRST_ORBIT);
  const prismaticScale = planeNormalOf(arm) ? 1.6 : 1;
  let [radius, above, below, up, down, sideways] = [0, 0, 0, 0, 0, 0];
  const sampledPoses = makeRandomPoses(300, arm.joints.length, 3).map((values) =>
    values.map((value, i) => {
      const { kind, offset } = arm.joints[i]!;
      return kind === "R" ? value : (0.5 + (0.8 * value) / Math.PI) * longestPartOf(arm) * prismaticScale - offset;
    }),
  );
  for (const pose of [...sampledPoses, ...(arm.shownPoses ?? [])]) {
    const { frames, corners, point } = pointsAt(arm, pose);
    for (const place of [...frames.map((frame) => frame.o), ...corners, point]) {
      const fromBase = subtract(place, o);
      const height = dot(fromBase, z);
      radius = Math.max(radius, Math.sqrt(Math.max(0, dot(fromBase, fromBase) - height * height)));
      up = Math.max(up, dot(fromBase, page.up));
      down = Math.max(down, -dot(fromBase, page.up));
      sideways = Math.max(sideways, Math.abs(dot(fromBase, page.right)));
      above = Math.max(above, height);
      below = Math.max(below, -height);
    }
  }
  const largest = Math.max(radius, above, below, longestPartOf(arm));
  const extentOfFloor = (axis: Vec3): number => radius * Math.sqrt(Math.max(0, 1 - dot(axis, z) ** 2));
  const extent = {
    radius: Math.max(radius, 0.3 * largest),
    above: Math.max(above, 0.3 * largest),
    below,
    up: Math.max(up, extentOfFloor(page.up), 0.15 * largest),
    down: Math.max(down, extentOfFloor(page.up), 0.15 * largest),
    sideways: Math.max(sideways, extentOfFloor(page.right), 0.3 * largest),
  };
  EXTENTS.set(arm, extent);
  return extent;
}

/** Return the score of a pose by the place of P, and by how far the arm reaches below its base. */
function placeScore(arm: Arm, state: State, longestPart: number): number {
  const up = planeNormalOf(arm) === "z" ? 1 : 2;
  const heights = [...state.frames.map(({ o }) => o[up]!), state.point[up]!].map((z) => z - arm.base.o[up]!);
  const lowest = Math.min(0, ...heights) / longestPart;
  const distance = norm(subtract(state.point, arm.base.o)) / reachOf(arm);
  return 0.4 * distance + 0.35 * Math.max(lowest, -1) + 0.1 * Math.min(1, heights.at(-1)! / longestPart);
}
