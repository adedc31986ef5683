// Draw the arm's body as lines: planar arms as in the textbook, spatial arms without WebGL or until three.js is loaded.

import type { JSX } from "preact";

import type { WantedLabel } from "./labels.js";
import type { Arm, State } from "./model.js";
import { linkOf, jointCentresOf } from "./shape.js";
import { add, dot, scaleVector, type Vec3 } from "./vector.js";
import { vectorInPixels, toPixel, type Pixel, pointsText, type View } from "./view.js";
import { jointClass } from "./letters.js";

export type BodyProps = { readonly arm: Arm; readonly state: State; readonly view: View; readonly reach: number };

export function Body({ arm, state, view, reach }: BodyProps): JSX.Element {
  const jointCentres = jointCentresOf(arm, state, reach);
  return (
    <g class="arm-body">
      <Ground state={state} view={view} />
      {arm.joints.map((joint, i) => {
        const line = polylineText(view, linkOf(arm, state, i + 1));
        return (
          <g key={joint.name}>
            <polyline class="arm-link" points={line} />
            <polyline class="arm-link-inside" points={line} />
          </g>
        );
      })}
      {arm.joints.map((joint, i) => {
        const Glyph = joint.kind === "R" ? RevoluteGlyph : PrismaticGlyph;
        const place = toPixel(view, jointCentres[i]!);
        return <Glyph key={joint.name} i={i} place={place} z={state.frames[i]!.z} view={view} />;
      })}
    </g>
  );
}

type GlyphProps = { readonly i: number; readonly place: Pixel; readonly z: Vec3; readonly view: View };

/** A revolute joint: a dot where its axis comes out of the page, a cross where it goes in. */
function RevoluteGlyph({ i, place: [x, y], z, view }: GlyphProps): JSX.Element {
  const towardReader = dot(z, view.towardReader);
  const halfCross = 5.6;
  return (
    <g class={`arm-joint ${jointClass(i)}`}>
      <circle class="arm-joint-face" cx={x} cy={y} r={9.5} />
      {towardReader > 0.9 && <circle class="arm-joint-dot" cx={x} cy={y} r={2.6} />}
      {towardReader < -0.9 && (
        <path
          class="arm-joint-cross"
          d={`M${x - halfCross} ${y - halfCross}l${2 * halfCross} ${2 * halfCross}M${x + halfCross} ${y - halfCross}l${-2 * halfCross} ${2 * halfCross}`}
        />
      )}
    </g>
  );
}

/** A prismatic joint: a sleeve along its axis. */
function PrismaticGlyph({ i, place: [x, y], z, view }: GlyphProps): JSX.Element {
  const [dx, dy] = vectorInPixels(view, z);
  const angle = (Math.atan2(dy, dx) * 180) / Math.PI;
  return (
    <g class={`arm-joint ${jointClass(i)}`} transform={`translate(${x} ${y}) rotate(${angle})`}>
      <rect class="arm-joint-face" x={-17} y={-9} width={34} height={18} rx={2} />
    </g>
  );
}

/** The ground that carries the base: a hatched line below O_0. */
function Ground({ state, view }: Pick<BodyProps, "state" | "view">): JSX.Element {
  const [x, y] = toPixel(view, state.frames[0]!.o);
  const ticks = [-24, -15, -6, 3, 12, 21, 30].map((k) => `M${x + k} ${y + 24}l-8 8`).join("");
  return (
    <g class="arm-ground">
      <path class="arm-pedestal" d={`M${x} ${y}L${x - 13} ${y + 24}h26Z`} />
      <path d={`M${x - 30} ${y + 24}h60${ticks}`} />
    </g>
  );
}

/** Return a line in space as the points of an SVG polyline. */
export const polylineText = (view: View, points: readonly Vec3[]): string =>
  pointsText((points.length === 1 ? [points[0]!, points[0]!] : points).map((point) => toPixel(view, point)));

/** An arrow in space: its start and its vector. */
type ArrowSpan = Pick<NamedArrow, "start" | "vector">;

/** An arrow with the name at its head. */
export type NamedArrow = {
  readonly name: string;
  readonly className: string;
  readonly start: Vec3;
  readonly vector: Vec3;
};

/** Return the label at the head of an arrow. */
export function headLabel(view: View, { name, className, start, vector }: NamedArrow): WantedLabel {
  return { name, className, place: toPixel(view, add(start, vector)), direction: vectorInPixels(view, vector) };
}

/** Return the length of an arrow on the page (pixels). */
export const lengthInPixels = (view: View, { vector }: NamedArrow): number =>
  Math.hypot(...vectorInPixels(view, vector));

/** Return an arrow's shaft and heads in pixels; `hasTwinHead` adds a second head, as for angular velocities. */
function shapeOfArrow(
  view: View,
  { start, vector }: ArrowSpan,
  hasTwinHead = false,
): [shaft: Pixel[], heads: Pixel[][]] | null {
  const [x, y] = toPixel(view, start);
  const [dx, dy] = vectorInPixels(view, vector);
  const length = Math.hypot(dx, dy);
  if (length < 3) return null;
  const size = Math.min(11, 0.6 * length);
  const [ux, uy] = [dx / length, dy / length];
  const head = (distanceFromTip: number): Pixel[] => {
    const [tx, ty] = [x + dx - distanceFromTip * ux, y + dy - distanceFromTip * uy];
    const [bx, by] = [tx - size * ux, ty - size * uy];
    const [wx, wy] = [0.38 * size * uy, 0.38 * size * ux];
    return [
      [tx, ty],
      [bx - wx, by + wy],
      [bx + wx, by - wy],
    ];
  };
  const shaft: Pixel[] = [
    [x, y],
    [x + dx - 0.7 * size * ux, y + dy - 0.7 * size * uy],
  ];
  return [shaft, hasTwinHead ? [head(0), head(7)] : [head(0)]];
}

type ArrowClass = { readonly view: View; readonly className: string };
type ArrowProps = ArrowClass & ArrowSpan & { readonly hasTwinHead?: boolean };

/** A thin arrow. It uses points, because browsers redraw them faster than the `d` of a path. */
export function Arrow({ view, start, vector, className, hasTwinHead = false }: ArrowProps): JSX.Element | null {
  const arrow = shapeOfArrow(view, { start, vector }, hasTwinHead);
  if (!arrow) return null;
  const [shaft, heads] = arrow;
  return (
    <g class={`arm-arrow ${className}`}>
      <polyline class="arm-shaft" points={pointsText(shaft)} />
      {heads.map((head, i) => (
        <polygon key={i} class="arm-head" points={pointsText(head)} />
      ))}
    </g>
  );
}

/** Arrows of one CSS class, drawn by one path. */
export function Arrows({ view, className, spans }: ArrowClass & { readonly spans: readonly ArrowSpan[] }): JSX.Element {
  const arrows = spans.map((span) => shapeOfArrow(view, span)).filter((arrow) => arrow !== null);
  return (
    <g class={`arm-arrow ${className}`}>
      <path class="arm-shaft" d={arrows.map(([shaft]) => `M${pointsText(shaft, "L")}`).join("")} />
      <path class="arm-head" d={arrows.map(([, [head]]) => `M${pointsText(head!, "L")}Z`).join("")} />
    </g>
  );
}

/** Return the vector along `direction` (a unit vector) that is as long as some pixels of the view. */
export const vectorOfLength = (view: View, direction: Vec3, pixels: number): Vec3 =>
  scaleVector(direction, pixels / view.scale);
