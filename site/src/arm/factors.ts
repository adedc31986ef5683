// The factors of det J in numbers: what each is at a pose, and how large it ever gets, against which its bar is drawn.

import type { Factor, Robot } from "../bank.js";
import { read } from "../read/reader.js";
import { realValue } from "../read/real.js";
import { type Arm, namedPose, type Pose, signedVolume } from "./model.js";
import { randomPoses } from "./random.js";
import { rangeOf } from "./ranges.js";

/** A factor: as HTML, its value at a pose, and the largest size of it over the ranges of the joints. */
export type LiveFactor = { readonly html: string; readonly at: (pose: Pose) => number; readonly most: number };

const SAMPLES = 300;

/** What det J is made of, and how large it gets. */
export interface Sizes {
  /** The largest size of det J, or of what stands for it, that the arm gets to. */
  readonly most: number;
  readonly factors: readonly LiveFactor[];
}

/** Search for both over the ranges of the joints, but only when they are needed: on a phone they may never be. */
export function sizesOf(arm: Arm, robot: Robot, factors: readonly Factor[]): () => Sizes {
  let found: Sizes | undefined;
  return () => (found ??= { most: mostVolume(arm), factors: liveFactors(arm, robot, factors) });
}

/** The largest size of det J, or of what stands for it, over the ranges of the joints. */
function mostVolume(arm: Arm): number {
  return Math.max(1e-9, ...samplesOf(arm).map((pose) => Math.abs(signedVolume(arm, pose))));
}

/** Poses all over the ranges of the joints. */
function samplesOf(arm: Arm): Pose[] {
  return randomPoses(SAMPLES, arm.joints.length, 11).map((turns) =>
    turns.map((turn, i) => {
      const { low, high } = rangeOf(arm, i);
      return low + ((turn + Math.PI) / (2 * Math.PI)) * (high - low);
    }),
  );
}

/** The factors of a robot's determinant as functions of the pose; one that can't be parsed is left out. */
function liveFactors(arm: Arm, robot: Robot, factors: readonly Factor[]): LiveFactor[] {
  const known = new Set([...arm.joints.map(({ name }) => name), ...Object.keys(robot.values)]);
  const samples = samplesOf(arm);
  return factors.map(([html, typed]) => {
    const tree = read(typed, known);
    const at = (pose: Pose): number => realValue(tree, { ...robot.values, ...namedPose(arm, pose) });
    return { html, at, most: Math.max(1e-9, ...samples.map((pose) => Math.abs(at(pose)))) };
  });
}
