// The arm's body as lines on the page: planar arms flat, as in the textbook's figures; spatial ones until three.js is
// there, or where it can't be.

import type { JSX } from "preact";

import type { Arm, State } from "./model.js";
import { linkOf, placesOf } from "./shape.js";
import { scaled, type Vec3 } from "./vector.js";
import { drawn, pixel, type Pixel, type View } from "./view.js";

export interface BodyProps {
  readonly arm: Arm;
  readonly state: State;
  readonly view: View;
  readonly reach: number;
}

export function Body({ arm, state, view, reach }: BodyProps): JSX.Element {
  const places = placesOf(arm, state, reach);
  return (
    <g class="arm-body">
      <Ground state={state} view={view} />
      {arm.joints.map((joint, i) => {
        const line = inPixels(view, linkOf(arm, state, i + 1));
        return (
          <g key={joint.name}>
            <polyline class="arm-link" points={line} />
            <polyline class="arm-link-inside" points={line} />
          </g>
        );
      })}
      {arm.joints.map((joint, i) => {
        const { z } = state.frames[i]!;
        return joint.kind === "R" ? (
          <Turning key={joint.name} i={i} at={pixel(view, places[i]!)} z={z} view={view} />
        ) : (
          <Sliding key={joint.name} i={i} at={pixel(view, places[i]!)} z={z} view={view} />
        );
      })}
    </g>
  );
}

interface GlyphProps {
  readonly i: number;
  readonly at: Pixel;
  readonly z: Vec3;
  readonly view: View;
}

/** A revolute joint: a dot where its axis comes out of the page, a cross where it goes in. */
function Turning({ i, at: [x, y], z, view }: GlyphProps): JSX.Element {
  const toward = z[0] * view.toward[0] + z[1] * view.toward[1] + z[2] * view.toward[2];
  const r = 5.6;
  return (
    <g class={`arm-joint arm-j${(i % 7) + 1}`}>
      <circle class="arm-joint-face" cx={x} cy={y} r={9.5} />
      {toward > 0.9 && <circle class="arm-joint-dot" cx={x} cy={y} r={2.6} />}
      {toward < -0.9 && (
        <path
          class="arm-joint-cross"
          d={`M${x - r} ${y - r}l${2 * r} ${2 * r}M${x + r} ${y - r}l${-2 * r} ${2 * r}`}
        />
      )}
    </g>
  );
}

/** A prismatic joint: a sleeve along its axis. */
function Sliding({ i, at: [x, y], z, view }: GlyphProps): JSX.Element {
  const [dx, dy] = drawn(view, z);
  const turn = (Math.atan2(dy, dx) * 180) / Math.PI;
  return (
    <g class={`arm-joint arm-j${(i % 7) + 1}`} transform={`translate(${x} ${y}) rotate(${turn})`}>
      <rect class="arm-joint-face" x={-17} y={-9} width={34} height={18} rx={2} />
    </g>
  );
}

/** What carries the base: a hatched line below O_0. */
function Ground({ state, view }: Pick<BodyProps, "state" | "view">): JSX.Element {
  const [x, y] = pixel(view, state.frames[0]!.o);
  const ticks = [-24, -15, -6, 3, 12, 21, 30].map((k) => `M${x + k} ${y + 24}l-8 8`).join("");
  return (
    <g class="arm-ground">
      <path class="arm-pedestal" d={`M${x} ${y}L${x - 13} ${y + 24}h26Z`} />
      <path d={`M${x - 30} ${y + 24}h60${ticks}`} />
    </g>
  );
}

export function inPixels(view: View, points: readonly Vec3[]): string {
  const shown = points.length === 1 ? [points[0]!, points[0]!] : points;
  return shown
    .map((point) =>
      pixel(view, point)
        .map((value) => value.toFixed(1))
        .join(","),
    )
    .join(" ");
}

/** A straight arrow from a point of space along a vector, thin, with a small head; nothing for a vector of no length. */
export function Arrow({
  view,
  from,
  vector,
  style,
  twin = false,
}: {
  readonly view: View;
  readonly from: Vec3;
  readonly vector: Vec3;
  readonly style: string;
  readonly twin?: boolean;
}): JSX.Element | null {
  const [x, y] = pixel(view, from);
  const [dx, dy] = drawn(view, vector);
  const length = Math.hypot(dx, dy);
  if (length < 3) return null;
  const size = Math.min(11, 0.6 * length);
  const [ux, uy] = [dx / length, dy / length];
  const head = (back: number): string => {
    const [tx, ty] = [x + dx - back * ux, y + dy - back * uy];
    const [bx, by] = [tx - size * ux, ty - size * uy];
    return `M${tx} ${ty}L${bx - 0.38 * size * uy} ${by + 0.38 * size * ux}L${bx + 0.38 * size * uy} ${by - 0.38 * size * ux}Z`;
  };
  return (
    <g class={`arm-arrow ${style}`}>
      <path class="arm-shaft" d={`M${x} ${y}L${x + dx - 0.7 * size * ux} ${y + dy - 0.7 * size * uy}`} />
      <path class="arm-head" d={head(0) + (twin ? head(7) : "")} />
    </g>
  );
}

/** A vector of a length in pixels, however the drawing is scaled. */
export function ofPixels(view: View, direction: Vec3, pixels: number): Vec3 {
  return scaled(direction, pixels / view.scale);
}
