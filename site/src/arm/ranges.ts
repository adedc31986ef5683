// How far the joints of an arm go on the page, and the pose in which it is shown first.

import { type Arm, isMixed, longest, measuresOf, placesAt, type Pose, reachOf, type State, stateAt } from "./model.js";
import { randomPoses } from "./random.js";
import { dot, norm, subtract, type Vec3 } from "./vector.js";
import { axonometric, FIRST_ORBIT, flatPlane } from "./view.js";

export type Range = { readonly low: number; readonly high: number };

/** Travel of a joint: a full turn, or a slide past both ends of what the figures show (unlimited in the chapter). */
export function rangeOf(arm: Arm, index: number): Range {
  const joint = arm.joints[index]!;
  if (joint.kind === "R") return { low: -Math.PI, high: Math.PI };
  const unit = longest(arm);
  const round = (value: number): number => Math.round(value * 20) / 20;
  const most = (flatPlane(arm) ? 2.05 : 1.3) * unit; // figures of planar arms show slides that far out
  const shown = (arm.shown ?? []).map((pose) => pose[index]!);
  return { low: Math.min(round(-unit - joint.offset), ...shown), high: Math.max(round(most - joint.offset), ...shown) };
}

/** The arm with room for poses that are told, should a slide be further out in them than usual. */
export function withRoom(arm: Arm, poses: readonly Pose[]): Arm {
  const shown = poses.filter((pose) => pose.some((value, i) => within(arm, i, value) !== value && isSlide(arm, i)));
  return shown.length > 0 ? { ...arm, shown } : arm;
}

const isSlide = ({ joints }: Arm, index: number): boolean => joints[index]!.kind === "P";

/** A value brought back into a joint's range: round the circle, or to the end of the slide. */
export function within(arm: Arm, index: number, value: number): number {
  const { low, high } = rangeOf(arm, index);
  if (arm.joints[index]!.kind === "P") return Math.min(high, Math.max(low, value));
  if (value >= low && value <= high) return value;
  return value - 2 * Math.PI * Math.round(value / (2 * Math.PI));
}

export const poseWithin = (arm: Arm, pose: Pose): Pose => pose.map((value, i) => within(arm, i, value));

const TURNS = [40, 60, 35, -50, 75, -35, 100, 140, -80, -110];
const SLIDES = [0.7, 0.5, 0.9];
const TRIED = 250;
/** What a pose far from singularities earns. */
const REGULAR = 0.4;

/** The first pose: of a fixed choice, one far from singularities, with the point above the base. */
export function firstPose(arm: Arm): Pose {
  const unit = longest(arm);
  const regular = isMixed(arm) ? 0.1 : 0.4;
  let best: Pose = arm.joints.map(() => 0);
  let most = -Infinity;
  const tried = new Set<string>(); // an arm of two joints has fewer
  for (let k = 0; k < TRIED; k += 1) {
    let digits = (k * 7919) % 1_000_003;
    const pose = arm.joints.map((joint, i) => {
      const choices = joint.kind === "R" ? TURNS : SLIDES;
      const choice = choices[digits % choices.length]!;
      digits = Math.floor(digits / choices.length);
      const entry = joint.kind === "R" ? (choice * Math.PI) / 180 : choice * unit;
      return round(within(arm, i, entry - joint.offset), joint.kind === "R" ? Math.PI / 180 : 0.01);
    });
    const key = pose.join(" ");
    if (tried.has(key)) continue;
    tried.add(key);
    const state = stateAt(arm, pose);
    const place = placeScore(arm, state, unit);
    if (place + REGULAR <= most) continue; // however far from singular it is: singular values take longest
    const score = place + REGULAR * Math.min(measuresOf(state).ratio / regular, 1);
    if (score > most + 1e-9) [best, most] = [pose, score];
  }
  return best;
}

const round = (value: number, step: number): number => Math.round(value / step) * step;

/** How far the arm gets from its base: about, and above and below, along the base's axis (m). */
export interface Extent {
  readonly around: number;
  readonly above: number;
  readonly below: number;
  /** How far it gets up, down and to the sides of the page as it is first seen, the circles of its floor included. */
  readonly up: number;
  readonly down: number;
  readonly aside: number;
}

const EXTENTS = new WeakMap<Arm, Extent>();

/** Half the width of a joint's body in space (m). */
export function thicknessOf(arm: Arm): number {
  const { around, above, below } = extentOf(arm);
  return 0.06 * Math.max(around, 0.6 * above, 0.6 * below);
}

/** The extent of an arm, by poses all over its ranges. */
export function extentOf(arm: Arm): Extent {
  const known = EXTENTS.get(arm);
  if (known) return known;
  const { o, z } = arm.base;
  const page = axonometric(FIRST_ORBIT);
  const slides = flatPlane(arm) ? 1.6 : 1;
  let [around, above, below, up, down, aside] = [0, 0, 0, 0, 0, 0];
  const drawn = randomPoses(300, arm.joints.length, 3).map((turns) =>
    turns.map((value, i) => {
      const { kind, offset } = arm.joints[i]!;
      return kind === "R" ? value : (0.5 + (0.8 * value) / Math.PI) * longest(arm) * slides - offset;
    }),
  );
  for (const pose of [...drawn, ...(arm.shown ?? [])]) {
    const { frames, corners, point } = placesAt(arm, pose);
    for (const place of [...frames.map((frame) => frame.o), ...corners, point]) {
      const away = subtract(place, o);
      const height = dot(away, z);
      around = Math.max(around, Math.sqrt(Math.max(0, dot(away, away) - height * height)));
      up = Math.max(up, dot(away, page.up));
      down = Math.max(down, -dot(away, page.up));
      aside = Math.max(aside, Math.abs(dot(away, page.right)));
      above = Math.max(above, height);
      below = Math.max(below, -height);
    }
  }
  const least = Math.max(around, above, below, longest(arm));
  const floor = (along: Vec3): number => around * Math.sqrt(Math.max(0, 1 - dot(along, z) ** 2));
  const found = {
    around: Math.max(around, 0.3 * least),
    above: Math.max(above, 0.3 * least),
    below,
    up: Math.max(up, floor(page.up), 0.15 * least),
    down: Math.max(down, floor(page.up), 0.15 * least),
    aside: Math.max(aside, floor(page.right), 0.3 * least),
  };
  EXTENTS.set(arm, found);
  return found;
}

/** What a pose earns by where the point is, and by what of the arm is below its base. */
function placeScore(arm: Arm, state: State, unit: number): number {
  const up = flatPlane(arm) === "z" ? 1 : 2;
  const heights = [...state.frames.map(({ o }) => o[up]!), state.point[up]!].map((z) => z - arm.base.o[up]!);
  const low = Math.min(0, ...heights) / unit;
  const away = norm(subtract(state.point, arm.base.o)) / reachOf(arm);
  return 0.4 * away + 0.35 * Math.max(low, -1) + 0.1 * Math.min(1, heights.at(-1)! / unit);
}
