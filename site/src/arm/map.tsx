// The map of det J over two joints. Dragging on the map moves the arm; the singular set appears as its zero lines.

import type { JSX } from "preact";
import { memo, withPace } from "../pace.js";
import { useCallback, useContext, useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Choice, optionsOf } from "../controls.js";
import { formatNumber, say } from "../text/text.js";
import { plainLetters, Words } from "./letters.js";
import type { Arm } from "./model.js";
import { rangeOf, limitToRange } from "./ranges.js";
import { useDebounced } from "../scheduling.js";
import { drawingScale, useSize } from "./size.js";
import { onSchemeChange } from "./space.js";
import { toDegrees, roundToDecimals, roundToDigits, InRadians } from "./number-format.js";
import type { Stage } from "./stage.js";
import { findMostSensitivePair, type JointPair, poseAtSpot, type ShownValue } from "./terrain.js";
import { paintTerrain } from "./shade.js";
import { sizeKey } from "./descriptions.js";
import { useMap } from "./use-map.js";
import { interpolate, type Spot, type Stretch } from "./zeros.js";
import { clamp } from "./vector.js";
import { ARROWS, hasModifier, keyStep, nearestOnLine, type Pixel, pointsText } from "./view.js";

const [LEFT_MARGIN, BOTTOM_MARGIN, EDGE_MARGIN] = [44, 34, 18];
const NO_STRETCHES: readonly Stretch[] = [];

export function SingularMap(props: Pick<Stage, "arm" | "pose" | "measures" | "move">): JSX.Element {
  const { arm, pose, measures, move } = props;
  const inRadians = useContext(InRadians);
  const [pair, setPair] = useState<JointPair>(() => findMostSensitivePair(arm));
  const [shownValue, setShown] = useState<ShownValue>("det");
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [isDragging, setHeld] = useState(false);
  const [width, height] = useSize(box, [420, 380]);

  useEffect(() => setPair(findMostSensitivePair(arm)), [arm]);
  const pick = useCallback((axis: 0 | 1, joint: number) => setPair((current) => withJoint(current, axis, joint)), []);

  // Only the joints that are not on the map change the map.
  const otherJoints = pose.map((value, i) => (pair.includes(i) ? 0 : value));
  const otherJointsKey = otherJoints.map((value) => value.toFixed(4)).join(" ");
  const settledKey = useDebounced(otherJointsKey, 120);
  const map = useMap(arm, otherJoints, pair, shownValue, settledKey);
  const terrain = map?.terrain ?? null;
  const stretches = map?.stretches ?? NO_STRETCHES;

  const [acrossJoint, upJoint] = pair;
  const [acrossRange, upRange] = [rangeOf(arm, acrossJoint), rangeOf(arm, upJoint)];
  const [plotWidth, plotHeight] = [width - LEFT_MARGIN - EDGE_MARGIN, height - BOTTOM_MARGIN - EDGE_MARGIN];
  const xOf = (u: number): number =>
    LEFT_MARGIN + ((u - acrossRange.low) / (acrossRange.high - acrossRange.low)) * plotWidth;
  const yOf = (v: number): number =>
    EDGE_MARGIN + plotHeight - ((v - upRange.low) / (upRange.high - upRange.low)) * plotHeight;
  const pixelOf = ([u, v]: Spot): Pixel => [xOf(u), yOf(v)];
  const currentSpot: Spot = [pose[acrossJoint]!, pose[upJoint]!];
  const moveTo = ([u, v]: Spot): void =>
    move(poseAtSpot(pose, pair, [limitToRange(arm, acrossJoint, u), limitToRange(arm, upJoint, v)]));
  const dragTo = (event: PointerEvent): void => {
    const corner = box.current!.getBoundingClientRect();
    const scale = drawingScale();
    const [x, y] = [(event.clientX - corner.left) / scale, (event.clientY - corner.top) / scale];
    const pointedSpot: Spot = [
      acrossRange.low + clamp((x - LEFT_MARGIN) / plotWidth, 0, 1) * (acrossRange.high - acrossRange.low),
      upRange.low + clamp((EDGE_MARGIN + plotHeight - y) / plotHeight, 0, 1) * (upRange.high - upRange.low),
    ];
    moveTo(snapToLine(pointedSpot, stretches, pixelOf));
  };
  const pressKey = (event: KeyboardEvent): void => {
    const step = ARROWS[event.key];
    if (!step || hasModifier(event)) return;
    const stepOf = (joint: number): number => keyStep(arm.joints[joint]!.kind, event);
    const [[u, v], [across, down]] = [currentSpot, step];
    moveTo([u + across * stepOf(acrossJoint), v - down * stepOf(upJoint)]);
    event.preventDefault();
  };

  useEffect(() => {
    if (!terrain) return;
    const paint = (): void => paintTerrain(canvas.current, terrain, shownValue === "det" && measures.det !== null);
    paint();
    return onSchemeChange(paint);
  }, [terrain]);

  // Lines and ticks are built only when they change: a line has hundreds of spots.
  const plotBounds = [acrossRange.low, acrossRange.high, upRange.low, upRange.high, plotWidth, plotHeight];
  const lines = useMemo(() => <Lines {...{ stretches, pixelOf, plotWidth, plotHeight }} />, [stretches, ...plotBounds]);
  const ticks = useMemo(
    () => (
      <>
        {ticksOf(arm, acrossJoint, inRadians).map(([value, text]) => (
          <g key={text} class="arm-tick">
            <path d={`M${xOf(value)} ${EDGE_MARGIN + plotHeight}v4`} />
            <text x={xOf(value)} y={EDGE_MARGIN + plotHeight + 16}>
              {text}
            </text>
          </g>
        ))}
        {ticksOf(arm, upJoint, inRadians).map(([value, text]) => (
          <g key={text} class="arm-tick arm-tick-left">
            <path d={`M${LEFT_MARGIN} ${yOf(value)}h-4`} />
            <text x={LEFT_MARGIN - 7} y={yOf(value) + 4}>
              {text}
            </text>
          </g>
        ))}
      </>
    ),
    [arm, pair, inRadians, ...plotBounds],
  );
  const legend = useMemo(
    () => (map?.hasKinds ? <Legend stretches={stretches} isEverywhere={map.terrain.max === 0} /> : null),
    [map],
  );
  const [x, y] = pixelOf(currentSpot);
  const name = shownValue === "least" ? say("arm.map.least") : say(sizeKey(arm));
  const joints = pair.map((joint) => plainLetters(arm.joints[joint]!.name));
  return (
    <section class="arm-map" aria-label={say("arm.map.title")}>
      <div class="arm-row">
        <Axis arm={arm} axis={0} joint={acrossJoint} onPick={pick} />
        <Axis arm={arm} axis={1} joint={upJoint} onPick={pick} />
        <label>
          <span class="arm-unseen">{say("arm.map.shown")}</span>
          <select value={shownValue} onChange={(event) => setShown(event.currentTarget.value as ShownValue)}>
            <option value="det">{say(sizeKey(arm))}</option>
            <option value="least">{say("arm.map.least")}</option>
          </select>
        </label>
      </div>
      <div
        ref={box}
        class="arm-map-frame"
        role="application"
        aria-roledescription={say("arm.map.role")}
        aria-label={say("arm.map.label", { value: name, across: joints[0]!, up: joints[1]! })}
        tabIndex={0}
        onKeyDown={pressKey}
        onPointerDown={(event) => {
          if (event.button !== 0) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          setHeld(true);
          dragTo(event);
        }}
        onPointerMove={(event) => isDragging && dragTo(event)}
        onPointerUp={() => setHeld(false)}
        onPointerCancel={() => setHeld(false)}
      >
        <canvas ref={canvas} class="arm-map-canvas" aria-hidden="true" hidden={!terrain} />
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
          <rect class="arm-map-edge" x={LEFT_MARGIN} y={EDGE_MARGIN} width={plotWidth} height={plotHeight} />
          {lines}
          {ticks}
          <path class="arm-cross" d={`M${LEFT_MARGIN} ${y}h${plotWidth}M${x} ${EDGE_MARGIN}v${plotHeight}`} />
          <g transform={`translate(${x} ${y})`}>
            <circle class="arm-here-halo" r={8} />
            <circle class="arm-here" r={5} />
          </g>
        </svg>
      </div>
      {legend ?? (
        <ul class="arm-legend">
          <li>
            <span role="status">
              <Words text={say(terrain ? "arm.map.finding-kinds" : "arm.map.finding-lines")} />
            </span>
          </li>
        </ul>
      )}
      <Here
        value={name}
        number={roundToDigits(shownValue === "least" ? measures.minSigma : (measures.det ?? measures.volume))}
      />
    </section>
  );
}

/** The value that the map shows, at the current pose. */
const Here = withPace(
  (props: { value: string; number: number }): JSX.Element => (
    <p class="arm-hint">
      <Words text={say("arm.map.here", props)} /> <span class="arm-how">{say("arm.map.hint")}</span>
    </p>
  ),
  { atOnce: ["value"], inTurn: ["number"] },
);

interface LinesProps {
  readonly stretches: readonly Stretch[];
  readonly pixelOf: (spot: Spot) => Pixel;
  readonly plotWidth: number;
  readonly plotHeight: number;
}

/** The singular set: lines, and isolated spots. */
function Lines({ stretches, pixelOf, plotWidth, plotHeight }: LinesProps): JSX.Element {
  const isCrowded = stretches.length > 16; // so many spots form a line
  return (
    <svg
      class="arm-map-inner"
      x={LEFT_MARGIN}
      y={EDGE_MARGIN}
      width={plotWidth}
      height={plotHeight}
      viewBox={`${LEFT_MARGIN} ${EDGE_MARGIN} ${plotWidth} ${plotHeight}`}
    >
      {stretches.map(({ kind, spots }, i) => {
        const [cx, cy] = pixelOf(spots[0]!);
        return spots.length > 1 ? (
          <polyline key={i} class={`arm-zero arm-${kind}`} points={pointsText(spots.map(pixelOf))} />
        ) : (
          <circle key={i} class={`arm-zero-spot arm-${kind}`} cx={cx} cy={cy} r={isCrowded ? 2.2 : 4.5} />
        );
      })}
    </svg>
  );
}

/** Distance (pixels) within which a line attracts the pointer: a hand could not stop exactly on the line. */
const SNAP_DISTANCE = 4;

/** Return the nearest place on the map's lines and spots; the spot itself if none is near. */
function snapToLine(spot: Spot, stretches: readonly Stretch[], pixelOf: (spot: Spot) => Pixel): Spot {
  let nearestSpot = spot;
  let leastDistance = SNAP_DISTANCE;
  for (const { spots } of stretches) {
    const { share, distance } = nearestOnLine(spots.map(pixelOf), pixelOf(spot));
    if (distance >= leastDistance) continue;
    const k = Math.floor(share);
    [nearestSpot, leastDistance] = [interpolate(spots[k]!, spots[k + 1] ?? spots[k]!)(share - k), distance];
  }
  return nearestSpot;
}

/** Return the pair with a joint on an axis; if the joint is on the other axis, the axes are exchanged. */
function withJoint([across, up]: JointPair, axis: 0 | 1, joint: number): JointPair {
  if (joint === (axis === 0 ? up : across)) return [up, across];
  return axis === 0 ? [joint, up] : [across, joint];
}

interface AxisProps {
  readonly arm: Arm;
  /** 0 for the axis across, 1 for the axis upward. */
  readonly axis: 0 | 1;
  readonly joint: number;
  readonly onPick: (axis: 0 | 1, joint: number) => void;
}

const Axis = memo(({ arm, axis, joint, onPick }: AxisProps): JSX.Element => (
  <Choice
    label={axis === 0 ? "arm.map.across" : "arm.map.up"}
    value={joint}
    onValue={(text) => onPick(axis, Number(text))}
  >
    {optionsOf(arm.joints.map(({ name }, i) => [i, plainLetters(name)]))}
  </Choice>
));

/** Return the ticks of an axis: every quarter turn of a revolute joint, or round lengths along a prismatic one. */
export function ticksOf(arm: Arm, joint: number, inRadians: boolean): (readonly [number, string])[] {
  const { low, high } = rangeOf(arm, joint);
  if (arm.joints[joint]!.kind === "P") {
    const least = (high - low) / 7;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= least * (1 - 1e-9))!;
    const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
    return Array.from({ length: last - first + 1 }, (_, k) => {
      const value = roundToDecimals((first + k) * step, 6);
      return [value, formatNumber(value)];
    });
  }
  return [0, 1, 2, 3, 4].map((k) => {
    const value = low + (k * (high - low)) / 4;
    return [value, inRadians ? asMultipleOfPi(value) : `${formatNumber(toDegrees(value))}°`];
  });
}

/** Return an angle as text: as a multiple of π/2 if it is one, else as a decimal. */
function asMultipleOfPi(angle: number): string {
  const quarterTurns = (2 * angle) / Math.PI;
  if (Math.abs(quarterTurns - Math.round(quarterTurns)) > 1e-9) return formatNumber(roundToDecimals(angle, 2));
  return ["−π", "−π/2", "0", "π/2", "π"][Math.round(quarterTurns) + 2] ?? formatNumber(roundToDecimals(angle, 2));
}

type LegendProps = { readonly stretches: readonly Stretch[]; readonly isEverywhere: boolean };

/** The kinds of lines and spots on the map; `isEverywhere`: J has lost rank on the whole map. */
function Legend({ stretches, isEverywhere }: LegendProps): JSX.Element {
  const presentKinds = (["boundary", "internal", "unknown"] as const).filter((kind) =>
    stretches.some((stretch) => stretch.kind === kind),
  );
  return (
    <ul class="arm-legend">
      {presentKinds.map((kind) => (
        <li key={kind}>
          <svg viewBox="0 0 34 12" width={34} height={12} aria-hidden="true">
            {stretches.some((stretch) => stretch.kind === kind && stretch.spots.length > 1) ? (
              <path class={`arm-zero arm-${kind}`} d="M1 6h32" />
            ) : (
              <circle class={`arm-zero-spot arm-${kind}`} cx={17} cy={6} r={4.5} />
            )}
          </svg>
          {say(`arm.map.${kind}`)}
        </li>
      ))}
      {isEverywhere && (
        <li>
          <Words text={say("arm.map.always")} />
        </li>
      )}
      {!isEverywhere && stretches.length === 0 && <li>{say("arm.map.none")}</li>}
    </ul>
  );
}
