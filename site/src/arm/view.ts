// From metres in the world to pixels on the page: flat for planar arms, a parallel projection that can be turned else.

import { type Arm, stateAt } from "./model.js";
import type { Extent } from "./ranges.js";
import { along, dot, scaled, subtract, type Vec3 } from "./vector.js";

/** Directions right, up and towards the reader; `centre` (m) is drawn in the middle of width x height pixels. */
export interface View {
  readonly right: Vec3;
  readonly up: Vec3;
  readonly toward: Vec3;
  readonly scale: number;
  readonly centre: Vec3;
  readonly width: number;
  readonly height: number;
}

export type Pixel = readonly [x: number, y: number];

/** Where keys lead on the page. */
export const ARROWS: Readonly<Record<string, Pixel>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** Which way a spatial arm is looked at: two angles (rad) and a magnification. */
export type Orbit = { readonly azimuth: number; readonly elevation: number; readonly zoom: number };

export const FIRST_ORBIT: Orbit = { azimuth: (36 * Math.PI) / 180, elevation: (24 * Math.PI) / 180, zoom: 1 };

type Axes = Pick<View, "right" | "up" | "toward">;

const FLAT: Readonly<Record<"x" | "y" | "z", Axes>> = {
  z: { right: [1, 0, 0], up: [0, 1, 0], toward: [0, 0, 1] },
  x: { right: [0, 1, 0], up: [0, 0, 1], toward: [1, 0, 0] },
  y: { right: [1, 0, 0], up: [0, 0, 1], toward: [0, -1, 0] },
};

export function axonometric({ azimuth, elevation }: Orbit): Axes {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], toward: [ce * ca, ce * sa, se] };
}

/** The axis of the world square to all motion of the arm, or null; as ../../../exercises/figure/plane.py has it. */
export function flatPlane(arm: Arm): "x" | "y" | "z" | null {
  const known = PLANES.get(arm);
  if (known !== undefined) return known;
  const found = planeOf(arm);
  PLANES.set(arm, found);
  return found;
}

const AXIS = { x: 0, y: 1, z: 2 } as const;
const PLANES = new WeakMap<Arm, "x" | "y" | "z" | null>();

function planeOf(arm: Arm): "x" | "y" | "z" | null {
  const poses = [arm.joints.map((_, i) => 0.37 + 0.21 * i), arm.joints.map((_, i) => 1.13 - 0.47 * i)];
  const states = poses.map((pose) => stateAt(arm, pose));
  if (!arm.joints.some((joint) => joint.kind === "R")) return null;
  for (const name of ["z", "y", "x"] as const) {
    const axis = AXIS[name];
    const square = states.every((state) => {
      const level = arm.base.o[axis];
      const still = [...state.frames.map(({ o }) => o), state.point].every((p) => Math.abs(p[axis] - level) < 1e-9);
      const turns = arm.joints.every(
        (joint, i) => Math.abs(Math.abs(state.frames[i]!.z[axis]) - (joint.kind === "R" ? 1 : 0)) < 1e-9,
      );
      return still && turns && (name === "z" || Math.abs(level) < 1e-9);
    });
    if (square) return name;
  }
  return null;
}

/** Pixels at the sides that buttons take. */
const BUTTONS = 60;

/** The view of an arm in a box of pixels: what it reaches is seen. */
export function viewOf(arm: Arm, extent: Extent, width: number, height: number, orbit: Orbit): View {
  const plane = flatPlane(arm);
  const { around, above, below, up, down, aside } = extent;
  const { o } = arm.base;
  if (plane) {
    const axes = FLAT[plane];
    const radius = Math.max(around, above, below);
    const across = spanWith(radius, radius, -dot(o, axes.right), 0.12 * radius);
    const high = spanWith(radius, radius, -dot(o, axes.up), 0.12 * radius);
    const scale = 0.9 * Math.min(width / (across.high - across.low), height / (high.high - high.low));
    const centre = along(along(o, axes.right, middle(across)), axes.up, middle(high));
    return { ...axes, scale, centre, width, height };
  }
  const page = axonometric(FIRST_ORBIT);
  const across = spanWith(aside, aside, -dot(o, page.right), 0.2 * aside);
  const high = spanWith(down, up, -dot(o, page.up), 0.2 * aside);
  const room = 1.02; // for arrows and letters
  const scale =
    Math.min((width - BUTTONS) / (room * (across.high - across.low)), height / (room * (high.high - high.low))) *
    orbit.zoom;
  const upright = along(o, [0, 0, 1], middle(high) / Math.cos(FIRST_ORBIT.elevation));
  const axes = axonometric(orbit);
  const shown = (arm.task.every((row) => row > 2) ? 0.7 : 1) * scale;
  const beside = BUTTONS / 2 / shown; // the arm is in the middle of what the buttons leave
  return {
    ...axes,
    scale: shown,
    centre: along(along(upright, page.right, middle(across)), axes.right, beside),
    width,
    height,
  };
}

type Span = { readonly low: number; readonly high: number };

/** From so far below to so far above the base (m on the page), and as far as the world's origin with its axes. */
function spanWith(below: number, above: number, origin: number, axis: number): Span {
  if (Math.abs(origin) < 1e-9) return { low: -below, high: above };
  return { low: Math.min(-below, origin - axis), high: Math.max(above, origin + axis) };
}

const middle = ({ low, high }: Span): number => (low + high) / 2;

export function pixel(view: View, p: Vec3): Pixel {
  const [x, y] = drawn(view, subtract(p, view.centre));
  return [view.width / 2 + x, view.height / 2 + y];
}

/** How a vector (m) is drawn, in pixels with y down. */
export const drawn = (view: View, v: Vec3): Pixel => [view.scale * dot(view.right, v), -view.scale * dot(view.up, v)];

/** The vector (m) in the plane of the drawing that is drawn as a step in pixels. */
export function lifted(view: View, [dx, dy]: Pixel): Vec3 {
  return along(scaled(view.right, dx / view.scale), view.up, -dy / view.scale);
}

/** The outline of the ellipsoid {J q : |q| = 1} as drawn: centre, half axes (pixels) and turn (degrees, y down). */
export function outline(view: View, columns: readonly Vec3[]): Readonly<Record<"major" | "minor" | "turn", number>> {
  let [xx, xy, yy] = [0, 0, 0];
  for (const column of columns) {
    const [x, y] = drawn(view, column);
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  const middle = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: Math.sqrt(middle + spread),
    minor: Math.sqrt(Math.max(0, middle - spread)),
    turn: (Math.atan2(xy, (xx - yy) / 2) * 90) / Math.PI,
  };
}
