// The map of det J over two joints, on which one walks: the arm follows, and the singular set is its zero line.

import type { JSX } from "preact";
import { memo } from "../memo.js";
import { paced } from "../pace.js";
import { useCallback, useContext, useEffect, useMemo, useRef, useState } from "preact/hooks";

import { inDigits, say } from "../text/text.js";
import { plainLetters } from "./letters.js";
import type { Arm } from "./model.js";
import type { Stage } from "./stage.js";
import { rangeOf, within } from "./ranges.js";
import { useRested } from "../later.js";
import { useSize } from "./size.js";
import { onSchemeChange } from "./space.js";
import { degrees, decimals, digits, InRadians } from "./speech.js";
import { type Pair, poseAtSpot, type Shown, telling } from "./terrain.js";
import { shade } from "./shade.js";
import { sizeName } from "./words.js";
import { useMap } from "./worked.js";
import type { Spot, Stretch } from "./zeros.js";
import { ARROWS } from "./view.js";

const [LEFT, BOTTOM, EDGE] = [44, 34, 18];
const NONE: readonly Stretch[] = [];

export function SingularMap(props: Pick<Stage, "arm" | "pose" | "measures" | "move">): JSX.Element {
  const { arm, pose, measures, move } = props;
  const radians = useContext(InRadians);
  const [pair, setPair] = useState<Pair>(() => telling(arm));
  const [shown, setShown] = useState<Shown>("det");
  const frame = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [held, setHeld] = useState(false);
  const [width, height] = useSize(frame, [420, 380]);

  useEffect(() => setPair(telling(arm)), [arm]);
  const pickAcross = useCallback((joint: number) => setPair((now) => withoutTwins([joint, now[1]], now)), []);
  const pickUp = useCallback((joint: number) => setPair((now) => withoutTwins([now[0], joint], now)), []);

  // Only the joints that are not on the map change it.
  const rest = pose.map((value, i) => (pair.includes(i) ? 0 : value));
  const key = rest.map((value) => value.toFixed(4)).join(" ");
  const settled = useRested(key, 120);
  const worked = useMap(arm, rest, pair, shown, settled);
  const terrain = worked?.terrain ?? null;
  const kinds = worked?.kinds ?? NONE;

  const [across, up] = [rangeOf(arm, pair[0]), rangeOf(arm, pair[1])];
  const [w, h] = [width - LEFT - EDGE, height - BOTTOM - EDGE];
  const px = ([u, v]: Spot): Spot => [
    LEFT + ((u - across.low) / (across.high - across.low)) * w,
    EDGE + h - ((v - up.low) / (up.high - up.low)) * h,
  ];
  const here: Spot = [pose[pair[0]]!, pose[pair[1]]!];
  const go = ([u, v]: Spot): void => move(poseAtSpot(pose, pair, [within(arm, pair[0], u), within(arm, pair[1], v)]));
  const pointed = (event: PointerEvent): void => {
    const corner = frame.current!.getBoundingClientRect();
    const [x, y] = [event.clientX - corner.left, event.clientY - corner.top];
    const share = (value: number): number => Math.max(0, Math.min(1, value));
    const there: Spot = [
      across.low + share((x - LEFT) / w) * (across.high - across.low),
      up.low + share((EDGE + h - y) / h) * (up.high - up.low),
    ];
    go(caught(there, kinds, [w / (across.high - across.low), h / (up.high - up.low)]) ?? there);
  };
  const pressed = (event: KeyboardEvent): void => {
    const step = ARROWS[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
    const by = event.shiftKey ? 10 : 2;
    const size = (joint: number): number => (arm.joints[joint]!.kind === "R" ? Math.PI / 180 : 0.005) * by;
    go([here[0] + step[0] * size(pair[0]), here[1] - step[1] * size(pair[1])]);
    event.preventDefault();
  };

  useEffect(() => {
    if (!terrain) return;
    const paint = (): void => shade(canvas.current, terrain, shown === "det" && measures.det !== null);
    paint();
    return onSchemeChange(paint);
  }, [terrain]);

  // What stays while one walks is not put together anew with every step: a line has hundreds of spots.
  const place = [across.low, across.high, up.low, up.high, w, h];
  const lines = useMemo(() => <Lines kinds={kinds} px={px} corner={[LEFT, EDGE]} size={[w, h]} />, [kinds, ...place]);
  const ticks = useMemo(
    () => (
      <>
        {ticksOf(arm, pair[0], radians).map(([value, text]) => (
          <g key={text} class="arm-tick">
            <path d={`M${px([value, up.low])[0]} ${EDGE + h}v4`} />
            <text x={px([value, up.low])[0]} y={EDGE + h + 16}>
              {text}
            </text>
          </g>
        ))}
        {ticksOf(arm, pair[1], radians).map(([value, text]) => (
          <g key={text} class="arm-tick arm-tick-left">
            <path d={`M${LEFT} ${px([across.low, value])[1]}h-4`} />
            <text x={LEFT - 7} y={px([across.low, value])[1] + 4}>
              {text}
            </text>
          </g>
        ))}
      </>
    ),
    [arm, pair, radians, ...place],
  );
  const legend = useMemo(() => (terrain ? <Legend kinds={kinds} lost={terrain.most === 0} /> : null), [terrain, kinds]);
  const [x, y] = px(here);
  const name = shown === "least" ? say("arm.map.least") : say(sizeName(arm));
  const joints = pair.map((joint) => plainLetters(arm.joints[joint]!.name));
  return (
    <section class="arm-map" aria-label={say("arm.map.title")}>
      <div class="arm-row">
        <Axis arm={arm} label={say("arm.map.across")} value={pair[0]} onPick={pickAcross} />
        <Axis arm={arm} label={say("arm.map.up")} value={pair[1]} onPick={pickUp} />
        <label>
          <span class="arm-unseen">{say("arm.map.shown")}</span>
          <select value={shown} onChange={(event) => setShown(event.currentTarget.value as Shown)}>
            <option value="det">{say(sizeName(arm))}</option>
            <option value="least">{say("arm.map.least")}</option>
          </select>
        </label>
      </div>
      <div
        ref={frame}
        class="arm-map-frame"
        role="application"
        aria-roledescription={say("arm.map.role")}
        aria-label={say("arm.map.label", { value: name, across: joints[0]!, up: joints[1]! })}
        tabIndex={0}
        onKeyDown={pressed}
        onPointerDown={(event) => {
          if (event.button !== 0) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          setHeld(true);
          pointed(event);
        }}
        onPointerMove={(event) => held && pointed(event)}
        onPointerUp={() => setHeld(false)}
        onPointerCancel={() => setHeld(false)}
      >
        <canvas ref={canvas} class="arm-map-canvas" aria-hidden="true" hidden={!terrain} />
        <svg viewBox={`0 0 ${width} ${height}`} width={width} height={height} aria-hidden="true">
          <rect class="arm-map-edge" x={LEFT} y={EDGE} width={w} height={h} />
          {lines}
          {ticks}
          <path class="arm-cross" d={`M${LEFT} ${y}h${w}M${x} ${EDGE}v${h}`} />
          <g transform={`translate(${x} ${y})`}>
            <circle class="arm-here-halo" r={8} />
            <circle class="arm-here" r={5} />
          </g>
        </svg>
      </div>
      {legend ?? (
        <ul class="arm-legend">
          <li>{say("practice.loading")}</li>
        </ul>
      )}
      <Here value={name} number={digits(shown === "least" ? measures.least : (measures.det ?? measures.volume))} />
    </section>
  );
}

/** What is shown, in numbers, of the place where one is. */
const Here = paced(
  (here: { value: string; number: number }): JSX.Element => (
    <p class="arm-hint">
      {say("arm.map.here", here)} <span class="arm-how">{say("arm.map.hint")}</span>
    </p>
  ),
  { value: "at once", number: "in turn" },
);

type LinesProps = { kinds: readonly Stretch[]; px: (spot: Spot) => Spot; corner: Spot; size: Spot };

/** The singular set: lines, and spots where it is no more than that. */
function Lines({ kinds, px, corner, size }: LinesProps): JSX.Element {
  const crowded = kinds.length > 16; // spots that make up a line
  return (
    <svg
      class="arm-map-inner"
      x={corner[0]}
      y={corner[1]}
      width={size[0]}
      height={size[1]}
      viewBox={[...corner, ...size].join(" ")}
    >
      {kinds.map(({ kind, spots }, i) =>
        spots.length > 1 ? (
          <polyline
            key={i}
            class={`arm-zero arm-${kind}`}
            points={spots
              .map((spot) =>
                px(spot)
                  .map((value) => value.toFixed(1))
                  .join(","),
              )
              .join(" ")}
          />
        ) : (
          <circle
            key={i}
            class={`arm-zero-spot arm-${kind}`}
            cx={px(spots[0]!)[0]}
            cy={px(spots[0]!)[1]}
            r={crowded ? 2.2 : 4.5}
          />
        ),
      )}
    </svg>
  );
}

/** Pixels within which a line holds who walks near it: a hand could not stop on it otherwise. */
const CATCH = 4;

/** The place on a line or spot of the map next to where one is; null where none is near. */
function caught([u, v]: Spot, kinds: readonly Stretch[], [du, dv]: Spot): Spot | null {
  let best: Spot | null = null;
  let least = CATCH;
  for (const { spots } of kinds) {
    spots.forEach((a, k) => {
      const b = spots[k + 1] ?? a;
      const [x, y, px, py] = [(b[0] - a[0]) * du, (b[1] - a[1]) * dv, (u - a[0]) * du, (v - a[1]) * dv];
      const t = Math.max(0, Math.min(1, (px * x + py * y) / (x * x + y * y || 1)));
      const away = Math.hypot(px - t * x, py - t * y);
      if (away < least) [best, least] = [[a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])], away];
    });
  }
  return best;
}

/** Both axes with the same joint make no map: the other axis then takes the joint that was given up. */
const withoutTwins = (next: Pair, before: Pair): Pair => (next[0] === next[1] ? [before[1], before[0]] : next);

interface AxisProps {
  readonly arm: Arm;
  readonly label: string;
  readonly value: number;
  readonly onPick: (joint: number) => void;
}

const Axis = memo(({ arm, label, value, onPick }: AxisProps): JSX.Element => (
  <label>
    {label}{" "}
    <select value={value} onChange={(event) => onPick(Number(event.currentTarget.value))}>
      {arm.joints.map(({ name }, i) => (
        <option key={name} value={i}>
          {plainLetters(name)}
        </option>
      ))}
    </select>
  </label>
));

/** Where an axis is marked: every quarter turn, or five places along a slide. */
function ticksOf(arm: Arm, joint: number, radians: boolean): (readonly [number, string])[] {
  const { low, high } = rangeOf(arm, joint);
  const turns = arm.joints[joint]!.kind === "R";
  return [0, 1, 2, 3, 4].map((k) => {
    const value = low + (k * (high - low)) / 4;
    if (turns && radians) return [value, inParts(value)];
    const number = turns ? degrees(value) : decimals(value, 2);
    return [value, `${inDigits(number)}${turns ? "°" : ""}`];
  });
}

/** An angle as a half or whole multiple of π where it is one. */
function inParts(angle: number): string {
  const halves = (2 * angle) / Math.PI;
  if (Math.abs(halves - Math.round(halves)) > 1e-9) return inDigits(decimals(angle, 2));
  return ["−π", "−π/2", "0", "π/2", "π"][Math.round(halves) + 2] ?? inDigits(decimals(angle, 2));
}

function Legend({ kinds, lost }: { kinds: readonly Stretch[]; lost: boolean }): JSX.Element {
  const found = (["boundary", "internal", "unknown"] as const).filter((kind) => kinds.some((one) => one.kind === kind));
  return (
    <ul class="arm-legend">
      {found.map((kind) => (
        <li key={kind}>
          <svg viewBox="0 0 34 12" width={34} height={12} aria-hidden="true">
            {kinds.some((one) => one.kind === kind && one.spots.length > 1) ? (
              <path class={`arm-zero arm-${kind}`} d="M1 6h32" />
            ) : (
              <circle class={`arm-zero-spot arm-${kind}`} cx={17} cy={6} r={4.5} />
            )}
          </svg>
          {say(`arm.map.${kind}`)}
        </li>
      ))}
      {lost && <li>{say("arm.map.always")}</li>}
      {!lost && kinds.length === 0 && <li>{say("arm.map.none")}</li>}
    </ul>
  );
}
