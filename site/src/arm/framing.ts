// Enlarge the first pose of an arm, until the arm leaves the enlarged part of the drawing.

import { type Arm, reachOf, type State } from "./model.js";
import { thicknessOf } from "./ranges.js";
import { bodyOf, jointCentresOf, wayToPoint } from "./shape.js";
import { addScaled, dot, norm, scaleVector, subtract, type Vec3 } from "./vector.js";
import { axesOfOrbit, FIRST_ORBIT, type Orbit, toPixel, vectorInPixels, type View } from "./view.js";

/** The point in the middle of the drawing (m), and how many times larger it is than the view of the whole reach. */
type Framing = { readonly centre: Vec3; readonly zoom: number };

const MAX_ZOOM = 1.9;
/** Minimum zoom: a drawing too small for arrows and letters is reduced to this factor at most. */
const MIN_ZOOM = 0.7;
/** Margin (pixels) for arrows and letters, if flat also for arcs and ground; at most a share of the drawing's height. */
const [FLAT_MARGIN, SOLID_MARGIN, MARGIN_SHARE] = [58, 44, 0.2];
/** Pixels of texts above and below a spatial arm, and of buttons to its right. */
const [TEXT_HEIGHT, BUTTON_WIDTH] = [14, 60];
/** Pixels of the hint below a spatial arm, and of each further line of text. */
const [HINT_HEIGHT, LINE_HEIGHT] = [28, 18];
/** Pixels of the ground below the base of a flat arm. */
const GROUND_HEIGHT = 38;
/** Minimum distance of the arm from the edge (pixels). */
const EDGE_DISTANCE = 16;

/** Return a view that is reduced, to MIN_ZOOM at most, until points are visible in it. */
export function reduceToShow(view: View, points: readonly Vec3[]): View {
  const margin = EDGE_DISTANCE + 1;
  const zooms = points.map((point) => {
    const [x, y] = vectorInPixels(view, subtract(point, view.centre)).map(Math.abs) as [number, number];
    return Math.min((view.width / 2 - margin) / x, (view.height / 2 - margin) / y);
  });
  return { ...view, scale: view.scale * Math.max(MIN_ZOOM, Math.min(1, ...zooms)) };
}

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
type Surroundings = { readonly isFlat: boolean; readonly lineCount?: number };

/** Return the framing that shows the arm at a state, and `extraPoints`; `view` is the view of the whole reach. */
export function framingOf(
  arm: Arm,
  state: State,
  extraPoints: readonly Vec3[],
  view: View,
  surroundings: Surroundings,
): Framing {
  const { isFlat, lineCount = 1 } = surroundings;
  const pointPixels = [...pointsOfArm(arm, state), ...extraPoints].map((place) => toPixel(view, place));
  const [acrossBodies, downBodies] = isFlat ? [] : bodiesOf(arm, state, view);
  const sideMargin = Math.min(isFlat ? FLAT_MARGIN : SOLID_MARGIN, MARGIN_SHARE * view.height);
  const heightMargin = sideMargin + Math.min(TEXT_HEIGHT, 0.05 * view.height);
  const textHeight = Math.min(HINT_HEIGHT, 0.1 * view.height) + LINE_HEIGHT * (lineCount - 1);
  const footMargin = isFlat ? Math.max(heightMargin, GROUND_HEIGHT + textHeight) : heightMargin;
  const buttonWidth = isFlat ? 0 : BUTTON_WIDTH;
  const [xs, ys] = [0, 1].map((k) => pointPixels.map((place) => place[k as 0 | 1]));
  const [horizontalFit, verticalFit] = [
    fitOf(xs!, [sideMargin, sideMargin + buttonWidth], acrossBodies, [EDGE_DISTANCE, EDGE_DISTANCE + buttonWidth]),
    fitOf(ys!, [heightMargin, footMargin], downBodies, [EDGE_DISTANCE, textHeight]),
  ];
  const zoom = Math.max(
    MIN_ZOOM,
    Math.min(MAX_ZOOM, horizontalFit.maxZoom(view.width), verticalFit.maxZoom(view.height)),
  );
  const shiftRight = (horizontalFit.middleAt(zoom) - view.width / 2) / view.scale;
  const shiftUp = (view.height / 2 - verticalFit.middleAt(zoom)) / view.scale;
  return { centre: addScaled(addScaled(view.centre, view.right, shiftRight), view.up, shiftUp), zoom };
}

type Interval = readonly [low: number, high: number];

interface AxisFit {
  /** Return the largest factor by which everything may be enlarged in a number of pixels. */
  readonly maxZoom: (pixelCount: number) => number;
  /** Return what is in the middle at a given enlargement. */
  readonly middleAt: (zoom: number) => number;
}

/** Return how points, and bodies of joints if any, fit in one direction of the page; each has its own margins. */
function fitOf(
  points: readonly number[],
  [lowMargin, highMargin]: Interval,
  bodies: Interval | undefined,
  [lowBodyMargin, highBodyMargin]: Interval,
): AxisFit {
  const lows: (readonly [place: number, margin: number])[] = [[Math.min(...points), lowMargin]];
  const highs: typeof lows = [[Math.max(...points), highMargin]];
  if (bodies) {
    const [lowEnd, highEnd] = bodies;
    lows.push([lowEnd, lowBodyMargin]);
    highs.push([highEnd, highBodyMargin]);
  }
  return {
    maxZoom: (pixelCount) =>
      Math.min(
        ...lows.flatMap(([low, marginBefore]) =>
          highs.map(([high, marginAfter]) => (pixelCount - marginBefore - marginAfter) / Math.max(high - low, 1)),
        ),
      ),
    middleAt: (zoom) =>
      (Math.min(...lows.map(([low, margin]) => low - margin / zoom)) +
        Math.max(...highs.map(([high, margin]) => high + margin / zoom))) /
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
        const centre = toPixel(view, end)[k as 0 | 1];
        return [centre - rim, centre + rim];
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
export function isInView(arm: Arm, state: State, view: View, extraPoints: readonly Vec3[] = []): boolean {
  return [...pointsOfArm(arm, state), ...extraPoints].every((place) => {
    const [x, y] = toPixel(view, place);
    return x > EDGE_DISTANCE && x < view.width - EDGE_DISTANCE && y > EDGE_DISTANCE && y < view.height - EDGE_DISTANCE;
  });
}

/** Return whether two poses are equal. */
export function isSamePose(a: readonly number[], b: readonly number[]): boolean {
  return a.length === b.length && dot(a, a) - 2 * dot(a, b) + dot(b, b) < 1e-16;
}

/** Points at least the first distance apart should be the second distance apart on the page (shares of the reach). */
const [MIN_DISTANCE, MIN_DRAWN_DISTANCE] = [0.1, 0.25];
/** If the crowding is larger, other views are tried; a view is used if it halves the crowding. */
const MAX_CROWDING = 0.2;
/** Alternative views (rad): rotations about the vertical and upward. */
const AZIMUTHS = [0, 25, -25, 50, -50, 75, -75, 100, -100].map((angle) => (angle * Math.PI) / 180);
const ELEVATIONS = [0, 16].map((angle) => (angle * Math.PI) / 180);

/** Return how much of an arm is hidden behind itself in a view: 0 nothing, 1 everything (it points at the reader). */
export function measureCrowding(arm: Arm, state: State, orbit: Orbit): number {
  const { right, up } = axesOfOrbit(orbit);
  const reach = reachOf(arm);
  const points = pointsOfArm(arm, state);
  const differences = points.flatMap((point, i) => points.slice(i + 1).map((other) => subtract(other, point)));
  const farDifferences = differences.filter((difference) => norm(difference) > MIN_DISTANCE * reach);
  const hidden = farDifferences.map((difference) =>
    Math.max(0, 1 - Math.hypot(dot(difference, right), dot(difference, up)) / (MIN_DRAWN_DISTANCE * reach)),
  );
  return hidden.reduce((sum, value) => sum + value, 0) / Math.max(1, hidden.length);
}

/** Return the orbit from which an arm is looked at: the present one, unless another view is much less crowded. */
export function findReadableOrbit(arm: Arm, state: State, orbit: Orbit): Orbit {
  const currentCrowding = measureCrowding(arm, state, orbit);
  if (currentCrowding < MAX_CROWDING) return orbit;
  const { azimuth, elevation } = FIRST_ORBIT;
  let bestOrbit: Orbit = orbit;
  let leastCrowding = currentCrowding / 2;
  for (const elevationChange of ELEVATIONS) {
    for (const azimuthChange of AZIMUTHS) {
      const candidate = { ...orbit, azimuth: azimuth + azimuthChange, elevation: elevation + elevationChange };
      const value = measureCrowding(arm, state, candidate);
      if (value < leastCrowding - 0.02) [bestOrbit, leastCrowding] = [candidate, value]; // prefer views near the first one
    }
  }
  return bestOrbit;
}
