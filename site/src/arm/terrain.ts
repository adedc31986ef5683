// The map of det J over two joints in numbers: values on a grid, and the lines and spots at which J loses rank.

import { makeRandomPoses } from "../random.js";
import { type SingularityKind, canDecideKind, kindAt } from "./classify.js";
import { type Arm, measuresOf, type Pose, reachOf, signedVolume, stateAt } from "./model.js";
import { rangeOf } from "./ranges.js";
import { cutByKind, type Grid, gridOf, minima, type Spot, type Stretch, valleys, zeroLines } from "./zeros.js";

export type Shown = "det" | "least";

/** The joints along the map's two axes. */
export type Pair = readonly [across: number, up: number];

/** `max` is the largest absolute value; 0 if J has lost rank everywhere, so that values are only rounding errors. */
export interface Terrain {
  readonly grid: Grid;
  readonly max: number;
  readonly lines: readonly (readonly Spot[])[];
  readonly spots: readonly Spot[];
}

const CELLS = 64;
/** A smaller share of the possible det J occurs only if rank is lost everywhere on the map, up to rounding. */
const LOST = 1e-6;

/** Return about the largest det J of an arm below 1 m; its unit has a power of metres for each linear row. */
const sizeOf = (arm: Arm): number => Math.min(1, reachOf(arm)) ** arm.task.filter((row) => row < 3).length;

/** Return the two joints on which the determinant depends most, in their order. */
export function mostTellingPair(arm: Arm): Pair {
  const n = arm.joints.length;
  const weight = arm.joints.map((_, i) =>
    makeRandomPoses(6, n, 21).reduce((sum, pose) => {
      const [a, b] = [0.4, -0.4].map((change) => signedVolume(arm, pose.with(i, pose[i]! + change)));
      return sum + Math.abs(a! - b!);
    }, 0),
  );
  const order = arm.joints.map((_, i) => i).sort((a, b) => Math.round(1e6 * (weight[b]! - weight[a]!)) || a - b);
  const [first = 0, second = 0] = order;
  return first < second ? [first, second] : [second, first];
}

/** Return the pose at a spot of the map; joints that are not on the map keep their values. */
export function poseAtSpot(pose: Pose, [across, up]: Pair, [u, v]: Spot): Pose {
  return pose.map((value, i) => (i === across ? u : i === up ? v : value));
}

export function terrainOf(arm: Arm, pose: Pose, pair: Pair, shown: Shown): Terrain {
  const [across, up] = pair.map((joint) => rangeOf(arm, joint));
  const volume = (u: number, v: number): number => signedVolume(arm, poseAtSpot(pose, pair, [u, v]));
  const least = (u: number, v: number): number => measuresOf(stateAt(arm, poseAtSpot(pose, pair, [u, v]))).least;
  const ranges: [Spot, Spot] = [
    [across!.low, across!.high],
    [up!.low, up!.high],
  ];
  const volumes = gridOf(...ranges, CELLS, volume);
  const grid = shown === "det" ? volumes : gridOf(...ranges, CELLS, least);
  const max = Math.max(...grid.values.flat().map(Math.abs));
  const size = Math.max(...volumes.values.flat().map(Math.abs));
  if (size < LOST * sizeOf(arm)) return { grid, max: 0, lines: [], spots: [] };
  const square = arm.task.length === arm.joints.length;
  const magnitude = (u: number, v: number): number => Math.abs(volume(u, v));
  const crossed = square ? zeroLines(volumes, volume) : [];
  const touched = valleys(volumes, volume, 1e-7 * size).filter((line) => line.length > 3);
  const lines = [...crossed, ...touched];
  const positive = { ...volumes, values: volumes.values.map((row) => row.map(Math.abs)) };
  const spots = minima(positive, magnitude, 1e-7 * size).filter(
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
export function withoutKinds({ lines, spots }: Terrain): Stretch[] {
  return [...lines, ...spots.map((spot) => [spot])].map((spots) => ({ kind: "unknown", spots }));
}

/** Return the lines of a map, cut where the kind changes, and its spots. */
export function withKinds(arm: Arm, pose: Pose, pair: Pair, terrain: Terrain): Stretch[] {
  if (!canDecideKind(arm)) return withoutKinds(terrain);
  const kindOf = (spot: Spot): SingularityKind | "unknown" => {
    const kind = kindAt(arm, poseAtSpot(pose, pair, spot), 1e-4);
    return kind === "regular" ? "unknown" : kind;
  };
  return [
    ...terrain.lines.flatMap((line) => cutByKind(line, Math.max(4, Math.ceil(line.length / 10)), kindOf)),
    ...terrain.spots.map((spot): Stretch => ({ kind: kindOf(spot), spots: [spot] })),
  ];
}
