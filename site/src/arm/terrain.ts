// The map of det J over two joints in numbers: values on a grid, and the lines and spots where rank is lost.

import { type Kind, kindAt, kindIsSure } from "./classify.js";
import { type Arm, measuresOf, type Pose, reachOf, signedVolume, stateAt } from "./model.js";
import { randomPoses } from "./random.js";
import { rangeOf } from "./ranges.js";
import { type Grid, gridOf, type Spot, type Stretch, stretches, touches, valleys, zeroLines } from "./zeros.js";

export type Shown = "det" | "least";

/** The joints along the map's two axes. */
export type Pair = readonly [across: number, up: number];

/** `most` is the largest size of a value; 0 where rank is lost everywhere, and what is left of values is rounding. */
export interface Terrain {
  readonly grid: Grid;
  readonly most: number;
  readonly lines: readonly (readonly Spot[])[];
  readonly spots: readonly Spot[];
}

const CELLS = 64;
/** Of what det J may be, a share that no arm has but where it has lost rank, by a hair or by rounding. */
const LOST = 1e-6;

/** About the largest det J of an arm below 1 m; its unit is a power of metres, one for each row that is a velocity. */
const sizeOf = (arm: Arm): number => Math.min(1, reachOf(arm)) ** arm.task.filter((row) => row < 3).length;

/** The two joints on which the determinant depends most, in their order. */
export function telling(arm: Arm): Pair {
  const n = arm.joints.length;
  const weight = arm.joints.map((_, i) =>
    randomPoses(6, n, 21).reduce((sum, pose) => {
      const [a, b] = [0.4, -0.4].map((by) => signedVolume(arm, pose.with(i, pose[i]! + by)));
      return sum + Math.abs(a! - b!);
    }, 0),
  );
  const order = arm.joints.map((_, i) => i).sort((a, b) => Math.round(1e6 * (weight[b]! - weight[a]!)) || a - b);
  const [first = 0, second = 0] = order;
  return first < second ? [first, second] : [second, first];
}

/** The pose at a spot of the map, other joints as they are. */
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
  const most = Math.max(...grid.values.flat().map(Math.abs));
  const size = Math.max(...volumes.values.flat().map(Math.abs));
  if (size < LOST * sizeOf(arm)) return { grid, most: 0, lines: [], spots: [] };
  const square = arm.task.length === arm.joints.length;
  const magnitude = (u: number, v: number): number => Math.abs(volume(u, v));
  const crossed = square ? zeroLines(volumes, volume) : [];
  const touched = valleys(volumes, volume, 1e-7 * size).filter((line) => line.length > 3);
  const lines = [...crossed, ...touched];
  const positive = { ...volumes, values: volumes.values.map((row) => row.map(Math.abs)) };
  const spots = touches(positive, magnitude, 1e-7 * size).filter(
    (spot) => inside(spot, ranges) && lines.every((line) => apart(line, spot, grid)),
  );
  return { grid, most, lines, spots };
}

function inside([u, v]: Spot, [[u0, u1], [v0, v1]]: readonly [Spot, Spot]): boolean {
  return u >= u0 && u <= u1 && v >= v0 && v <= v1;
}

function apart(line: readonly Spot[], [u, v]: Spot, { us, vs }: Grid): boolean {
  const [du, dv] = [us[1]! - us[0]!, vs[1]! - vs[0]!];
  return line.every(([a, b]) => Math.abs(a - u) > 1.5 * du || Math.abs(b - v) > 1.5 * dv);
}

/** The kind of the singularity at a spot, unknown where it can't be established. */
export function kindAtSpot(arm: Arm, pose: Pose, pair: Pair, spot: Spot): Kind | "unknown" {
  const kind = kindAt(arm, poseAtSpot(pose, pair, spot), 1e-4);
  return kind === "regular" ? "unknown" : kind;
}

/** Lines and spots before their kinds are known. */
export function unsorted({ lines, spots }: Terrain): Stretch[] {
  return [...lines, ...spots.map((spot) => [spot])].map((spots) => ({ kind: "unknown", spots }));
}

/** Lines cut by kind, and spots. */
export function sorted(arm: Arm, pose: Pose, pair: Pair, terrain: Terrain): Stretch[] {
  if (!kindIsSure(arm)) return unsorted(terrain);
  const kindOf = (spot: Spot): Kind | "unknown" => kindAtSpot(arm, pose, pair, spot);
  return [
    ...terrain.lines.flatMap((line) => stretches(line, Math.max(4, Math.ceil(line.length / 10)), kindOf)),
    ...terrain.spots.map((spot): Stretch => ({ kind: kindOf(spot), spots: [spot] })),
  ];
}
