// Draw what lies over the arm: frames, vectors p*, columns of J, the velocity ellipse, and their labels.

import type { JSX } from "preact";

import { inDigits } from "../text/text.js";
import { Arrow, Arrows, type BodyProps, headLabel, lengthOf, type NamedArrow, ofPixels } from "./flat.js";
import { Angles, arcOf } from "./angles.js";
import { type Covered, placed, type Wanted } from "./labels.js";
import { DrawnLetters, jointClass } from "./letters.js";
import { shownLost } from "./lost.js";
import { type Arm, arrowsOf, type Measures, pStar, type State } from "./model.js";
import { extentOf, thicknessOf } from "./ranges.js";
import { linkOf, placesOf, wayToPoint } from "./shape.js";
import { add, along, scaled, type Vec3, ZERO } from "./vector.js";
import { drawn, lifted, outline, pixel, type Pixel, type View } from "./view.js";
import { wayToBase, World, worldLabels } from "./world.js";

export interface Layers {
  readonly frames: boolean;
  readonly lengths: boolean;
  readonly vectors: boolean;
  readonly columns: boolean;
  readonly ellipse: boolean;
}

export const LAYERS = ["frames", "lengths", "vectors", "columns", "ellipse"] as const;

/** Metres on the drawing for one m/s, less for a small arm. */
const BY_SPEED = 0.4;
/** Length of the axes of a frame in pixels; in space they come out of the bodies of joints. */
function axisOf({ width, height }: View, flat: boolean): number {
  return Math.min(flat ? 44 : 58, (flat ? 0.12 : 0.16) * Math.min(width, height));
}

/** Half of a joint's sign in a flat drawing (pixels), which letters are to leave free. */
const FACE = 8;
/** A length that is drawn shorter (pixels) has no label. */
const SHORT = 24;
/** A lower or narrower drawing (pixels) has no room for the names of axes and origins beside those of joints. */
const ROOMY = 300;

/** Metres on the drawing for one m/s of P. */
export function speedScale(arm: Arm): number {
  const { around, above } = extentOf(arm);
  return BY_SPEED * Math.min(1, Math.max(around, above));
}

/** The columns of J as they are drawn at P (m). */
export function drawnColumns(arm: Arm, state: State, reach: number): readonly Vec3[] {
  const { turning, columns } = arrowsOf(arm, state);
  const by = turning ? 0.35 * reach : speedScale(arm);
  return columns.map((column) => scaled(column, by));
}

/** Half of the disc of P (pixels), and the length of an arrow that comes out of it far enough to be seen. */
const [DISC, CLEAR] = [9, 26];
/** An arrow that is shorter (pixels) is none. */
const LEAST = 3;

/** Where the arrow of a column begins: at P, or, as it gets short, further out, up to the rim of the disc of P. */
export function tailOf(view: View, point: Vec3, column: Vec3): Vec3 {
  const [x, y] = drawn(view, column);
  const length = Math.hypot(x, y);
  if (length < LEAST || length > CLEAR) return point;
  const out = Math.min(DISC, CLEAR - length) / length;
  return add(point, lifted(view, [out * x, out * y]));
}

export interface MarksProps extends BodyProps {
  readonly layers: Layers;
  readonly flat: boolean;
  readonly measures: Measures;
  /** Whether the line that P can't leave would tell what is asked. */
  readonly concealed: boolean;
  /** The joint that is pointed at, whose column stands out. */
  readonly lit: number | null;
  /** The ends of a path by their names. */
  readonly ends: Readonly<Record<string, Vec3>>;
  /** What lies over the drawing: letters stand beside it. */
  readonly covered: Covered;
}

export function Marks(props: MarksProps): JSX.Element {
  const { arm, state, view, reach, layers, flat, measures, concealed, lit } = props;
  const columns = drawnColumns(arm, state, reach);
  const arrows = namedArrows(props, columns);
  const { turning } = arrowsOf(arm, state);
  const P = pixel(view, state.point);
  const ellipse = outline(view, columns);
  const lost = shownLost(arm, state, measures, concealed);
  const [dx, dy] = drawn(view, ofPixels(view, lost ?? ZERO, 90));
  return (
    <g class="arm-marks">
      <World arm={arm} view={view} flat={flat} />
      {layers.frames && flat && <Angles arm={arm} state={state} view={view} />}
      {layers.ellipse && (
        <ellipse
          class={flat ? "arm-ellipse" : "arm-ellipse arm-ellipse-space"}
          rx={Math.max(ellipse.major, 0.6)}
          ry={Math.max(ellipse.minor, 0.6)}
          transform={`translate(${P[0]} ${P[1]}) rotate(${ellipse.turn})`}
        />
      )}
      {lost && <path class="arm-lost" d={`M${P[0] - dx} ${P[1] - dy}L${P[0] + dx} ${P[1] + dy}`} />}
      {arrows.vectors.map(({ name, style, ...way }) => (
        <Arrow key={name} view={view} {...way} style={`arm-pstar ${style}`} />
      ))}
      <Arrows view={view} ways={arrows.axes.filter(({ style }) => style === GREY)} style={GREY} />
      {arrows.axes
        .filter(({ style }) => style !== GREY)
        .map(({ name, style, ...way }) => (
          <Arrow key={name} view={view} {...way} style={`arm-z ${style}`} />
        ))}
      {arrows.columns.map(({ name, style, ...way }, i) => (
        <Arrow
          key={name}
          view={view}
          {...way}
          style={`arm-column ${style}${lit === i ? " arm-lit" : ""}`}
          twin={turning}
        />
      ))}
      <g class="arm-letter-layer">
        {placed(
          wantedLabels(props, arrows),
          [
            ...arm.joints.map((_, i) => linkOf(arm, state, i + 1).map((point) => pixel(view, point))),
            ...(flat ? [groundAt(pixel(view, state.frames[0]!.o))] : []),
            ...[...arrows.axes, ...arrows.columns].map(({ from, vector }) => [
              pixel(view, from),
              pixel(view, add(from, vector)),
            ]),
          ],
          { width: view.width, height: view.height, covered: props.covered },
        ).map(({ name, style, x, y, from }, k, all) => (
          <g key={`${name} ${all.slice(0, k).filter((other) => other.name === name).length}`} class={style}>
            {from ? <path class="arm-leader" d={`M${from[0]} ${from[1]}L${x} ${y}`} /> : null}
            <g transform={`translate(${x} ${y})`}>
              <text y={5}>
                <DrawnLetters name={name} />
              </text>
            </g>
          </g>
        ))}
      </g>
    </g>
  );
}

/** The style of axes that no joint rotates about: they are alike. */
const GREY = "arm-x";

/** The arrows of the layers that are shown, with their names. */
type NamedArrows = Readonly<Record<"axes" | "columns" | "vectors", readonly NamedArrow[]>>;

function namedArrows(props: MarksProps, columns: readonly Vec3[]): NamedArrows {
  const { arm, state, view, layers, flat } = props;
  const { frames, point } = state;
  const axes = frames.flatMap(({ x, y, z, o: from }, i): NamedArrow[] => {
    const vectorOf = (axis: Vec3): Vec3 => ofPixels(view, axis, axisOf(view, flat));
    const grey = { name: `x${i}`, style: GREY, from, vector: vectorOf(x) };
    const joint = i < arm.joints.length ? jointClass(i) : "arm-last";
    return flat
      ? [grey, { ...grey, name: `y${i}`, vector: vectorOf(y) }]
      : [grey, { name: `z${i}`, style: joint, from, vector: vectorOf(z) }];
  });
  const ofColumn = (vector: Vec3, i: number): NamedArrow => {
    return { name: `J${i + 1}`, style: jointClass(i), from: tailOf(view, point, vector), vector };
  };
  const ofVector = (vector: Vec3, i: number): NamedArrow => {
    return { name: `p*${i}`, style: jointClass(i), from: frames[i]!.o, vector };
  };
  return {
    axes: layers.frames ? axes : [],
    columns: layers.columns ? columns.map(ofColumn) : [],
    vectors: layers.vectors ? pStar(arm, state).slice(0, arm.point.frame).map(ofVector) : [],
  };
}

/** The ground below a base in a flat drawing, as a line that letters leave free. */
function groundAt([x, y]: Pixel): Pixel[] {
  return [
    [x, y],
    [x, y + 26],
    [x - 30, y + 26],
    [x + 30, y + 26],
  ];
}

function wantedLabels({ arm, state, view, reach, layers, flat, ends }: MarksProps, arrows: NamedArrows): Wanted[] {
  const { point, frames } = state;
  const wanted: Wanted[] = [];
  const names = layers.frames && Math.min(view.width, view.height) >= ROOMY;
  const origins: [name: string, at: Pixel][] = [["P", pixel(view, point)]];
  if (names)
    frames.forEach(({ o }, i) => {
      const at = pixel(view, o);
      const same = origins.find(([, other]) => Math.hypot(other[0] - at[0], other[1] - at[1]) < 1);
      if (same) same[0] += `=O${i}`;
      else origins.push([`O${i}`, at]);
    });
  origins.forEach(([name, at], k) =>
    wanted.push({ name, style: "arm-label-p", at, toward: [0.7, k === 0 ? -0.7 : 0.7], gap: flat ? FACE : 4 }),
  );
  for (const [name, place] of Object.entries(ends))
    wanted.push({ name, style: "arm-end", at: pixel(view, place), toward: [-0.7, 0.7], gap: FACE });
  wanted.push(...worldLabels(arm, view, flat));
  if (layers.lengths) wanted.push(...lengthLabels(arm, state, view));
  for (const column of arrows.columns) if (lengthOf(view, column) > LEAST) wanted.push(headLabel(view, column));
  for (const axis of names ? arrows.axes : [])
    if (lengthOf(view, axis) > 14 && (flat || axis.style !== GREY))
      wanted.push({ ...headLabel(view, axis), beside: true });
  const places = placesOf(arm, state, reach);
  places.forEach((place, i) => {
    const arc = flat && layers.frames ? arcOf(arm, state, view, i) : null;
    if (arc) {
      wanted.push({ name: arm.joints[i]!.name, style: jointClass(i), at: arc.middle, toward: arc.outward });
      return;
    }
    wanted.push({
      name: arm.joints[i]!.name,
      style: jointClass(i),
      at: pixel(view, place),
      toward: flat ? sideOf(arm, state, view, i) : besideAxis(state, view, i),
      gap: flat ? FACE : thicknessOf(arm) * view.scale,
    });
  });
  for (const { from, vector, ...named } of arrows.vectors) {
    const [x, y] = drawn(view, vector);
    if (Math.hypot(x, y) > 40) wanted.push({ ...named, at: pixel(view, along(from, vector, 0.55)), toward: [-y, x] });
  }
  return wanted;
}

/** A length of the arm: what it is called, how long it is (m), and from where to where it is drawn. */
type Length = readonly [called: string, value: number, from: Vec3, to: Vec3];

/** The lengths of the table, of the way to the point, and of the base's place in the world. */
function lengthsOf(arm: Arm, state: State): Length[] {
  const carrier = state.frames[arm.point.frame]!;
  const of = (called: readonly string[], values: Vec3, places: readonly Vec3[]): Length[] =>
    values.map((value, k): Length => [called[k]!, value, places[k]!, places[k + 1]!]);
  return [
    ...arm.joints.flatMap(({ a, called, other }, i): Length[] => [
      [called.a, a, state.corners[i]!, state.frames[i + 1]!.o],
      ...(called.d ? [[called.d, other, state.frames[i]!.o, state.corners[i]!] as const] : []),
    ]),
    ...of(arm.called?.offset ?? [], arm.point.offset, [carrier.o, ...wayToPoint(carrier, arm.point.offset)]),
    ...of(arm.called?.base ?? [], arm.base.o, wayToBase(arm)),
  ].filter(([called]) => called);
}

/** Labels of lengths beside their middles; letters as they are, numbers as the page writes them. */
function lengthLabels(arm: Arm, state: State, view: View): Wanted[] {
  return lengthsOf(arm, state).flatMap(([called, value, from, to]): Wanted[] => {
    const [p, q] = [pixel(view, from), pixel(view, to)];
    const [x, y] = [q[0] - p[0], q[1] - p[1]];
    if (Math.hypot(x, y) < SHORT) return [];
    const size = inDigits(Math.abs(Number(value.toFixed(3))));
    const name = /^-?[a-z]\d*$/i.test(called) ? called.replace("-", "") : size;
    return [{ name, style: "arm-length", at: [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2], toward: [y, -x] }];
  });
}

/** The side of a joint of space on which its body ends: square to its axis, to the left. */
function besideAxis(state: State, view: View, i: number): Pixel {
  const [x, y] = drawn(view, state.frames[i]!.z);
  const side: Pixel = [-y, x];
  return side[0] > 0 ? [y, -x] : side;
}

/** The side of a joint on which no link runs. */
function sideOf(arm: Arm, state: State, view: View, i: number): Pixel {
  const here = pixel(view, state.frames[i]!.o);
  const others = [linkOf(arm, state, i + 1)[1], i > 0 ? linkOf(arm, state, i).at(-2) : undefined];
  let [x, y] = [0, 0];
  for (const other of others) {
    if (!other) continue;
    const [ox, oy] = pixel(view, other);
    const size = Math.hypot(ox - here[0], oy - here[1]) || 1;
    x -= (ox - here[0]) / size;
    y -= (oy - here[1]) / size;
  }
  return Math.hypot(x, y) > 0.1 ? [x, y] : [-0.7, -0.7];
}
