// Enlarge the first pose of an arm, until the arm leaves the enlarged part of the drawing.

import { type Arm, reachOf, type State } from "./model.js";
import { thicknessOf } from "./ranges.js";
import { bodyOf, jointCentresOf, wayToPoint } from "./shape.js";
import { addScaled, dot, norm, scaleVector, subtract, type Vec3 } from "./vector.js";
import { axonometric, FIRST_ORBIT, type Orbit, pixel, type View } from "./view.js";

/** The centre of the drawing, and how many times larger it is than the view of the whole reach. */
export type Framing = { readonly centre: Vec3; readonly zoom: number };

const MAX_ZOOM = 1.9;
/** A small drawing without room for arrows and letters is enlarged at least by this factor. */
const MIN_ZOOM = 0.7;
/** Margin in pixels for arrows and letters, in a flat drawing also for arcs and ground; at most a share of the height. */
const [FLAT_MARGIN, SOLID_MARGIN, MARGIN_SHARE] = [58, 44, 0.2];
/** Pixels of texts above and below a spatial arm, and of buttons to its right. */
const [TEXT_HEIGHT, BUTTON_WIDTH] = [14, 60];
/** Pixels of the hint below a spatial arm, and of each further line of text. */
const [HINT_HEIGHT, LINE_HEIGHT] = [28, 18];
/** Minimum distance of the arm from the edge (pixels). */
const EDGE = 16;

/** Return the points of an arm at a state: base, frames, corners of links, and the way to P. */
function pointsOfArm(arm: Arm, state: State): Vec3[] {
  return [
    arm.base.o,
    ...state.frames.map(({ o }) => o),
    ...state.corners,
    ...wayToPoint(state.frames[arm.point.frame]!, arm.point.offset),
  ];
}

/** Whether an arm is drawn flat, and how many lines of text stand at the foot of the drawing. */
type Surroundings = { readonly flat: boolean; readonly lines?: number };

/** Return the framing that shows the arm at a state and the points `extraPoints`, starting from the view of the reach. */
export function framingOf(
  arm: Arm,
  state: State,
  extraPoints: readonly Vec3[],
  view: View,
  surroundings: Surroundings,
): Framing {
  const { flat, lines = 1 } = surroundings;
  const pixels = [...pointsOfArm(arm, state), ...extraPoints].map((place) => pixel(view, place));
  const bodies = flat ? [] : bodiesOf(arm, state, view);
  const side = Math.min(flat ? FLAT_MARGIN : SOLID_MARGIN, MARGIN_SHARE * view.height);
  const beside = side + Math.min(TEXT_HEIGHT, 0.05 * view.height);
  const foot = Math.min(HINT_HEIGHT, 0.1 * view.height) + LINE_HEIGHT * (lines - 1);
  const buttons = flat ? 0 : BUTTON_WIDTH;
  const [xs, ys] = [0, 1].map((k) => pixels.map((place) => place[k as 0 | 1]));
  const [wide, high] = [
    fitOf(xs!, [side, side + buttons], bodies[0], [EDGE, EDGE + buttons]),
    fitOf(ys!, [beside, beside], bodies[1], [EDGE, foot]),
  ];
  const zoom = Math.max(MIN_ZOOM, Math.min(MAX_ZOOM, wide.fitting(view.width), high.fitting(view.height)));
  const across = (wide.middle(zoom) - view.width / 2) / view.scale;
  const up = (view.height / 2 - high.middle(zoom)) / view.scale;
  return { centre: addScaled(addScaled(view.centre, view.right, across), view.up, up), zoom };
}

type Interval = readonly [low: number, high: number];

interface Fit {
  /** Return the largest factor by which everything may be enlarged in a number of pixels. */
  readonly fitting: (room: number) => number;
  /** Return what is in the middle at a given enlargement. */
  readonly middle: (times: number) => number;
}

/** Return how points, and bodies of joints if any, fit in one direction of the page; each has its own margins. */
function fitOf(points: readonly number[], margin: Interval, bodies: Interval | undefined, bodyMargin: Interval): Fit {
  const lows: Interval[] = [[Math.min(...points), margin[0]]];
  const highs: Interval[] = [[Math.max(...points), margin[1]]];
  if (bodies) {
    lows.push([bodies[0], bodyMargin[0]]);
    highs.push([bodies[1], bodyMargin[1]]);
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

/** Return the extent of the bodies of joints on the page (pixels), across and down. */
export function bodiesOf(arm: Arm, state: State, view: View): readonly [across: Interval, down: Interval] {
  const radius = thicknessOf(arm) * view.scale;
  const sides = [view.right, view.up].map((axis, k): Interval => {
    const ends = jointCentresOf(arm, state, reachOf(arm)).flatMap((place, i) => {
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

/** Return the vectors from the centre of the drawn ellipse to its extreme points: left, right, above and below. */
export function edgesOf(arrows: readonly Vec3[], { right, up }: View): readonly Vec3[] {
  return [right, up].flatMap((axis) => {
    const halfWidth = Math.hypot(...arrows.map((arrow) => dot(arrow, axis)));
    return [scaleVector(axis, halfWidth), scaleVector(axis, -halfWidth)];
  });
}

/** Return a view enlarged by a framing. */
export function withFraming(view: View, { centre, zoom }: Framing): View {
  return { ...view, centre, scale: zoom * view.scale };
}

/** Return whether the whole arm and the points `extraPoints` are visible in a view. */
export function isSeen(arm: Arm, state: State, view: View, extraPoints: readonly Vec3[] = []): boolean {
  return [...pointsOfArm(arm, state), ...extraPoints].every((place) => {
    const [x, y] = pixel(view, place);
    return x > EDGE && x < view.width - EDGE && y > EDGE && y < view.height - EDGE;
  });
}

/** Return whether two poses are equal. */
export function isSamePose(one: readonly number[], other: readonly number[]): boolean {
  return one.length === other.length && dot(one, one) - 2 * dot(one, other) + dot(other, other) < 1e-16;
}

/** Points that are this far apart (share of the reach) should be this far apart on the page. */
const [DISTANT, APART] = [0.1, 0.25];
/** From this crowding on, another view is tried; it must halve the crowding. */
const CROWDED = 0.2;
/** Alternative views (rad): rotations about the vertical and upward. */
const AZIMUTHS = [0, 25, -25, 50, -50, 75, -75, 100, -100].map((angle) => (angle * Math.PI) / 180);
const ELEVATIONS = [0, 16].map((angle) => (angle * Math.PI) / 180);

/** Return how much of an arm is hidden behind itself in a view: 0 nothing, 1 everything (it points at the reader). */
export function crowding(arm: Arm, state: State, orbit: Orbit): number {
  const { right, up } = axonometric(orbit);
  const reach = reachOf(arm);
  const points = pointsOfArm(arm, state);
  const pairs = points.flatMap((point, i) => points.slice(i + 1).map((other) => subtract(other, point)));
  const distant = pairs.filter((between) => norm(between) > DISTANT * reach);
  const hidden = distant.map((between) =>
    Math.max(0, 1 - Math.hypot(dot(between, right), dot(between, up)) / (APART * reach)),
  );
  return hidden.reduce((sum, value) => sum + value, 0) / Math.max(1, hidden.length);
}

/** Return the orbit from which an arm is looked at: `now`, unless another view is much less crowded. */
export function readableFrom(arm: Arm, state: State, now: Orbit): Orbit {
  const before = crowding(arm, state, now);
  if (before < CROWDED) return now;
  const { azimuth, elevation } = FIRST_ORBIT;
  let best: Orbit = now;
  let least = before / 2;
  for (const higher of ELEVATIONS) {
    for (const about of AZIMUTHS) {
      const orbit = { ...now, azimuth: azimuth + about, elevation: elevation + higher };
      const value = crowding(arm, state, orbit);
      if (value < least - 0.02) [best, least] = [orbit, value]; // prefer views near the first one
    }
  }
  return best;
}
