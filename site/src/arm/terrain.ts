// The map of det J over two joints in numbers: values on a grid, and the lines and spots at which J loses rank.

import { makeRandomPoses } from "../random.js";
import { type SingularityKind, canDecideKind, kindAt } from "./classify.js";
import { type Arm, type Pose, reachOf, signedVolume, stateAt } from "./model.js";
import { rangeOf } from "./ranges.js";
import { singularValues } from "./svd.js";
import type { Grid, Spot, Stretch } from "./zeros.js";
import { cutByKind, gridOf, findZeroMinima, findZeroMinimumLines, findZeroLines } from "./zeros.js";

/** The value that the map shows: det J (or the product of singular values), or the least singular value. */
export type ShownValue = "det" | "least";

/** The joints along the map's two axes. */
export type JointPair = readonly [across: number, up: number];

/**
 * The map in numbers. `max` is the largest absolute value on the grid; 0 if J has lost rank everywhere, so that values
 * are only rounding errors. J loses rank along `lines` and at the isolated `spots`.
 */
export interface Terrain {
  readonly grid: Grid;
  readonly max: number;
  readonly lines: readonly (readonly Spot[])[];
  readonly spots: readonly Spot[];
}

const CELL_COUNT = 64;
/** A smaller share of the possible det J occurs only if rank is lost everywhere on the map, up to rounding. */
const LOST_RANK_SHARE = 1e-6;

/** Return about the largest det J of an arm below 1 m; its unit has a power of metres for each linear row. */
const scaleOfDeterminant = (arm: Arm): number => Math.min(1, reachOf(arm)) ** arm.task.filter((row) => row < 3).length;

/** Return the two joints on which the determinant depends most, in their order. */
export function findMostSensitivePair(arm: Arm): JointPair {
  const n = arm.joints.length;
  const sensitivity = arm.joints.map((_, i) =>
    makeRandomPoses(6, n, 21).reduce((sum, pose) => {
      const [a, b] = [0.4, -0.4].map((change) => signedVolume(arm, pose.with(i, pose[i]! + change)));
      return sum + Math.abs(a! - b!);
    }, 0),
  );
  const order = arm.joints
    .map((_, i) => i)
    .sort((a, b) => Math.round(1e6 * (sensitivity[b]! - sensitivity[a]!)) || a - b);
  const [first = 0, second = 0] = order;
  return first < second ? [first, second] : [second, first];
}

/** Return the pose at a spot of the map; joints that are not on the map keep their values. */
export function poseAtSpot(pose: Pose, [across, up]: JointPair, [u, v]: Spot): Pose {
  return pose.map((value, i) => (i === across ? u : i === up ? v : value));
}

export function terrainOf(arm: Arm, pose: Pose, pair: JointPair, shownValue: ShownValue): Terrain {
  const [across, up] = pair.map((joint) => rangeOf(arm, joint));
  const volumeAt = (u: number, v: number): number => signedVolume(arm, poseAtSpot(pose, pair, [u, v]));
  const minSigmaAt = (u: number, v: number): number =>
    singularValues(stateAt(arm, poseAtSpot(pose, pair, [u, v])).taskJacobian).at(-1) ?? 0;
  const ranges: [Spot, Spot] = [
    [across!.low, across!.high],
    [up!.low, up!.high],
  ];
  const volumes = gridOf(...ranges, CELL_COUNT, volumeAt);
  const grid = shownValue === "det" ? volumes : gridOf(...ranges, CELL_COUNT, minSigmaAt);
  const max = Math.max(...grid.values.flat().map(Math.abs));
  const maxVolume = Math.max(...volumes.values.flat().map(Math.abs));
  if (maxVolume < LOST_RANK_SHARE * scaleOfDeterminant(arm)) return { grid, max: 0, lines: [], spots: [] };
  const isSquare = arm.task.length === arm.joints.length;
  const magnitudeAt = (u: number, v: number): number => Math.abs(volumeAt(u, v));
  const linesOfSignChange = isSquare ? findZeroLines(volumes, volumeAt) : [];
  const linesOfZeroMinima = findZeroMinimumLines(volumes, volumeAt, 1e-7 * maxVolume).filter((line) => line.length > 3);
  const lines = [...linesOfSignChange, ...linesOfZeroMinima];
  const magnitudes = { ...volumes, values: volumes.values.map((row) => row.map(Math.abs)) };
  const spots = findZeroMinima(magnitudes, magnitudeAt, 1e-7 * maxVolume).filter(
    (spot) => isInside(spot, ranges) && lines.every((line) => isFarFrom(line, spot, grid)),
  );
  return { grid, max, lines, spots };
}

function isInside([u, v]: Spot, [[u0, u1], [v0, v1]]: readonly [Spot, Spot]): boolean {
  return u >= u0 && u <= u1 && v >= v0 && v <= v1;
}

function isFarFrom(line: readonly Spot[], [u, v]: Spot, { us, vs }: Grid): boolean {
  const [du, dv] = [us[1]! - us[0]!, vs[1]! - vs[0]!];
  return line.every(([a, b]) => Math.abs(a - u) > 1.5 * du || Math.abs(b - v) > 1.5 * dv);
}

/** Return the lines and spots of a map before their kinds are known. */
export function stretchesWithoutKinds({ lines, spots }: Terrain): Stretch[] {
  return [...lines, ...spots.map((spot) => [spot])].map((spots) => ({ kind: "unknown", spots }));
}

/** Return the lines of a map, cut where the kind changes, and its spots. */
export function stretchesWithKinds(arm: Arm, pose: Pose, pair: JointPair, terrain: Terrain): Stretch[] {
  if (!canDecideKind(arm)) return stretchesWithoutKinds(terrain);
  const kindOf = (spot: Spot): SingularityKind | "unknown" => {
    const kind = kindAt(arm, poseAtSpot(pose, pair, spot), 1e-4);
    return kind === "regular" ? "unknown" : kind;
  };
  return [
    ...terrain.lines.flatMap((line) => cutByKind(line, Math.max(4, Math.ceil(line.length / 10)), kindOf)),
    ...terrain.spots.map((spot): Stretch => ({ kind: kindOf(spot), spots: [spot] })),
  ];
}
