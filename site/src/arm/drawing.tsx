// The interactive drawing: links and the point P are dragged, a spatial arm is rotated; keys do the same.

import type { ComponentChildren, JSX } from "preact";
import { memo } from "../pace.js";
import { useCallback, useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { say } from "../text/text.js";
import { Body, polylineText } from "./line-drawing.js";
import type { Covered } from "./labels.js";
import { jointClass, plainLetters, Words } from "./letters.js";
import { drawnLostDirection } from "./lost-direction.js";
import { axisLength, drawnColumns, Marks } from "./marks.js";
import { measuresOf, type State, stateAt } from "./model.js";
import { edgesOf, withFraming, framingOf, isSamePose, isInView, findReadableOrbit, reduceToShow } from "./framing.js";
import { dragLink, movePoint } from "./moves.js";
import { extentOf, limitToRange } from "./ranges.js";
import { linkOf, pointAtShare } from "./shape.js";
import type { Stage } from "./stage.js";
import { Space } from "./space.js";
import { add, addScaled, clamp, dot, subtract, type Vec3 } from "./vector.js";
import type { Orbit, Pixel, View } from "./view.js";
import { ARROWS, FIRST_ORBIT, hasModifier, keyStep, nearestOnLine, planeNormalOf, toPixel } from "./view.js";
import { vectorFromPixels, viewOf } from "./view.js";
import { drawingScale, useSize } from "./size.js";
import { classifyNearness } from "./descriptions.js";

interface DrawingProps extends Stage {
  readonly label: string;
  readonly describedBy: string;
  /** The size of the drawing in pixels if it is known beforehand: then it is drawn only once. */
  readonly knownSize?: readonly [number, number] | undefined;
  /** Whether the first pose is drawn larger until the arm moves out of sight. */
  readonly isEnlarged?: boolean;
  /** Points that must be visible in the enlarged view, besides the arm. */
  readonly extraPoints?: readonly Vec3[];
  /** Text in a corner of the drawing. */
  readonly readout?: ComponentChildren;
  /** The ends A and B of a path; B can be dragged. */
  readonly target?: { readonly start: Vec3; readonly end: Vec3; readonly move: (to: Vec3) => void } | undefined;
  readonly overlay?: ((view: View) => ComponentChildren) | undefined;
  /** The lines of the overlay at a state, which must be visible. */
  readonly overlayLinesAt?: ((state: State) => readonly (readonly Vec3[])[]) | undefined;
}

/** What the pointer drags: a link (from 0) at a share of its corners (see shape.ts), P, the path's end, or the view. */
type Drag =
  | { readonly link: number; readonly share: number }
  | "point"
  | "target"
  | { readonly startOrbit: Orbit; readonly startPixel: Pixel };

/** After the view has changed, each move multiplies the offset between pointer and dragged point by this factor. */
const OFFSET_DECAY = 0.85;

export function Drawing(props: DrawingProps): JSX.Element {
  const { arm, state, reach, layers, chosenJoint, choose, highlightedJoint, highlight, move, target } = props;
  const box = useRef<HTMLDivElement>(null);
  const [width, height] = useSize(box, props.knownSize ?? [560, 420]);
  const [orbit, setOrbit, firstOrbit] = useOrbit(props);
  const [drag, setDrag] = useState<Drag | null>(null);
  const [hasDragged, setDragged] = useState(false); // the hint is shown until the reader has dragged something
  const [isSolidReady, setSolid] = useState(false);
  const extent = useMemo(() => extentOf(arm), [arm]);
  const isFlat = useMemo(() => planeNormalOf(arm) !== null, [arm]);
  const fullView = useMemo(() => viewOf(arm, extent, width, height, orbit), [arm, extent, width, height, orbit]);
  const view = useNearView(props, fullView, orbit.zoom > 1, firstOrbit, isFlat);
  const columns = useMemo(
    () => (layers.ellipse ? drawnColumns(arm, state, reach) : null),
    [arm, state, reach, layers.ellipse],
  );
  const links = arm.joints.map((_, i) => linkOf(arm, state, i + 1));
  const [hasFocus, setFocus] = useState(false); // the hint on keys is shown while the drawing has the focus
  const isLost = drawnLostDirection(arm, state, props.measures, props.isConcealed) !== null;
  const messageKind = classifyNearness(arm, props.measures) === "singular" ? "lost" : "slow";
  const covered = useCovered(box, [
    width,
    height,
    isFlat,
    hasDragged,
    hasFocus,
    chosenJoint,
    Boolean(props.readout),
    isLost && messageKind,
  ]);

  const pixelOf = (event: PointerEvent): Pixel => {
    const corner = box.current!.getBoundingClientRect();
    const { clientLeft, clientTop } = box.current!;
    const scale = drawingScale();
    return [(event.clientX - corner.left - clientLeft) / scale, (event.clientY - corner.top - clientTop) / scale];
  };
  const startDrag = (event: PointerEvent, dragFrom: (startPixel: Pixel) => Drag): void => {
    if (event.button !== 0) return;
    event.stopPropagation();
    box.current!.setPointerCapture(event.pointerId);
    pointer.current = pixelOf(event);
    offset.current = [0, 0];
    setDrag(dragFrom(pixelOf(event)));
    setDragged(true);
  };
  const pointer = useRef<Pixel>([0, 0]);
  const offset = useRef<Pixel>([0, 0]); // from the dragged point to the pointer; nonzero after the view has changed
  const draggedPosition =
    drag === "point" ? state.point : drag === "target" ? target?.end : pointOnDraggedLink(drag, links);
  useLayoutEffect(() => {
    if (!draggedPosition) return;
    const [x, y] = toPixel(view, draggedPosition);
    offset.current = [pointer.current[0] - x, pointer.current[1] - y];
  }, [view.scale, view.centre]);
  const continueDrag = (event: PointerEvent): void => {
    if (drag === null) return;
    pointer.current = pixelOf(event);
    offset.current = [OFFSET_DECAY * offset.current[0], OFFSET_DECAY * offset.current[1]];
    const [x, y] = [pointer.current[0] - offset.current[0], pointer.current[1] - offset.current[1]];
    const stepFrom = (place: Vec3): Pixel => {
      const [px, py] = toPixel(view, place);
      return [x - px, y - py];
    };
    if (drag === "point") move(movePoint(arm, state.pose, vectorFromPixels(view, stepFrom(state.point)), view));
    else if (drag === "target") {
      if (target) target.move(add(target.end, vectorFromPixels(view, stepFrom(target.end))));
    } else if ("link" in drag) {
      const place = pointAtShare(links[drag.link]!, drag.share);
      move(dragLink(arm, state, view, drag.link, place, stepFrom(place)));
    } else setOrbit(rotateOrbit(drag.startOrbit, (drag.startPixel[0] - x) / 160, (y - drag.startPixel[1]) / 160, 1));
  };
  useEffect(() => preventScrolling(box.current!), []);
  /** Change the view by a key: rotate it, or return to the first view. */
  const changeView = useCallback(
    (key: string): void => {
      const rotation = VIEW_KEYS[key];
      setOrbit((before) => (rotation ? rotateOrbit(before, ...rotation) : firstOrbit));
    },
    [firstOrbit],
  );
  const pressKey = (event: KeyboardEvent): void => {
    const way = wayInTime(event);
    if (way) {
      props.travel(way);
      return event.preventDefault();
    }
    if (hasModifier(event)) return;
    const step = ARROWS[event.key];
    const number = Number(event.key);
    if (event.key.toLowerCase() === "p") choose(-1);
    else if (number >= 1 && number <= arm.joints.length) choose(number - 1);
    else if (event.key === "0" || (!isFlat && VIEW_KEYS[event.key])) changeView(event.key);
    else if (step && chosenJoint < 0) {
      const pixels = keyStep("P", event) * view.scale;
      move(movePoint(arm, state.pose, vectorFromPixels(view, [step[0] * pixels, step[1] * pixels])));
    } else if (step && step[0] === 0) choose((chosenJoint + step[1] + arm.joints.length) % arm.joints.length);
    else if (step) {
      const change = step[0] * keyStep(arm.joints[chosenJoint]!.kind, event);
      move(state.pose.with(chosenJoint, limitToRange(arm, chosenJoint, state.pose[chosenJoint]! + change)));
    } else return;
    event.preventDefault();
  };

  return (
    <div class="arm-drawing">
      <div
        ref={box}
        class={`arm-box${drag ? " arm-held" : ""}`}
        role="application"
        aria-roledescription={say("arm.drawing.role")}
        aria-label={props.label}
        aria-describedby={props.describedBy}
        tabIndex={0}
        onKeyDown={pressKey}
        onFocus={() => setFocus(true)}
        onBlur={() => setFocus(false)}
        onPointerDown={(event) => !isFlat && startDrag(event, (startPixel) => ({ startOrbit: orbit, startPixel }))}
        onPointerMove={continueDrag}
        onPointerUp={() => setDrag(null)}
        onPointerCancel={() => setDrag(null)}
      >
        {!isFlat && <Space arm={arm} state={state} view={view} columns={columns} onReady={setSolid} />}
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
          {(isFlat || !isSolidReady) && <Body arm={arm} state={state} view={view} reach={reach} />}
          {!isFlat && <Foot arm={arm} state={state} view={view} />}
          {layers.trace && (
            <g class="arm-trace">
              {props.trace.map((line, i) => (
                <polyline key={i} points={polylineText(view, line)} />
              ))}
            </g>
          )}
          {props.overlay?.(view)}
          <Marks
            {...props}
            {...{ view, isFlat, covered }}
            overlayLines={props.overlayLinesAt?.(state) ?? NO_LINES}
            ends={target ? { A: target.start, B: target.end } : NO_ENDS}
          />
          {links.map((line, i) => (
            <polyline
              key={i}
              class={`arm-grip${i === chosenJoint ? " arm-chosen" : ""}${i === highlightedJoint ? " arm-lit" : ""} ${jointClass(i)}`}
              points={polylineText(view, line)}
              onPointerEnter={() => drag === null && highlight(i)}
              onPointerLeave={() => highlight(null)}
              onPointerDown={(event) => {
                choose(i);
                const corners = line.map((corner) => toPixel(view, corner));
                startDrag(event, (startPixel) => ({ link: i, share: nearestOnLine(corners, startPixel).share }));
              }}
            />
          ))}
          <Point
            place={toPixel(view, state.point)}
            isChosen={chosenJoint < 0}
            onDown={(event) => {
              choose(-1);
              startDrag(event, () => "point");
            }}
          />
          {target && <Target place={toPixel(view, target.end)} onDown={(event) => startDrag(event, () => "target")} />}
        </svg>
        {!isFlat && <ViewButtons onKey={changeView} />}
      </div>
      {props.readout}
      <div class="arm-said">
        {isLost && (
          <p class="arm-lost-words">
            <Words text={say(`arm.drawing.${messageKind}`)} />
          </p>
        )}
        <p class={`arm-hint${hasDragged ? " arm-known" : ""}`}>
          <Words text={say(isFlat ? "arm.hint.drag" : "arm.hint.drag-space")} />{" "}
          <span class="arm-keys">
            {chosenJoint < 0
              ? say("arm.hint.point")
              : say("arm.hint.joint", { joint: plainLetters(arm.joints[chosenJoint]?.name ?? "") })}{" "}
            {!isFlat && say("arm.hint.space")}
          </span>
        </p>
      </div>
    </div>
  );
}

/** Return whether Ctrl+Z (Cmd+Z) is pressed, or Ctrl+Shift+Z or Ctrl+Y; else null. */
function wayInTime({ key, ctrlKey, metaKey, altKey, shiftKey }: KeyboardEvent): "undo" | "redo" | null {
  if (altKey || ctrlKey === metaKey) return null;
  const letter = key.toLowerCase();
  if (letter === "z") return shiftKey ? "redo" : "undo";
  return letter === "y" ? "redo" : null;
}

/** Return the point at which a link is dragged; null if no link is dragged. */
function pointOnDraggedLink(drag: Drag | null, links: readonly (readonly Vec3[])[]): Vec3 | null {
  return drag !== null && typeof drag === "object" && "link" in drag
    ? pointAtShare(links[drag.link]!, drag.share)
    : null;
}

/**
 * Return the view's orbit, its setter, and the first orbit. The first orbit is that of the figure, unless the arm was
 * sent to a pose that it would show end-on. An orbit that the reader has changed is kept, unless it is end-on.
 */
function useOrbit({ arm, home, isRequested }: DrawingProps): [Orbit, StateUpdater, Orbit] {
  const firstOrbit = useMemo(
    () => (isRequested && !planeNormalOf(arm) ? findReadableOrbit(arm, stateAt(arm, home), FIRST_ORBIT) : FIRST_ORBIT),
    [arm, home, isRequested],
  );
  const [orbit, setOrbit] = useState<Orbit>(firstOrbit);
  const previousFirstOrbit = useRef(firstOrbit);
  useLayoutEffect(() => {
    const isEndOn = (candidate: Orbit): boolean =>
      isRequested && findReadableOrbit(arm, stateAt(arm, home), candidate) !== candidate;
    setOrbit((currentOrbit) =>
      currentOrbit === previousFirstOrbit.current || isEndOn(currentOrbit) ? firstOrbit : currentOrbit,
    );
    previousFirstOrbit.current = firstOrbit;
  }, [firstOrbit, home]);
  return [orbit, setOrbit, firstOrbit];
}

type StateUpdater = (next: Orbit | ((now: Orbit) => Orbit)) => void;

const NO_POINTS: readonly Vec3[] = [];
/** Up to this width of the drawing (pixels), the hint on a spatial arm takes two lines. */
const MAX_WIDTH_WITH_TWO_LINES = 480;

/**
 * Return an enlarged view of the first pose as long as everything drawn stays in sight; else the view of the whole reach,
 * reduced if arrows are longer. If the reader has magnified the view (`isMagnified`), parts of it may be out of sight.
 */
function useNearView(
  props: DrawingProps,
  fullView: View,
  isMagnified: boolean,
  firstOrbit: Orbit,
  isFlat: boolean,
): View {
  const { arm, state, home, reach, layers, isConcealed, isEnlarged, target, extraPoints = NO_POINTS } = props;
  const pathEnds = target ? [target.end] : []; // the view must not follow B while B is dragged
  const [hasLeftView, setLeft] = useState(false);
  const { width, height } = fullView;
  /** Return the heads of columns and axes, the extreme points of the ellipse, and the overlay, as far as they are shown. */
  const markedPoints = (at: State, view: View): Vec3[] => {
    const axis = axisLength(view, isFlat) / view.scale;
    const axes =
      isFlat && layers.frames ? at.frames.flatMap(({ o, x, y }) => [addScaled(o, x, axis), addScaled(o, y, axis)]) : [];
    const arrows = layers.columns || layers.ellipse ? drawnColumns(arm, at, reach) : [];
    const shownArrows = [...(layers.columns ? arrows : []), ...(layers.ellipse ? edgesOf(arrows, view) : [])];
    return [...axes, ...shownArrows.map((arrow) => add(at.point, arrow)), ...(props.overlayLinesAt?.(at) ?? []).flat()];
  };
  const framing = useMemo(() => {
    if (!isEnlarged) return null;
    const firstState = stateAt(arm, home);
    const fullFirstView = viewOf(arm, extentOf(arm), width, height, firstOrbit);
    const isLost = drawnLostDirection(arm, firstState, measuresOf(arm, firstState), isConcealed) !== null;
    const visiblePoints = [...markedPoints(firstState, fullFirstView), ...pathEnds, ...extraPoints];
    const lineCount = (isLost ? 2 : 1) + (isFlat || width > MAX_WIDTH_WITH_TWO_LINES ? 0 : 1);
    return framingOf(arm, firstState, visiblePoints, fullFirstView, { isFlat, lineCount });
  }, [
    isEnlarged,
    arm,
    home,
    width,
    height,
    firstOrbit,
    layers.columns,
    layers.ellipse,
    pathEnds.length,
    extraPoints,
    isConcealed,
  ]);
  const enlargedView = useMemo(() => (framing ? withFraming(fullView, framing) : fullView), [framing, fullView]);
  const isVisible =
    isMagnified || isInView(arm, state, enlargedView, [...markedPoints(state, enlargedView), ...pathEnds]);
  const isBackInView = isSamePose(state.pose, home) && isVisible;
  const isOutOfView = !isBackInView && (hasLeftView || !isVisible);
  useEffect(() => setLeft(isOutOfView), [arm, isOutOfView]);
  if (!isOutOfView) return enlargedView;
  return isMagnified ? fullView : reduceToShow(fullView, markedPoints(state, fullView));
}

/** Return the boxes (pixels) of texts and buttons, which labels avoid; measured again only if `changes` differ. */
function useCovered(box: { readonly current: HTMLElement | null }, changes: readonly unknown[]): Covered {
  const [covered, setCovered] = useState<Covered>(NO_BOXES);
  useLayoutEffect(() => {
    const parent = box.current?.parentElement;
    if (!box.current || !parent) return;
    const { left, top } = box.current.getBoundingClientRect();
    const { clientLeft, clientTop } = box.current;
    const scale = drawingScale();
    const boxes = [...parent.querySelectorAll(OVERLAYS)]
      .map((element) => element.getBoundingClientRect())
      .filter(({ width, height }) => width > 0 && height > 0)
      .map((rect) => ({
        left: (rect.left - left - clientLeft) / scale,
        right: (rect.right - left - clientLeft) / scale,
        top: (rect.top - top - clientTop) / scale,
        bottom: (rect.bottom - top - clientTop) / scale,
      }));
    setCovered((before) => (JSON.stringify(before) === JSON.stringify(boxes) ? before : boxes));
  }, changes);
  return covered;
}

const NO_BOXES: Covered = [];
const NO_ENDS = {};
const NO_LINES: readonly (readonly Vec3[])[] = [];
/** Texts and buttons over a drawing. The hint's box is as wide as the page, so its words are measured. */
const OVERLAYS = ".arm-readout, .arm-lost-words, .arm-hint > span, .arm-view";

/** What a finger can drag. */
const GRIPS = ".arm-grip, .arm-point, .arm-target";

/** Drag by a finger without scrolling the page: browsers ignore `touch-action` inside an SVG. */
function preventScrolling(box: HTMLElement): () => void {
  const startTouch = (event: TouchEvent): void => {
    const isHeld = event.target instanceof Element && event.target.closest(GRIPS) !== null;
    if (isHeld && event.cancelable && event.touches.length < 2) event.preventDefault();
  };
  box.addEventListener("touchstart", startTouch, { passive: false });
  return () => box.removeEventListener("touchstart", startTouch);
}

/** Keys that rotate the view about the vertical, up or down, or zoom it: [azimuth, elevation, zoom factor]. */
const VIEW_KEYS: Readonly<Record<string, readonly [number, number, number]>> = {
  a: [-0.12, 0, 1],
  d: [0.12, 0, 1],
  w: [0, 0.1, 1],
  s: [0, -0.1, 1],
  "+": [0, 0, 1.12],
  "-": [0, 0, 1 / 1.12],
};

function rotateOrbit(orbit: Orbit, azimuthChange: number, elevationChange: number, zoomFactor: number): Orbit {
  return {
    azimuth: orbit.azimuth + azimuthChange,
    elevation: clamp(orbit.elevation + elevationChange, -1.5, 1.5),
    zoom: clamp(orbit.zoom * zoomFactor, 0.4, 4),
  };
}

/** Buttons that change the view: fingers scroll the page and can't rotate the arm by dragging. */
const ViewButtons = memo(({ onKey }: { readonly onKey: (key: string) => void }): JSX.Element => (
  <div
    class="arm-view"
    onPointerDown={(event) => event.stopPropagation()}
    onKeyDown={(event) => event.stopPropagation()}
  >
    {(
      [
        ["w", "↑", "arm.view.up"],
        ["s", "↓", "arm.view.down"],
        ["+", "+", "arm.view.nearer"],
        ["-", "−", "arm.view.further"],
        ["0", "⟲", "arm.view.first"],
      ] as const
    ).map(([key, sign, text]) => (
      <button key={key} type="button" aria-label={say(text)} title={say(text)} onClick={() => onKey(key)}>
        {sign}
      </button>
    ))}
  </div>
));

type GripProps = { readonly place: Pixel; readonly onDown: (event: PointerEvent) => void };

function Point({ place: [x, y], isChosen, onDown }: GripProps & { readonly isChosen: boolean }): JSX.Element {
  return (
    <g class={`arm-point${isChosen ? " arm-chosen" : ""}`} transform={`translate(${x} ${y})`} onPointerDown={onDown}>
      <circle class="arm-point-grip" r={18} />
      <circle class="arm-point-ring" r={7} />
      <circle class="arm-point-dot" r={2.8} />
    </g>
  );
}

function Target({ place: [x, y], onDown }: GripProps): JSX.Element {
  return (
    <g class="arm-target" transform={`translate(${x} ${y})`} onPointerDown={onDown}>
      <circle class="arm-point-grip" r={18} />
      <path d="M-7 0h14M0 -7v14" />
      <circle r={9} />
    </g>
  );
}

/** The line from the point down to the plane of the base, which shows the point's height. */
function Foot({ arm, state, view }: Pick<DrawingProps, "arm" | "state"> & { readonly view: View }): JSX.Element {
  const { o, z } = arm.base;
  const height = dot(subtract(state.point, o), z);
  const [px, py] = toPixel(view, state.point);
  const [fx, fy] = toPixel(view, addScaled(state.point, z, -height));
  return (
    <g class="arm-foot">
      <polyline points={`${px},${py} ${fx},${fy}`} />
      <circle transform={`translate(${fx} ${fy})`} r={2.2} />
    </g>
  );
}
