// Frame the first pose of an arm more closely than its whole reach, until the arm leaves that frame.

import { type Arm, reachOf, type State } from "./model.js";
import { thicknessOf } from "./ranges.js";
import { bodyOf, placesOf, wayToPoint } from "./shape.js";
import { along, dot, norm, scaled, subtract, type Vec3 } from "./vector.js";
import { axonometric, FIRST_ORBIT, type Orbit, pixel, type View } from "./view.js";

/** What is in the middle of the drawing, and how many times larger it is than where all is seen. */
export type Framing = { readonly centre: Vec3; readonly times: number };

const LARGEST = 1.9;
/** A box that is too small for arrows and letters shows them as far as it can. */
const LEAST = 0.7;
/** Pixels at each side for arrows and letters, and in a flat drawing for arcs and ground; less in a low drawing. */
const [FLAT, SOLID] = [58, 44];
const SHARE = 0.2;
/** Pixels that words and buttons take, above, below and to the right of an arm in space. */
const [WORDS, BUTTONS] = [14, 60];
/** Pixels below the bodies of joints in space for the hint on moving the arm, and for each further line of words. */
const [FOOT, LINE] = [28, 18];
/** As near to the edge (pixels) the arm may come. */
const EDGE = 16;

/** The places of an arm in a pose. */
function places(arm: Arm, state: State): Vec3[] {
  return [
    arm.base.o,
    ...state.frames.map(({ o }) => o),
    ...state.corners,
    ...wayToPoint(state.frames[arm.point.frame]!, arm.point.offset),
  ];
}

/** Whether an arm is drawn flat, and how many lines of words stand at the foot of the drawing. */
type Surroundings = { readonly flat: boolean; readonly lines?: number };

/** The framing of a pose in a view of all, with what else is to be seen: heads of arrows at P, the end of a path. */
export function framingOf(arm: Arm, state: State, besides: readonly Vec3[], view: View, around: Surroundings): Framing {
  const { flat, lines = 1 } = around;
  const seen = [...places(arm, state), ...besides].map((place) => pixel(view, place));
  const bodies = flat ? [] : bodiesOf(arm, state, view);
  const side = Math.min(flat ? FLAT : SOLID, SHARE * view.height);
  const beside = side + Math.min(WORDS, 0.05 * view.height);
  const foot = Math.min(FOOT, 0.1 * view.height) + LINE * (lines - 1);
  const buttons = flat ? 0 : BUTTONS;
  const [xs, ys] = [0, 1].map((k) => seen.map((place) => place[k as 0 | 1]));
  const [wide, high] = [
    spanned(xs!, [side, side + buttons], bodies[0], [EDGE, EDGE + buttons]),
    spanned(ys!, [beside, beside], bodies[1], [EDGE, foot]),
  ];
  const times = Math.max(LEAST, Math.min(LARGEST, wide.fitting(view.width), high.fitting(view.height)));
  const across = (wide.middle(times) - view.width / 2) / view.scale;
  const up = (view.height / 2 - high.middle(times)) / view.scale;
  return { centre: along(along(view.centre, view.right, across), view.up, up), times };
}

type Pair = readonly [low: number, high: number];

interface Spanned {
  /** How many times larger all of it may be drawn in so many pixels. */
  readonly fitting: (room: number) => number;
  /** What is to be in the middle then. */
  readonly middle: (times: number) => number;
}

/** What is to be seen in one direction of the page: places, and bodies if there are any, each with room beside them. */
function spanned(places: readonly number[], room: Pair, bodies: Pair | undefined, roomOfBodies: Pair): Spanned {
  const lows: Pair[] = [[Math.min(...places), room[0]]];
  const highs: Pair[] = [[Math.max(...places), room[1]]];
  if (bodies) {
    lows.push([bodies[0], roomOfBodies[0]]);
    highs.push([bodies[1], roomOfBodies[1]]);
  }
  return {
    fitting: (all) =>
      Math.min(
        ...lows.flatMap(([low, before]) =>
          highs.map(([high, behind]) => (all - before - behind) / Math.max(high - low, 1)),
        ),
      ),
    middle: (times) =>
      (Math.min(...lows.map(([low, before]) => low - before / times)) +
        Math.max(...highs.map(([high, behind]) => high + behind / times))) /
      2,
  };
}

/** From where to where the bodies of joints in space go on the page (pixels), across and down. */
export function bodiesOf(arm: Arm, state: State, view: View): readonly [across: Pair, down: Pair] {
  const radius = thicknessOf(arm) * view.scale;
  const sides = [view.right, view.up].map((axis, k): Pair => {
    const ends = placesOf(arm, state, reachOf(arm)).flatMap((place, i) => {
      const rim = radius * Math.sqrt(Math.max(0, 1 - dot(state.frames[i]!.z, axis) ** 2));
      return bodyOf(arm, state, i, place).flatMap((end) => {
        const at = pixel(view, end)[k as 0 | 1];
        return [at - rim, at + rim];
      });
    });
    return [Math.min(...ends), Math.max(...ends)];
  });
  return [sides[0]!, sides[1]!];
}

/** The vectors from the middle of the ellipse of arrows to where it ends on the page: left, right, above and below. */
export function edgesOf(arrows: readonly Vec3[], { right, up }: View): readonly Vec3[] {
  return [right, up].flatMap((axis) => {
    const far = Math.hypot(...arrows.map((arrow) => dot(arrow, axis)));
    return [scaled(axis, far), scaled(axis, -far)];
  });
}

/** A view of all, nearer by a framing. */
export function framed(view: View, { centre, times }: Framing): View {
  return { ...view, centre, scale: times * view.scale };
}

/** Whether all of an arm is to be seen in a view, and what else is given. */
export function isSeen(arm: Arm, state: State, view: View, besides: readonly Vec3[] = []): boolean {
  return [...places(arm, state), ...besides].every((place) => {
    const [x, y] = pixel(view, place);
    return x > EDGE && x < view.width - EDGE && y > EDGE && y < view.height - EDGE;
  });
}

/** Whether two poses are the same. */
export function isSame(one: readonly number[], other: readonly number[]): boolean {
  return one.length === other.length && dot(one, one) - 2 * dot(one, other) + dot(other, other) < 1e-16;
}

/** Places of an arm that are this far apart (share of its reach) should be this far apart on the page. */
const [DISTANT, APART] = [0.1, 0.25];
/** From so much crowding on an arm is looked at from elsewhere, if that takes away half of it. */
const CROWDED = 0.2;
/** Where it may be looked at from besides (rad): about the vertical from the first view on, and up. */
const ABOUT = [0, 25, -25, 50, -50, 75, -75, 100, -100].map((angle) => (angle * Math.PI) / 180);
const UP = [0, 16].map((angle) => (angle * Math.PI) / 180);

/** How much of an arm is hidden behind itself in a view: 0 nothing, 1 all of it, if it points at the reader. */
export function crowding(arm: Arm, state: State, orbit: Orbit): number {
  const { right, up } = axonometric(orbit);
  const reach = reachOf(arm);
  const all = places(arm, state);
  const pairs = all.flatMap((one, i) => all.slice(i + 1).map((other) => subtract(other, one)));
  const distant = pairs.filter((between) => norm(between) > DISTANT * reach);
  const hidden = distant.map((between) =>
    Math.max(0, 1 - Math.hypot(dot(between, right), dot(between, up)) / (APART * reach)),
  );
  return hidden.reduce((sum, value) => sum + value, 0) / Math.max(1, hidden.length);
}

/** From where an arm is looked at in a pose: from `now`, unless much of it then lies one upon the other. */
export function readableFrom(arm: Arm, state: State, now: Orbit): Orbit {
  const before = crowding(arm, state, now);
  if (before < CROWDED) return now;
  const { azimuth, elevation } = FIRST_ORBIT;
  let best: Orbit = now;
  let least = before / 2;
  for (const higher of UP) {
    for (const about of ABOUT) {
      const orbit = { ...now, azimuth: azimuth + about, elevation: elevation + higher };
      const here = crowding(arm, state, orbit);
      if (here < least - 0.02) [best, least] = [orbit, here]; // as near to the first view as it may be
    }
  }
  return best;
}
