// Draw the layers over the arm: frames, vectors p*, columns of J, the velocity ellipse, and their labels.

import type { JSX } from "preact";

import { formatNumber } from "../text/text.js";
import {
  Arrow,
  Arrows,
  type BodyProps,
  headLabel,
  lengthInPixels,
  type NamedArrow,
  vectorOfLength,
} from "./line-drawing.js";
import { Angles, arcOf } from "./angles.js";
import { type Covered, placeLabels, type WantedLabel } from "./labels.js";
import { DrawnLetters, jointClass } from "./letters.js";
import { drawnLostDirection } from "./lost-direction.js";
import { type Arm, arrowsOf, type Measures, pStar, type State } from "./model.js";
import { extentOf, thicknessOf } from "./ranges.js";
import { linkOf, jointCentresOf, wayToPoint } from "./shape.js";
import { add, addScaled, scaleVector, type Vec3, ZERO } from "./vector.js";
import { vectorInPixels, vectorFromPixels, ellipseOnPage, toPixel, type Pixel, type View } from "./view.js";
import { wayToBase, World, worldLabels } from "./world.js";

export const LAYERS = ["frames", "lengths", "vectors", "columns", "ellipse", "trace"] as const;
export type Layers = Readonly<Record<(typeof LAYERS)[number], boolean>>;

/** Drawn length (m) of a velocity of 1 m/s, if the arm is not smaller than 1 m. */
const LENGTH_OF_UNIT_SPEED = 0.4;
/** Return the length of a frame's axes in pixels; in space they must reach out of the bodies of joints. */
export function axisLength({ width, height }: View, isFlat: boolean): number {
  return Math.min(isFlat ? 44 : 58, (isFlat ? 0.12 : 0.16) * Math.min(width, height));
}

/** Half the size of a joint's symbol in a flat drawing (pixels), which letters leave free. */
const HALF_SYMBOL = 8;
/** A link that is drawn shorter (pixels) gets no length label. */
const MIN_LABELLED_LENGTH = 24;
/** A drawing that is lower or narrower (pixels) has no room for the names of axes and origins. */
const MIN_SIZE_FOR_NAMES = 300;

/** Return the drawn length (m) of a velocity of 1 m/s of P. */
export function speedScale(arm: Arm): number {
  const { radius, above } = extentOf(arm);
  return LENGTH_OF_UNIT_SPEED * Math.min(1, Math.max(radius, above));
}

/** Return the columns of J as they are drawn at P (m). */
export function drawnColumns(arm: Arm, state: State, reach: number): readonly Vec3[] {
  const { isAngular, columns } = arrowsOf(arm, state);
  const scale = isAngular ? 0.35 * reach : speedScale(arm);
  return columns.map((column) => scaleVector(column, scale));
}

/** Radius of the disc at P, and the length above which an arrow begins at P itself (pixels). */
const [DISC_RADIUS, CLEAR_LENGTH] = [9, 26];
/** An arrow that is shorter (pixels) is not drawn. */
const MIN_ARROW_LENGTH = 3;

/** Return where the arrow of a column begins: at P or, if the arrow is short, at most at the rim of P's disc. */
function arrowStart(view: View, point: Vec3, column: Vec3): Vec3 {
  const [x, y] = vectorInPixels(view, column);
  const length = Math.hypot(x, y);
  if (length < MIN_ARROW_LENGTH || length > CLEAR_LENGTH) return point;
  const share = Math.min(DISC_RADIUS, CLEAR_LENGTH - length) / length;
  return add(point, vectorFromPixels(view, [share * x, share * y]));
}

interface MarksProps extends BodyProps {
  readonly layers: Layers;
  readonly isFlat: boolean;
  readonly measures: Measures;
  /** Whether the line along which P can't move would reveal the answer to the question. */
  readonly isConcealed: boolean;
  /** The joint that is pointed at, whose column is highlighted; null if none is. */
  readonly highlightedJoint: number | null;
  /** The ends of a path by name. */
  readonly ends: Readonly<Record<string, Vec3>>;
  /** Lines of what a page draws over the arm, which labels avoid. */
  readonly overlayLines: readonly (readonly Vec3[])[];
  /** Boxes over the drawing, which labels avoid. */
  readonly covered: Covered;
}

export function Marks(props: MarksProps): JSX.Element {
  const { arm, state, view, reach, layers, isFlat, measures, isConcealed, highlightedJoint } = props;
  const columns = drawnColumns(arm, state, reach);
  const arrows = namedArrows(props, columns);
  const { isAngular } = arrowsOf(arm, state);
  const P = toPixel(view, state.point);
  const ellipse = ellipseOnPage(view, columns);
  const lostVector = drawnLostDirection(arm, state, measures, isConcealed);
  const [dx, dy] = vectorInPixels(view, vectorOfLength(view, lostVector ?? ZERO, 90));
  return (
    <g class="arm-marks">
      <World arm={arm} view={view} isFlat={isFlat} />
      {layers.frames && isFlat && <Angles arm={arm} state={state} view={view} />}
      {layers.ellipse && (
        <ellipse
          class={isFlat ? "arm-ellipse" : "arm-ellipse arm-ellipse-space"}
          rx={Math.max(ellipse.major, 0.6)}
          ry={Math.max(ellipse.minor, 0.6)}
          transform={`translate(${P[0]} ${P[1]}) rotate(${ellipse.rotation})`}
        />
      )}
      {lostVector && <path class="arm-lost" d={`M${P[0] - dx} ${P[1] - dy}L${P[0] + dx} ${P[1] + dy}`} />}
      {arrows.vectors.map(({ name, className, ...span }) => (
        <Arrow key={name} view={view} {...span} className={`arm-pstar ${className}`} />
      ))}
      <Arrows view={view} spans={arrows.axes.filter(({ className }) => className === GREY)} className={GREY} />
      {arrows.axes
        .filter(({ className }) => className !== GREY)
        .map(({ name, className, ...span }) => (
          <Arrow key={name} view={view} {...span} className={`arm-z ${className}`} />
        ))}
      {arrows.columns.map(({ name, className, ...span }, i) => (
        <Arrow
          key={name}
          view={view}
          {...span}
          className={`arm-column ${className}${highlightedJoint === i ? " arm-lit" : ""}`}
          hasTwinHead={isAngular}
        />
      ))}
      <g class="arm-letter-layer">
        {placeLabels(
          wantedLabels(props, arrows),
          [
            ...arm.joints.map((_, i) => linkOf(arm, state, i + 1).map((point) => toPixel(view, point))),
            ...props.overlayLines.map((line) => line.map((point) => toPixel(view, point))),
            ...(isFlat ? [groundAt(toPixel(view, state.frames[0]!.o))] : []),
            ...[...arrows.axes, ...arrows.columns].map(({ start, vector }) => [
              toPixel(view, start),
              toPixel(view, add(start, vector)),
            ]),
          ],
          { width: view.width, height: view.height, covered: props.covered },
        ).map(({ name, className, x, y, leaderStart }, k, placedLabels) => (
          <g
            key={`${name} ${placedLabels.slice(0, k).filter((other) => other.name === name).length}`}
            class={className}
          >
            {leaderStart ? <path class="arm-leader" d={`M${leaderStart[0]} ${leaderStart[1]}L${x} ${y}`} /> : null}
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

/** The CSS class of axes about which no joint rotates. */
const GREY = "arm-x";

/** The arrows of the layers that are shown, with their names. */
type NamedArrows = Readonly<Record<"axes" | "columns" | "vectors", readonly NamedArrow[]>>;

function namedArrows(props: MarksProps, columns: readonly Vec3[]): NamedArrows {
  const { arm, state, view, layers, isFlat } = props;
  const { frames, point } = state;
  const axes = frames.flatMap(({ x, y, z, o: start }, i): NamedArrow[] => {
    const vectorOf = (axis: Vec3): Vec3 => vectorOfLength(view, axis, axisLength(view, isFlat));
    const xAxis = { name: `x${i}`, className: GREY, start, vector: vectorOf(x) };
    const className = i < arm.joints.length ? jointClass(i) : "arm-last";
    return isFlat
      ? [xAxis, { ...xAxis, name: `y${i}`, vector: vectorOf(y) }]
      : [xAxis, { name: `z${i}`, className, start, vector: vectorOf(z) }];
  });
  const columnArrow = (vector: Vec3, i: number): NamedArrow => {
    return { name: `J${i + 1}`, className: jointClass(i), start: arrowStart(view, point, vector), vector };
  };
  const vectorArrow = (vector: Vec3, i: number): NamedArrow => {
    return { name: `p*${i}`, className: jointClass(i), start: frames[i]!.o, vector };
  };
  return {
    axes: layers.frames ? axes : [],
    columns: layers.columns ? columns.map(columnArrow) : [],
    vectors: layers.vectors ? pStar(arm, state).slice(0, arm.point.frame).map(vectorArrow) : [],
  };
}

/** Return the ground below the base in a flat drawing, as a line that labels avoid. */
function groundAt([x, y]: Pixel): Pixel[] {
  return [
    [x, y],
    [x, y + 26],
    [x - 30, y + 26],
    [x + 30, y + 26],
  ];
}

function wantedLabels(
  { arm, state, view, reach, layers, isFlat, ends }: MarksProps,
  arrows: NamedArrows,
): WantedLabel[] {
  const { point, frames } = state;
  const labels: WantedLabel[] = [];
  const hasRoomForNames = layers.frames && Math.min(view.width, view.height) >= MIN_SIZE_FOR_NAMES;
  const labelledPoints: [name: string, place: Pixel][] = [["P", toPixel(view, point)]];
  if (hasRoomForNames)
    frames.forEach(({ o }, i) => {
      const place = toPixel(view, o);
      const sameOrigin = labelledPoints.find(([, other]) => Math.hypot(other[0] - place[0], other[1] - place[1]) < 1);
      if (sameOrigin) sameOrigin[0] += `=O${i}`;
      else labelledPoints.push([`O${i}`, place]);
    });
  labelledPoints.forEach(([name, place], k) =>
    labels.push({
      name,
      className: "arm-label-p",
      place,
      direction: [0.7, k === 0 ? -0.7 : 0.7],
      gap: isFlat ? HALF_SYMBOL : 4,
    }),
  );
  for (const [name, place] of Object.entries(ends))
    labels.push({ name, className: "arm-end", place: toPixel(view, place), direction: [-0.7, 0.7], gap: HALF_SYMBOL });
  labels.push(...worldLabels(arm, view, isFlat));
  if (layers.lengths) labels.push(...lengthLabels(arm, state, view));
  for (const column of arrows.columns)
    if (lengthInPixels(view, column) > MIN_ARROW_LENGTH) labels.push(headLabel(view, column));
  for (const axis of hasRoomForNames ? arrows.axes : [])
    if (lengthInPixels(view, axis) > 14 && (isFlat || axis.className !== GREY))
      labels.push({ ...headLabel(view, axis), isClose: true });
  const places = jointCentresOf(arm, state, reach);
  places.forEach((place, i) => {
    const label = { name: arm.joints[i]!.name, className: jointClass(i) };
    const arc = isFlat && layers.frames ? arcOf(arm, state, view, i) : null;
    const direction = isFlat ? directionAwayFromLinks(arm, state, view, i) : directionBesideAxis(state, view, i);
    const gap = isFlat ? HALF_SYMBOL : thicknessOf(arm) * view.scale;
    labels.push({
      ...label,
      ...(arc
        ? { place: arc.labelPlace, direction: arc.labelDirection }
        : { place: toPixel(view, place), direction, gap }),
    });
  });
  for (const { start, vector, ...named } of arrows.vectors) {
    const [x, y] = vectorInPixels(view, vector);
    if (Math.hypot(x, y) > 40)
      labels.push({ ...named, place: toPixel(view, addScaled(start, vector, 0.55)), direction: [-y, x] });
  }
  return labels;
}

/** A length of the arm: its label in the table, its value (m), and the points between which it is drawn. */
type DrawnLength = readonly [label: string, value: number, start: Vec3, end: Vec3];

/** Return the lengths of the table, of the way to P, and of the base's position in the world. */
function lengthsOf(arm: Arm, state: State): DrawnLength[] {
  const lastFrame = state.frames[arm.point.frame]!;
  const lengthsBetween = (labels: readonly string[], values: Vec3, places: readonly Vec3[]): DrawnLength[] =>
    values.map((value, k): DrawnLength => [labels[k]!, value, places[k]!, places[k + 1]!]);
  return [
    ...arm.joints.flatMap(({ a, labels, otherConstant }, i): DrawnLength[] => [
      [labels.a, a, state.corners[i]!, state.frames[i + 1]!.o],
      ...(labels.d ? [[labels.d, otherConstant, state.frames[i]!.o, state.corners[i]!] as const] : []),
    ]),
    ...lengthsBetween(arm.labels?.offset ?? [], arm.point.offset, [
      lastFrame.o,
      ...wayToPoint(lastFrame, arm.point.offset),
    ]),
    ...lengthsBetween(arm.labels?.base ?? [], arm.base.o, wayToBase(arm)),
  ].filter(([label]) => label);
}

/** Return labels beside the middles of lengths: a symbol as in the table, a number as the page writes it. */
function lengthLabels(arm: Arm, state: State, view: View): WantedLabel[] {
  return lengthsOf(arm, state).flatMap(([label, value, start, end]): WantedLabel[] => {
    const [p, q] = [toPixel(view, start), toPixel(view, end)];
    const [x, y] = [q[0] - p[0], q[1] - p[1]];
    if (Math.hypot(x, y) < MIN_LABELLED_LENGTH) return [];
    const size = formatNumber(Math.abs(Number(value.toFixed(3))));
    const name = /^-?[a-z]\d*$/i.test(label) ? label.replace("-", "") : size;
    return [{ name, className: "arm-length", place: [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2], direction: [y, -x] }];
  });
}

/** Return the direction beside a spatial joint's axis, perpendicular to it, to the left on the page. */
function directionBesideAxis(state: State, view: View, i: number): Pixel {
  const [x, y] = vectorInPixels(view, state.frames[i]!.z);
  const side: Pixel = [-y, x];
  return side[0] > 0 ? [y, -x] : side;
}

/** Return the direction away from the links of a joint. */
function directionAwayFromLinks(arm: Arm, state: State, view: View, i: number): Pixel {
  const joint = toPixel(view, state.frames[i]!.o);
  const neighbours = [linkOf(arm, state, i + 1)[1], i > 0 ? linkOf(arm, state, i).at(-2) : undefined];
  let [x, y] = [0, 0];
  for (const other of neighbours) {
    if (!other) continue;
    const [ox, oy] = toPixel(view, other);
    const size = Math.hypot(ox - joint[0], oy - joint[1]) || 1;
    x -= (ox - joint[0]) / size;
    y -= (oy - joint[1]) / size;
  }
  return Math.hypot(x, y) > 0.1 ? [x, y] : [-0.7, -0.7];
}
