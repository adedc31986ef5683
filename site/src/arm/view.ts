// From metres in the world to pixels on the page: flat for planar arms, else a parallel projection that can be rotated.

import { type Arm, type Joint, stateAt } from "./model.js";
import type { Extent } from "./ranges.js";
import { addScaled, clamp, dot, scaleVector, subtract, type Vec3 } from "./vector.js";

/**
 * A parallel projection: unit vectors right, up and towards the reader; `scale` in pixels per metre; `centre` (m) is
 * drawn in the middle of width x height pixels.
 */
export interface View {
  readonly right: Vec3;
  readonly up: Vec3;
  readonly towardReader: Vec3;
  readonly scale: number;
  readonly centre: Vec3;
  readonly width: number;
  readonly height: number;
}

/** A place or vector on the page in pixels, y down. */
export type Pixel = readonly [x: number, y: number];

/** Directions of the arrow keys on the page. */
export const ARROWS: Readonly<Record<string, Pixel>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** Return how far an arrow key moves a joint (rad or m), or P (m, as a prismatic joint). */
export const keyStep = (kind: Joint["kind"], { shiftKey }: KeyboardEvent): number =>
  (shiftKey ? 10 : 2) * (kind === "R" ? Math.PI / 180 : 0.005);

/** Return whether a key was pressed with a modifier, as a shortcut of the browser. */
export const hasModifier = ({ ctrlKey, metaKey, altKey }: KeyboardEvent): boolean => ctrlKey || metaKey || altKey;

/** The direction from which a spatial arm is looked at: two angles (rad) and a magnification. */
export type Orbit = { readonly azimuth: number; readonly elevation: number; readonly zoom: number };

export const FIRST_ORBIT: Orbit = { azimuth: (36 * Math.PI) / 180, elevation: (24 * Math.PI) / 180, zoom: 1 };

type Axes = Pick<View, "right" | "up" | "towardReader">;

/** The axes of a drawing, by the world axis that points at the reader or, for y, away. */
const AXES_BY_NORMAL: Readonly<Record<AxisName, Axes>> = {
  z: { right: [1, 0, 0], up: [0, 1, 0], towardReader: [0, 0, 1] },
  x: { right: [0, 1, 0], up: [0, 0, 1], towardReader: [1, 0, 0] },
  y: { right: [1, 0, 0], up: [0, 0, 1], towardReader: [0, -1, 0] },
};

/** Return the axes of the page in the plane of a planar arm; null for other arms. */
export function planeAxesOf(arm: Arm): Axes | null {
  const normal = planeNormalOf(arm);
  return normal && AXES_BY_NORMAL[normal];
}

export function axesOfOrbit({ azimuth, elevation }: Orbit): Axes {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], towardReader: [ce * ca, ce * sa, se] };
}

/** Return the world axis perpendicular to all motion of an arm; null without one. See exercises/figure/plane.py. */
export function planeNormalOf(arm: Arm): AxisName | null {
  const knownNormal = PLANE_NORMALS.get(arm);
  const normal = knownNormal === undefined ? findPlaneNormal(arm) : knownNormal;
  PLANE_NORMALS.set(arm, normal);
  return normal;
}

const AXIS_INDEX = { x: 0, y: 1, z: 2 } as const;
type AxisName = keyof typeof AXIS_INDEX;
const PLANE_NORMALS = new WeakMap<Arm, AxisName | null>();

function findPlaneNormal(arm: Arm): AxisName | null {
  const poses = [arm.joints.map((_, i) => 0.37 + 0.21 * i), arm.joints.map((_, i) => 1.13 - 0.47 * i)];
  const states = poses.map((pose) => stateAt(arm, pose));
  if (!arm.joints.some((joint) => joint.kind === "R")) return null;
  for (const name of ["z", "y", "x"] as const) {
    const axis = AXIS_INDEX[name];
    const isPerpendicular = states.every((state) => {
      const height = arm.base.o[axis];
      const isPlanar = [...state.frames.map(({ o }) => o), state.point].every((p) => Math.abs(p[axis] - height) < 1e-9);
      const areAxesAligned = arm.joints.every(
        (joint, i) => Math.abs(Math.abs(state.frames[i]!.z[axis]) - (joint.kind === "R" ? 1 : 0)) < 1e-9,
      );
      return isPlanar && areAxesAligned && (name === "z" || Math.abs(height) < 1e-9);
    });
    if (isPerpendicular) return name;
  }
  return null;
}

/** Width of the buttons at the side of the drawing (pixels). */
const BUTTON_WIDTH = 60;

/** Pixels around a flat arm's reach for the axes of the last frame, at most a share of the drawing's size. */
const [AXES_MARGIN, AXES_MARGIN_SHARE] = [52, 0.14];

/** Return the view of an arm in a box of pixels, in which its whole reach is visible. */
export function viewOf(arm: Arm, extent: Extent, width: number, height: number, orbit: Orbit): View {
  const planeNormal = planeNormalOf(arm);
  const { radius, above, below, up, down, sideways } = extent;
  const { o } = arm.base;
  if (planeNormal) {
    const axes = AXES_BY_NORMAL[planeNormal];
    const reach = Math.max(radius, above, below);
    const horizontalSpan = spanIncludingOrigin(reach, reach, -dot(o, axes.right), 0.12 * reach);
    const verticalSpan = spanIncludingOrigin(reach, reach, -dot(o, axes.up), 0.12 * reach);
    const margin = Math.min(AXES_MARGIN, AXES_MARGIN_SHARE * Math.min(width, height));
    const scale = Math.min(
      (width - 2 * margin) / (horizontalSpan.high - horizontalSpan.low),
      (height - 2 * margin) / (verticalSpan.high - verticalSpan.low),
    );
    const centre = addScaled(addScaled(o, axes.right, middle(horizontalSpan)), axes.up, middle(verticalSpan));
    return { ...axes, scale, centre, width, height };
  }
  const page = axesOfOrbit(FIRST_ORBIT);
  const horizontalSpan = spanIncludingOrigin(sideways, sideways, -dot(o, page.right), 0.2 * sideways);
  const verticalSpan = spanIncludingOrigin(down, up, -dot(o, page.up), 0.2 * sideways);
  const MARGIN_FACTOR = 1.02; // margin for arrows and letters
  const scale =
    Math.min(
      (width - BUTTON_WIDTH) / (MARGIN_FACTOR * (horizontalSpan.high - horizontalSpan.low)),
      height / (MARGIN_FACTOR * (verticalSpan.high - verticalSpan.low)),
    ) * orbit.zoom;
  const upright = addScaled(o, [0, 0, 1], middle(verticalSpan) / Math.cos(FIRST_ORBIT.elevation));
  const axes = axesOfOrbit(orbit);
  const taskScale = (arm.task.every((row) => row > 2) ? 0.7 : 1) * scale;
  const shiftRight = BUTTON_WIDTH / 2 / taskScale; // centres the arm in the space beside the buttons
  return {
    ...axes,
    scale: taskScale,
    centre: addScaled(addScaled(upright, page.right, middle(horizontalSpan)), axes.right, shiftRight),
    width,
    height,
  };
}

type Span = { readonly low: number; readonly high: number };

/** Return the span from `below` to `above` the base (m on the page), extended to the world's origin and its axes. */
function spanIncludingOrigin(below: number, above: number, origin: number, axisLength: number): Span {
  if (Math.abs(origin) < 1e-9) return { low: -below, high: above };
  return { low: Math.min(-below, origin - axisLength), high: Math.max(above, origin + axisLength) };
}

const middle = ({ low, high }: Span): number => (low + high) / 2;

export function toPixel(view: View, p: Vec3): Pixel {
  const [x, y] = vectorInPixels(view, subtract(p, view.centre));
  return [view.width / 2 + x, view.height / 2 + y];
}

/** Return a vector (m) as it is drawn, in pixels with y down. */
export const vectorInPixels = (view: View, v: Vec3): Pixel => [
  view.scale * dot(view.right, v),
  -view.scale * dot(view.up, v),
];

/** Return the vector (m) in the plane of the drawing that is drawn as a step in pixels. */
export function vectorFromPixels(view: View, [dx, dy]: Pixel): Vec3 {
  return addScaled(scaleVector(view.right, dx / view.scale), view.up, -dy / view.scale);
}

/** Return the half axes (pixels) and rotation (degrees, y down) of the drawn ellipsoid {J qdot : |qdot| = 1}. */
export function ellipseOnPage(
  view: View,
  columns: readonly Vec3[],
): Readonly<Record<"major" | "minor" | "rotation", number>> {
  let [xx, xy, yy] = [0, 0, 0];
  for (const column of columns) {
    const [x, y] = vectorInPixels(view, column);
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  const middle = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(middle + spread),
    minor: Math.sqrt(Math.max(0, middle - spread)),
    rotation: (Math.atan2(xy, (xx - yy) / 2) * 90) / Math.PI,
  };
}

/**
 * Return the place on a line that is nearest to another place: as a share of the line's corners (1.5 is halfway from
 * corner 1 to corner 2), and the distance in pixels.
 */
export function nearestOnLine(corners: readonly Pixel[], [x, y]: Pixel): { share: number; distance: number } {
  const [firstX, firstY] = corners[0]!;
  let nearest = { share: 0, distance: Math.hypot(firstX - x, firstY - y) };
  corners.slice(1).forEach(([bx, by], k) => {
    const [ax, ay] = corners[k]!;
    const [dx, dy] = [bx - ax, by - ay];
    const t = clamp(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), 0, 1);
    const distance = Math.hypot(ax + t * dx - x, ay + t * dy - y);
    if (distance < nearest.distance) nearest = { share: k + t, distance };
  });
  return nearest;
}

/** Return places on the page as the text of SVG points. */
export const pointsText = (points: readonly Pixel[], separator = " "): string =>
  points.map((place) => place.map((value) => value.toFixed(2)).join(",")).join(separator);
