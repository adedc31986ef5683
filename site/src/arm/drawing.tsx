// The interactive drawing: links and the point P are dragged, a spatial arm is rotated; keys do the same.

import type { ComponentChildren, JSX } from "preact";
import { memo } from "../pace.js";
import { useCallback, useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { say } from "../text/text.js";
import { Body, polylineText } from "./flat.js";
import type { Covered } from "./labels.js";
import { jointClass, plainLetters } from "./letters.js";
import { drawnLostDirection } from "./lost-direction.js";
import { drawnColumns, Marks } from "./marks.js";
import { measuresOf, stateAt } from "./model.js";
import { edgesOf, withFraming, framingOf, isSamePose, isSeen, readableFrom } from "./framing.js";
import { dragLink, movePoint } from "./moves.js";
import { extentOf, within } from "./ranges.js";
import { atShare, linkOf, nearestShare } from "./shape.js";
import type { Stage } from "./stage.js";
import { Space } from "./space.js";
import { add, addScaled, dot, subtract, type Vec3 } from "./vector.js";
import {
  ARROWS,
  FIRST_ORBIT,
  flatPlane,
  vectorFromPixels,
  type Orbit,
  pixel,
  type Pixel,
  type View,
  viewOf,
} from "./view.js";
import { useSize } from "./size.js";
import { nearness } from "./descriptions.js";

interface DrawingProps extends Stage {
  readonly label: string;
  readonly describedBy: string;
  /** The size of the drawing in pixels if it is known beforehand: then it is drawn only once. */
  readonly room?: readonly [number, number] | undefined;
  /** Whether the first pose is drawn larger until the arm moves out of sight. */
  readonly isEnlarged?: boolean;
  /** Points that must be visible in the enlarged view, besides the arm. */
  readonly extraPoints?: readonly Vec3[];
  /** Text in a corner of the drawing. */
  readonly readout?: ComponentChildren;
  /** The ends A and B of a path; B can be dragged. */
  readonly target?: { readonly from: Vec3; readonly at: Vec3; readonly move: (to: Vec3) => void } | undefined;
  readonly overlay?: ((view: View) => ComponentChildren) | undefined;
}

/** What the pointer drags: a link at a share of its length, the point, the path's end, or the view. */
type Held =
  { readonly link: number; readonly share: number } | "point" | "target" | { readonly from: Orbit; readonly at: Pixel };

const DEGREE = Math.PI / 180;
/** After the view has changed, each move reduces the offset from the pointer to this fraction. */
const OFFSET_DECAY = 0.85;

export function Drawing(props: DrawingProps): JSX.Element {
  const { arm, state, reach, layers, chosen, choose, highlighted, highlight, move, target } = props;
  const box = useRef<HTMLDivElement>(null);
  const [width, height] = useSize(box, props.room ?? [560, 420]);
  const [orbit, setOrbit, firstOrbit] = useOrbit(props);
  const [held, setHeld] = useState<Held | null>(null);
  const [hasDragged, setDragged] = useState(false); // the hint is shown until the reader has dragged something
  const [solid, setSolid] = useState(false);
  const extent = useMemo(() => extentOf(arm), [arm]);
  const flat = useMemo(() => flatPlane(arm) !== null, [arm]);
  const fullView = useMemo(() => viewOf(arm, extent, width, height, orbit), [arm, extent, width, height, orbit]);
  const view = useNearView(props, fullView, firstOrbit, flat);
  const columns = useMemo(
    () => (layers.ellipse ? drawnColumns(arm, state, reach) : null),
    [arm, state, reach, layers.ellipse],
  );
  const links = arm.joints.map((_, i) => linkOf(arm, state, i + 1));
  const [hasFocus, setFocus] = useState(false); // the hint on keys is shown while the drawing has the focus
  const isLost = drawnLostDirection(arm, state, props.measures, props.isConcealed) !== null;
  const messageKind = nearness(arm, props.measures) === "singular" ? "lost" : "slow";
  const covered = useCovered(box, [
    width,
    height,
    flat,
    hasDragged,
    hasFocus,
    chosen,
    Boolean(props.readout),
    isLost && messageKind,
  ]);

  const pixelOf = (event: PointerEvent): Pixel => {
    const corner = box.current!.getBoundingClientRect();
    const { clientLeft, clientTop } = box.current!;
    return [event.clientX - corner.left - clientLeft, event.clientY - corner.top - clientTop];
  };
  const hold = (event: PointerEvent, what: (at: Pixel) => Held): void => {
    if (event.button !== 0) return;
    event.stopPropagation();
    box.current!.setPointerCapture(event.pointerId);
    pointer.current = pixelOf(event);
    offset.current = [0, 0];
    setHeld(what(pixelOf(event)));
    setDragged(true);
  };
  const pointer = useRef<Pixel>([0, 0]);
  const offset = useRef<Pixel>([0, 0]); // offset of the dragged thing from the pointer after the view has changed
  const heldPoint = held === "point" ? state.point : held === "target" ? target?.at : draggedPoint(held, links);
  useLayoutEffect(() => {
    if (!heldPoint) return;
    const [x, y] = pixel(view, heldPoint);
    offset.current = [pointer.current[0] - x, pointer.current[1] - y];
  }, [view.scale, view.centre]);
  const drag = (event: PointerEvent): void => {
    if (held === null) return;
    pointer.current = pixelOf(event);
    offset.current = [OFFSET_DECAY * offset.current[0], OFFSET_DECAY * offset.current[1]];
    const [x, y] = [pointer.current[0] - offset.current[0], pointer.current[1] - offset.current[1]];
    const from = (place: Vec3): Pixel => {
      const [px, py] = pixel(view, place);
      return [x - px, y - py];
    };
    if (held === "point") move(movePoint(arm, state.pose, vectorFromPixels(view, from(state.point)), view));
    else if (held === "target") {
      if (target) target.move(add(target.at, vectorFromPixels(view, from(target.at))));
    } else if ("link" in held) {
      const place = atShare(links[held.link]!, held.share);
      move(dragLink(arm, state, view, held.link, place, from(place)));
    } else setOrbit(rotateOrbit(held.from, (held.at[0] - x) / 160, (y - held.at[1]) / 160, 1));
  };
  useEffect(() => preventScrolling(box.current!), []);
  /** Change the view by a key: rotate it, or return to the first view. */
  const changeView = useCallback(
    (key: string): void => {
      const change = VIEW_KEYS[key];
      setOrbit((now) => (change ? rotateOrbit(now, ...change) : firstOrbit));
    },
    [firstOrbit],
  );
  const pressKey = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const factor = event.shiftKey ? 10 : 2;
    const step = ARROWS[event.key];
    const number = Number(event.key);
    if (event.key.toLowerCase() === "p") choose(-1);
    else if (number >= 1 && number <= arm.joints.length) choose(number - 1);
    else if (event.key === "0" || (!flat && VIEW_KEYS[event.key])) changeView(event.key);
    else if (step && chosen < 0) {
      const metres = factor * 0.005 * view.scale;
      move(movePoint(arm, state.pose, vectorFromPixels(view, [step[0] * metres, step[1] * metres])));
    } else if (step && step[0] === 0) choose((chosen + step[1] + arm.joints.length) % arm.joints.length);
    else if (step) {
      const by = step[0] * factor * (arm.joints[chosen]!.kind === "R" ? DEGREE : 0.005);
      move(state.pose.with(chosen, within(arm, chosen, state.pose[chosen]! + by)));
    } else return;
    event.preventDefault();
  };

  return (
    <div class="arm-drawing">
      <div
        ref={box}
        class={`arm-box${held ? " arm-held" : ""}`}
        role="application"
        aria-roledescription={say("arm.drawing.role")}
        aria-label={props.label}
        aria-describedby={props.describedBy}
        tabIndex={0}
        onKeyDown={pressKey}
        onFocus={() => setFocus(true)}
        onBlur={() => setFocus(false)}
        onPointerDown={(event) => !flat && hold(event, (at) => ({ from: orbit, at }))}
        onPointerMove={drag}
        onPointerUp={() => setHeld(null)}
        onPointerCancel={() => setHeld(null)}
      >
        {!flat && <Space arm={arm} state={state} view={view} columns={columns} onReady={setSolid} />}
        <svg viewBox={`0 0 ${width} ${height}`} width={width} height={height} aria-hidden="true">
          {(flat || !solid) && <Body arm={arm} state={state} view={view} reach={reach} />}
          {!flat && <Foot arm={arm} state={state} view={view} />}
          {props.overlay?.(view)}
          <Marks {...props} {...{ view, flat, covered }} ends={target ? { A: target.from, B: target.at } : NO_ENDS} />
          {links.map((line, i) => (
            <polyline
              key={i}
              class={`arm-grip${i === chosen ? " arm-chosen" : ""}${i === highlighted ? " arm-lit" : ""} ${jointClass(i)}`}
              points={polylineText(view, line)}
              onPointerEnter={() => held === null && highlight(i)}
              onPointerLeave={() => highlight(null)}
              onPointerDown={(event) => {
                choose(i);
                const corners = line.map((corner) => pixel(view, corner));
                hold(event, (at) => ({ link: i, share: nearestShare(corners, at) }));
              }}
            />
          ))}
          <Point
            at={pixel(view, state.point)}
            chosen={chosen < 0}
            onDown={(event) => {
              choose(-1);
              hold(event, () => "point");
            }}
          />
          {target && <Target at={pixel(view, target.at)} onDown={(event) => hold(event, () => "target")} />}
        </svg>
        {!flat && <ViewButtons onKey={changeView} />}
      </div>
      {props.readout}
      <div class="arm-said">
        {isLost && <p class="arm-lost-words">{say(`arm.drawing.${messageKind}`)}</p>}
        <p class={`arm-hint${hasDragged ? " arm-known" : ""}`}>
          <span>{say(flat ? "arm.hint.drag" : "arm.hint.drag-space")}</span>{" "}
          <span class="arm-keys">
            {chosen < 0
              ? say("arm.hint.point")
              : say("arm.hint.joint", { joint: plainLetters(arm.joints[chosen]?.name ?? "") })}{" "}
            {!flat && say("arm.hint.space")}
          </span>
        </p>
      </div>
    </div>
  );
}

/** Return the point of a link that is dragged, null if no link is. */
function draggedPoint(held: Held | null, links: readonly (readonly Vec3[])[]): Vec3 | null {
  return held !== null && typeof held === "object" && "link" in held ? atShare(links[held.link]!, held.share) : null;
}

/**
 * Return the view's orbit, its setter, and the first orbit. The first orbit is that of the figure, unless the arm was
 * sent to a pose that it would show end-on. An orbit that the reader has changed is kept, unless it is end-on.
 */
function useOrbit({ arm, home, isSent }: DrawingProps): [Orbit, StateUpdater, Orbit] {
  const firstOrbit = useMemo(
    () => (isSent && !flatPlane(arm) ? readableFrom(arm, stateAt(arm, home), FIRST_ORBIT) : FIRST_ORBIT),
    [arm, home, isSent],
  );
  const [orbit, setOrbit] = useState<Orbit>(firstOrbit);
  const before = useRef(firstOrbit);
  useLayoutEffect(() => {
    const isEndOn = (now: Orbit): boolean => isSent && readableFrom(arm, stateAt(arm, home), now) !== now;
    setOrbit((now) => (now === before.current || isEndOn(now) ? firstOrbit : now));
    before.current = firstOrbit;
  }, [firstOrbit, home]);
  return [orbit, setOrbit, firstOrbit];
}

type StateUpdater = (next: Orbit | ((now: Orbit) => Orbit)) => void;

const NO_POINTS: readonly Vec3[] = [];

/** Return the view of the whole reach, or an enlarged view of the first pose as long as the arm stays in sight. */
function useNearView(props: DrawingProps, fullView: View, firstOrbit: Orbit, flat: boolean): View {
  const { arm, state, home, reach, layers, isConcealed, isEnlarged, target, extraPoints = NO_POINTS } = props;
  const pathEnds = target ? [target.at] : []; // the view must not follow B while B is dragged
  const [hasLeft, setLeft] = useState(false);
  const { width, height } = fullView;
  const framing = useMemo(() => {
    if (!isEnlarged) return null;
    const first = stateAt(arm, home);
    const page = viewOf(arm, extentOf(arm), width, height, firstOrbit);
    const arrows = layers.columns || layers.ellipse ? drawnColumns(arm, first, reach) : [];
    const shownArrows = [...(layers.columns ? arrows : []), ...(layers.ellipse ? edgesOf(arrows, page) : [])];
    const heads = shownArrows.map((arrow) => add(first.point, arrow));
    const isLost = drawnLostDirection(arm, first, measuresOf(first), isConcealed) !== null;
    const visible = [...heads, ...pathEnds, ...extraPoints];
    return framingOf(arm, first, visible, page, { flat, lines: isLost ? 2 : 1 });
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
  const nearer = useMemo(() => (framing ? withFraming(fullView, framing) : fullView), [framing, fullView]);
  const isBack = isSamePose(state.pose, home) && isSeen(arm, state, nearer, pathEnds);
  const isOut = !isBack && (hasLeft || !isSeen(arm, state, nearer, pathEnds));
  useEffect(() => setLeft(isOut), [arm, isOut]);
  return isOut ? fullView : nearer;
}

/** Return the boxes (pixels) of texts and buttons, which labels avoid; measured again only if `changes` differ. */
function useCovered(box: { readonly current: HTMLElement | null }, changes: readonly unknown[]): Covered {
  const [covered, setCovered] = useState<Covered>(NO_BOXES);
  useLayoutEffect(() => {
    const parent = box.current?.parentElement;
    if (!box.current || !parent) return;
    const { left, top } = box.current.getBoundingClientRect();
    const { clientLeft, clientTop } = box.current;
    const boxes = [...parent.querySelectorAll(OVERLAYS)]
      .map((element) => element.getBoundingClientRect())
      .filter(({ width, height }) => width > 0 && height > 0)
      .map((rect) => ({
        left: rect.left - left - clientLeft,
        right: rect.right - left - clientLeft,
        top: rect.top - top - clientTop,
        bottom: rect.bottom - top - clientTop,
      }));
    setCovered((before) => (JSON.stringify(before) === JSON.stringify(boxes) ? before : boxes));
  }, changes);
  return covered;
}

const NO_BOXES: Covered = [];
const NO_ENDS = {};
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

function rotateOrbit(orbit: Orbit, about: number, up: number, nearer: number): Orbit {
  return {
    azimuth: orbit.azimuth + about,
    elevation: Math.max(-1.5, Math.min(1.5, orbit.elevation + up)),
    zoom: Math.max(0.4, Math.min(4, orbit.zoom * nearer)),
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

type Grip = { readonly at: Pixel; readonly onDown: (event: PointerEvent) => void };

function Point({ at: [x, y], chosen, onDown }: Grip & { readonly chosen: boolean }): JSX.Element {
  return (
    <g class={`arm-point${chosen ? " arm-chosen" : ""}`} transform={`translate(${x} ${y})`} onPointerDown={onDown}>
      <circle class="arm-point-grip" r={18} />
      <circle class="arm-point-ring" r={7} />
      <circle class="arm-point-dot" r={2.8} />
    </g>
  );
}

function Target({ at: [x, y], onDown }: Grip): JSX.Element {
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
  const [px, py] = pixel(view, state.point);
  const [fx, fy] = pixel(view, addScaled(state.point, z, -height));
  return (
    <g class="arm-foot">
      <polyline points={`${px},${py} ${fx},${fy}`} />
      <circle transform={`translate(${fx} ${fy})`} r={2.2} />
    </g>
  );
}
