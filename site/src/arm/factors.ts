// The factors of det J in numbers: the value of each at a pose, and its maximum, which scales its bar.

import type { Factor, Robot } from "../bank.js";
import { parse } from "../read/reader.js";
import { evaluateRealTree } from "../read/real.js";
import { type Arm, namedPose, type Pose, signedVolume } from "./model.js";
import { makeRandomPoses } from "../random.js";
import { rangeOf } from "./ranges.js";

/** A factor of det J: its HTML, its value at a pose, and its maximum absolute value over the ranges of the joints. */
type LiveFactor = { readonly html: string; readonly valueAt: (pose: Pose) => number; readonly maxSize: number };

const SAMPLE_COUNT = 300;

/** The maximum of |det J| and the factors of det J. */
export interface DeterminantSizes {
  /** The maximum of |det J|, or of the product of singular values if J is not square. */
  readonly maxDeterminant: number;
  readonly factors: readonly LiveFactor[];
}

/** Return a function that computes these when first called: on a phone they may never be needed. */
export function sizesOf(arm: Arm, robot: Robot, factors: readonly Factor[]): () => DeterminantSizes {
  let sizes: DeterminantSizes | undefined;
  const volumeAt = (pose: Pose): number => Math.abs(signedVolume(arm, pose));
  return () =>
    (sizes ??= {
      maxDeterminant: Math.max(1e-9, ...samplesOf(arm).map(volumeAt)),
      factors: liveFactors(arm, robot, factors),
    });
}

/** Return poses over the whole ranges of the joints. */
function samplesOf(arm: Arm): Pose[] {
  return makeRandomPoses(SAMPLE_COUNT, arm.joints.length, 11).map((values) =>
    values.map((value, i) => {
      const { low, high } = rangeOf(arm, i);
      return low + ((value + Math.PI) / (2 * Math.PI)) * (high - low);
    }),
  );
}

/** Return the factors of a robot's determinant as functions of the pose. */
function liveFactors(arm: Arm, robot: Robot, factors: readonly Factor[]): LiveFactor[] {
  const knownNames = new Set([...arm.joints.map(({ name }) => name), ...Object.keys(robot.values)]);
  const samples = samplesOf(arm);
  return factors.map(([html, typed]) => {
    const tree = parse(typed, knownNames);
    const valueAt = (pose: Pose): number => evaluateRealTree(tree, { ...robot.values, ...namedPose(arm, pose) });
    return { html, valueAt, maxSize: Math.max(1e-9, ...samples.map((pose) => Math.abs(valueAt(pose)))) };
  });
}
