// A straight path of P at constant speed: p(s) = A + s u, with the joint values and joint rates along it.
//
// Newton's method finds the joint values from the previous ones, so the arm stays on its first branch. The rates are
// qd = J^-1 u speed (6.7), of least norm if the arm has redundant joints. Angular rows of the task stay zero. Follows
// ../../../exercises/arm/path.py, for more tasks.

import { taskError } from "./reach.js";
import { type Arm, measuresOf, type Pose, type State, stateAt } from "./model.js";
import { solveDamped, leastSquares } from "./svd.js";
import { addScaled, norm, subtract, unit, type Vec3 } from "./vector.js";

/** A place on a path: distance s (m), pose, derivative dq/ds, and the ratio sigma_min/sigma_max of J. */
interface Station {
  readonly s: number;
  readonly pose: Pose;
  readonly slopes: readonly number[];
  readonly ratio: number;
}

/** A path from A, where P is at the first pose, along the unit vector `unit` for `length` metres. */
export type Path = { readonly start: Vec3; readonly unit: Vec3; readonly length: number };

/** A path with the stations that the arm can reach, and whether it reaches the end. */
export type Journey = { readonly path: Path; readonly stations: readonly Station[]; readonly reachesEnd: boolean };

/** A path ends where sigma_min/sigma_max falls below this limit. */
const MIN_RATIO = 2e-3;
/** Number of strides along a path, and along a path that is only scored. */
const [STRIDE_COUNT, SCORED_STRIDE_COUNT] = [160, 16];
const MAX_NEWTON_STEPS = 12;
/** A joint that deviates more (rad or m) from where its rate leads has jumped to another branch. */
const MAX_DEVIATION = 0.15;
/** Minimum stride, as a share of the usual one. */
const MIN_STRIDE_SHARE = 1 / 64;

/** Return why no path can be followed: the task counts no velocity of P, or has more rows than joints; else null. */
export function whyNoPath(arm: Arm): "turns" | "rows" | null {
  if (arm.task.every((row) => row > 2)) return "turns";
  return arm.task.length > arm.joints.length ? "rows" : null;
}

/** Return the path to a target; coordinates that the task does not count stay constant. */
export function pathTo(arm: Arm, pose: Pose, target: Vec3): Path {
  const start = stateAt(arm, pose).point;
  const way = subtract(target, start).map((value, row) => (arm.task.includes(row) ? value : 0)) as unknown as Vec3;
  const length = norm(way);
  return { start, unit: unit(way), length };
}

export const pointOn = (path: Path, s: number): Vec3 => addScaled(path.start, path.unit, s);

/** Return dq/ds, the joint rates at unit speed. */
function slopesAt(arm: Arm, path: Path, state: State): number[] {
  return leastSquares(
    state.taskJacobian,
    arm.task.map((row) => path.unit[row] ?? 0),
  );
}

/** Return the pose at distance s that Newton's method finds from a nearby pose; null if it finds none. */
function poseAt(arm: Arm, path: Path, s: number, startPose: Pose, firstState: State): Pose | null {
  const goal = { point: pointOn(path, s), frames: firstState.frames };
  let pose = startPose;
  for (let stepsLeft = MAX_NEWTON_STEPS; ; stepsLeft -= 1) {
    const state = stateAt(arm, pose);
    const error = taskError(arm, goal, state);
    const largest = Math.max(...error.map(Math.abs));
    if (largest < 1e-12 || stepsLeft === 0) return largest < 1e-9 ? pose : null;
    const change = solveDamped(state.taskJacobian, error, 0);
    pose = pose.map((value, i) => value + change[i]!);
  }
}

function stationAt(arm: Arm, path: Path, s: number, pose: Pose): Station {
  const state = stateAt(arm, pose);
  return { s, pose, slopes: slopesAt(arm, path, state), ratio: measuresOf(arm, state).ratio };
}

/** Follow a path from a pose. Strides get shorter if the joints move fast, and end if J is nearly singular. */
export function follow(arm: Arm, pose: Pose, path: Path, strideCount = STRIDE_COUNT): Journey {
  const firstState = stateAt(arm, pose);
  const stations = [stationAt(arm, path, 0, pose)];
  if (path.length === 0) return { path, stations, reachesEnd: true };
  const stride = path.length / strideCount;
  let share = 1;
  for (
    let station = stations[0]!;
    station.ratio >= MIN_RATIO && path.length - station.s > 1e-12 && share >= MIN_STRIDE_SHARE;
  ) {
    const s = Math.min(path.length, station.s + share * stride);
    const expectedPose = station.pose.map((value, i) => value + (s - station.s) * station.slopes[i]!);
    const foundPose = poseAt(arm, path, s, expectedPose, firstState);
    const hasJumped =
      foundPose === null || foundPose.some((value, i) => Math.abs(value - expectedPose[i]!) > MAX_DEVIATION);
    const next = hasJumped ? null : stationAt(arm, path, s, foundPose);
    if (next === null || next.ratio < MIN_RATIO) {
      share /= 2;
      continue;
    }
    stations.push(next);
    station = next;
    share = Math.min(1, 2 * share);
  }
  return { path, stations, reachesEnd: path.length - stations.at(-1)!.s <= 1e-9 };
}

/** Return the station at a distance, interpolated between its neighbours. */
export function stationOn({ stations }: Journey, s: number): Station {
  const nextIndex = stations.findIndex((station) => station.s >= s);
  if (nextIndex <= 0) return nextIndex === 0 ? stations[0]! : stations.at(-1)!;
  const [a, b] = [stations[nextIndex - 1]!, stations[nextIndex]!];
  const t = (s - a.s) / (b.s - a.s || 1);
  const interpolate = (x: readonly number[], y: readonly number[]): number[] =>
    x.map((value, i) => value + t * (y[i]! - value));
  return {
    s,
    pose: interpolate(a.pose, b.pose),
    slopes: interpolate(a.slopes, b.slopes),
    ratio: a.ratio + t * (b.ratio - a.ratio),
  };
}

/** Return where each joint's speed first exceeds its limit (m from A); null for a joint that keeps its limit. */
export function limitCrossings(journey: Journey, speed: number, limits: readonly number[]): (number | null)[] {
  return limits.map((limit, i) => {
    const firstIndex = journey.stations.findIndex(({ slopes }) => Math.abs(slopes[i]!) * speed > limit);
    if (firstIndex < 0) return null;
    if (firstIndex === 0) return 0;
    const [a, b] = [journey.stations[firstIndex - 1]!, journey.stations[firstIndex]!];
    const [low, high] = [Math.abs(a.slopes[i]!) * speed, Math.abs(b.slopes[i]!) * speed];
    return a.s + ((limit - low) / (high - low)) * (b.s - a.s);
  });
}

/** Return the best target among fixed candidates: of a regular path, or of one that leads to a singularity. */
export function suggestTarget(arm: Arm, pose: Pose, reach: number, isRegular: boolean): Vec3 {
  const { point } = stateAt(arm, pose);
  let bestTarget: Vec3 = point;
  let maxScore = -Infinity;
  for (const direction of directionsOf(arm)) {
    for (const share of isRegular ? [0.5, 0.35] : [0.9, 0.6, 0.4]) {
      const target = addScaled(point, direction, share * reach);
      const { stations, reachesEnd, path } = follow(arm, pose, pathTo(arm, pose, target), SCORED_STRIDE_COUNT);
      const minRatio = Math.min(...stations.map(({ ratio }) => ratio));
      const coveredShare = stations.at(-1)!.s / path.length;
      const score = isRegular
        ? (reachesEnd ? 1 : 0) + Math.min(minRatio, 0.25)
        : (reachesEnd ? 0.4 : Math.min(coveredShare, 0.8)) - Math.min(1, 4 * minRatio) + (coveredShare < 0.35 ? -1 : 0);
      if (score > maxScore + 1e-9) [bestTarget, maxScore] = [target, score];
    }
  }
  return bestTarget.map((value) => Math.round(value * 100) / 100) as unknown as Vec3;
}

/** Return directions in the coordinates that the task counts. */
function directionsOf({ task }: Arm): Vec3[] {
  const steps = task.filter((row) => row < 3).length === 2 ? [-1, -0.5, 0, 0.5, 1] : [-1, 0, 1];
  const [xs, ys, zs] = [0, 1, 2].map((row) => (task.includes(row) ? steps : [0]));
  const grid = xs!.flatMap((x) => ys!.flatMap((y) => zs!.map((z): Vec3 => [x, y, z])));
  return grid.filter((direction) => norm(direction) > 0.9).map(unit);
}
