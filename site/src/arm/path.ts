// A straight path of the point at a given speed: p(s) = A + s u, the joints that belong to it, and the joint rates.
//
// The joints are found by Newton's method from those of the place before, so that the arm stays on the branch on which
// it began; the rates are qd = J^-1 u speed (6.7), of least norm where the arm has joints to spare. Rows of the task
// that are angular are kept at zero. As ../../../exercises/arm/path.py, for more tasks.

import { taskError } from "./beyond.js";
import { type Arm, measuresOf, type Pose, type State, stateAt } from "./model.js";
import { damped, leastSquares } from "./svd.js";
import { along, norm, subtract, unit, type Vec3 } from "./vector.js";

/** A place on a path: distance s (m), the pose, its change by metre dq/ds, and sigma_min/sigma_max of J. */
export interface Station {
  readonly s: number;
  readonly pose: Pose;
  readonly slopes: readonly number[];
  readonly ratio: number;
}

/** From A, where the point is at the first pose, along the unit vector u for `length` metres. */
export type Path = { readonly start: Vec3; readonly unit: Vec3; readonly length: number };

/** The stations as far as the arm can go, and whether that is the end of the path. */
export type Journey = { readonly path: Path; readonly stations: readonly Station[]; readonly arrives: boolean };

const FLOOR = 2e-3;
const STRIDES = 160;
const ROUGH = 16; // strides of a path that is only looked at
const JUMP = 0.15;
const FINEST = 1 / 64;

/** Why no path can be followed: the task counts no velocity of the point, or has more rows than there are joints. */
export function obstacle(arm: Arm): "turns" | "rows" | null {
  if (arm.task.every((row) => row > 2)) return "turns";
  return arm.task.length > arm.joints.length ? "rows" : null;
}

/** The path to a target; coordinates that the task does not count stay where they are. */
export function pathTo(arm: Arm, pose: Pose, target: Vec3): Path {
  const start = stateAt(arm, pose).point;
  const way = subtract(target, start).map((value, row) => (arm.task.includes(row) ? value : 0)) as unknown as Vec3;
  const length = norm(way);
  return { start, unit: unit(way), length };
}

export const pointOn = (path: Path, s: number): Vec3 => along(path.start, path.unit, s);

/** dq/ds, the joint rates at unit speed. */
export function slopesAt(arm: Arm, path: Path, state: State): number[] {
  return leastSquares(
    state.counted,
    arm.task.map((row) => path.unit[row] ?? 0),
  );
}

/** The pose at s that Newton's method reaches from one near it, or null. */
function poseAt(arm: Arm, path: Path, s: number, near: Pose, first: State): Pose | null {
  const goal = { point: pointOn(path, s), frames: first.frames };
  let pose = near;
  for (let k = 0; k < 12; k += 1) {
    const state = stateAt(arm, pose);
    const error = taskError(arm, goal, state);
    if (Math.max(...error.map(Math.abs)) < 1e-12) return pose;
    const change = damped(state.counted, error, 0);
    pose = pose.map((value, i) => value + change[i]!);
  }
  const error = taskError(arm, goal, stateAt(arm, pose));
  return Math.max(...error.map(Math.abs)) < 1e-9 ? pose : null;
}

function stationAt(arm: Arm, path: Path, s: number, pose: Pose): Station {
  const state = stateAt(arm, pose);
  return { s, pose, slopes: slopesAt(arm, path, state), ratio: measuresOf(state).ratio };
}

/** Follow a path from a pose: strides become shorter where the joints hurry, and end where J is all but singular. */
export function follow(arm: Arm, pose: Pose, path: Path, strides = STRIDES): Journey {
  const first = stateAt(arm, pose);
  const stations = [stationAt(arm, path, 0, pose)];
  if (path.length === 0) return { path, stations, arrives: true };
  const stride = path.length / strides;
  let share = 1;
  for (let now = stations[0]!; now.ratio >= FLOOR && path.length - now.s > 1e-12 && share >= FINEST;) {
    const s = Math.min(path.length, now.s + share * stride);
    const ahead = now.pose.map((value, i) => value + (s - now.s) * now.slopes[i]!);
    const found = poseAt(arm, path, s, ahead, first);
    const jumped = found === null || found.some((value, i) => Math.abs(value - ahead[i]!) > JUMP);
    const next = jumped ? null : stationAt(arm, path, s, found);
    if (next === null || next.ratio < FLOOR) {
      share /= 2;
      continue;
    }
    stations.push(next);
    now = next;
    share = Math.min(1, 2 * share);
  }
  return { path, stations, arrives: path.length - stations.at(-1)!.s <= 1e-9 };
}

/** The place at a distance, between the stations on both sides of it. */
export function stationOn({ stations }: Journey, s: number): Station {
  const after = stations.findIndex((station) => station.s >= s);
  if (after <= 0) return after === 0 ? stations[0]! : stations.at(-1)!;
  const [a, b] = [stations[after - 1]!, stations[after]!];
  const t = (s - a.s) / (b.s - a.s || 1);
  const between = (x: readonly number[], y: readonly number[]): number[] =>
    x.map((value, i) => value + t * (y[i]! - value));
  return {
    s,
    pose: between(a.pose, b.pose),
    slopes: between(a.slopes, b.slopes),
    ratio: a.ratio + t * (b.ratio - a.ratio),
  };
}

/** Where each joint's speed first exceeds its limit (m from A), or null. */
export function crossings(journey: Journey, speed: number, limits: readonly number[]): (number | null)[] {
  return limits.map((limit, i) => {
    const over = journey.stations.findIndex(({ slopes }) => Math.abs(slopes[i]!) * speed > limit);
    if (over < 0) return null;
    if (over === 0) return 0;
    const [a, b] = [journey.stations[over - 1]!, journey.stations[over]!];
    const [low, high] = [Math.abs(a.slopes[i]!) * speed, Math.abs(b.slopes[i]!) * speed];
    return a.s + ((limit - low) / (high - low)) * (b.s - a.s);
  });
}

/** The target of a path that is regular all along, or one that leads to a singularity: the best of a fixed choice. */
export function suggested(arm: Arm, pose: Pose, reach: number, regular: boolean): Vec3 {
  const { point } = stateAt(arm, pose);
  let best: Vec3 = point;
  let most = -Infinity;
  for (const direction of waysOf(arm)) {
    for (const share of regular ? [0.5, 0.35] : [0.9, 0.6, 0.4]) {
      const target = along(point, direction, share * reach);
      const { stations, arrives, path } = follow(arm, pose, pathTo(arm, pose, target), ROUGH);
      const least = Math.min(...stations.map(({ ratio }) => ratio));
      const gone = stations.at(-1)!.s / path.length;
      const score = regular
        ? (arrives ? 1 : 0) + Math.min(least, 0.25)
        : (arrives ? 0.4 : Math.min(gone, 0.8)) - Math.min(1, 4 * least) + (gone < 0.35 ? -1 : 0);
      if (score > most + 1e-9) [best, most] = [target, score];
    }
  }
  return best.map((value) => Math.round(value * 100) / 100) as unknown as Vec3;
}

/** Directions in the coordinates that the task counts. */
function waysOf({ task }: Arm): Vec3[] {
  const steps = task.filter((row) => row < 3).length === 2 ? [-1, -0.5, 0, 0.5, 1] : [-1, 0, 1];
  const [xs, ys, zs] = [0, 1, 2].map((row) => (task.includes(row) ? steps : [0]));
  const all = xs!.flatMap((x) => ys!.flatMap((y) => zs!.map((z): Vec3 => [x, y, z])));
  return all.filter((way) => norm(way) > 0.9).map(unit);
}
