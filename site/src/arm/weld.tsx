// The chapter's welding task: P follows a straight line at constant speed, and the joints must keep their limits.

import type { ComponentChildren, JSX } from "preact";
import { startAnimation } from "../pace.js";
import { useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import { prefersReducedMotion } from "../scheduling.js";
import { say } from "../text/text.js";
import { Chart } from "./chart.js";
import { Dotted, jointClass, Letters, plainLetters, Words } from "./letters.js";
import { type Arm, type Pose } from "./model.js";
import { limitCrossings, follow, type Journey, pathTo, pointOn, stationOn, suggestTarget } from "./path.js";
import { roundToDecimals, roundToDigits } from "./number-format.js";
import type { Stage, Welding as Welded } from "./stage.js";
import { clamp, type Vec3 } from "./vector.js";
import { toPixel, type Pixel, type View } from "./view.js";

/** A weld from the pose at A to point B, its speed (m/s), and limits of revolute (rad/s) and prismatic joints (m/s). */
export interface Weld {
  readonly startPose: Pose;
  readonly target: Vec3;
  readonly speed: number;
  readonly revoluteLimit: number;
  readonly prismaticLimit: number;
}

export function firstWeld(arm: Arm, pose: Pose, reach: number): Weld {
  return {
    startPose: pose,
    target: suggestTarget(arm, pose, reach, false),
    speed: 0.1,
    revoluteLimit: 0.6,
    prismaticLimit: 0.3,
  };
}

function limitsOf(arm: Arm, { revoluteLimit, prismaticLimit }: Weld): number[] {
  return arm.joints.map(({ kind }) => (kind === "R" ? revoluteLimit : prismaticLimit));
}

type WeldProps = Pick<Stage, "arm" | "pose" | "reach"> & NonNullable<Stage["welding"]>;

const STEP_COUNT = 20;
/** The parts below the path's slider, shown one at a time, so that they stay in view with the arm. */
const TABS = ["chart", "rates", "setup"] as const;

/** The numeric fields besides the coordinates of B; the limits are those of the absolute value of a rate. */
const FIELDS = [
  { name: "speed", text: "arm.weld.speed", letter: "v", unit: "m/s", step: 0.01, min: 0.01, max: 2 },
  { name: "revoluteLimit", text: "arm.weld.turns", letter: "θ", unit: "rad/s", step: 0.1, min: 0.1, max: 20 },
  { name: "prismaticLimit", text: "arm.weld.slides", letter: "d", unit: "m/s", step: 0.05, min: 0.05, max: 10 },
] as const;

export function Welding(props: WeldProps): JSX.Element {
  const { arm, weld, journey, place, changeWeld, goTo } = props;
  const movesStepwise = prefersReducedMotion();
  const end = journey.stations.at(-1)!.s;
  const [isPlaying, setPlaying] = useClock(place, end, weld.speed, goTo);
  const limits = limitsOf(arm, weld);
  const station = useMemo(() => stationOn(journey, place), [journey, place]);
  const rates = station.slopes.map((slope) => slope * weld.speed);
  const placeText = say("arm.weld.at", { s: roundToDecimals(place, 3), time: roundToDecimals(place / weld.speed, 2) });
  const [tab, setPart] = useState<(typeof TABS)[number]>("chart");
  const changeSettings = (changes: Partial<Weld>): void => {
    setPlaying(false);
    changeWeld({ ...weld, ...changes });
  };
  const stepForward = (): void =>
    goTo(place >= end - 1e-9 ? 0 : Math.min(end, place + journey.path.length / STEP_COUNT));
  const play = (): void => {
    if (place >= end - 1e-9) goTo(0);
    setPlaying(!isPlaying);
  };
  return (
    <section class="arm-weld" data-part={tab} aria-label={say("arm.weld.title")}>
      <div class="arm-play">
        <button type="button" class="arm-main" disabled={end <= 0} onClick={movesStepwise ? stepForward : play}>
          {say(movesStepwise ? "arm.weld.step" : isPlaying ? "arm.weld.pause" : "arm.weld.play")}
        </button>
        <input
          type="range"
          min={0}
          max={end}
          step={end / 200 || 1}
          value={place}
          aria-label={say("arm.weld.place")}
          aria-valuetext={placeText}
          onInput={(event) => {
            setPlaying(false);
            goTo(Number(event.currentTarget.value));
          }}
        />
        <output>{placeText}</output>
      </div>
      <div class="arm-parts" role="group" aria-label={say("arm.weld.parts")}>
        {TABS.map((name) => (
          <button key={name} type="button" aria-pressed={tab === name} onClick={() => setPart(name)}>
            {say(`arm.weld.part-${name}`)}
          </button>
        ))}
      </div>
      <div class="arm-part">
        {tab === "chart" ? (
          <Chart arm={arm} journey={journey} speed={weld.speed} limits={limits} time={place / weld.speed} />
        ) : null}
        {tab === "rates" ? <Rates arm={arm} rates={rates} limits={limits} /> : null}
        {tab === "setup" ? <SetUp {...props} onSet={changeSettings} /> : null}
      </div>
      <p class="arm-verdict" role="status">
        <Words text={describeJourney(arm, journey, weld)} />
      </p>
    </section>
  );
}

/** The joint rates at the arm's place on the path, and which of them exceed their limits. */
function Rates(props: Pick<WeldProps, "arm"> & Readonly<Record<"rates" | "limits", readonly number[]>>): JSX.Element {
  const { arm, rates, limits } = props;
  return (
    <table class="arm-rates">
      <caption>{say("arm.weld.rates")}</caption>
      <tbody>
        {arm.joints.map(({ kind, name }, i) => {
          const rate = rates[i]!;
          const exceeds = Math.abs(rate) > limits[i]!;
          return (
            <tr key={name} class={exceeds ? "arm-over" : ""}>
              <th scope="row" class={jointClass(i)}>
                <Letters name={name} hasDot />
              </th>
              <td>{say(kind === "R" ? "arm.weld.rate-turn" : "arm.weld.rate-slide", { rate: roundToDigits(rate) })}</td>
              <td>
                {say(exceeds ? "arm.weld.over" : "arm.weld.within", {
                  percent: Math.round((100 * Math.abs(rate)) / limits[i]!),
                })}
              </td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

/** Where the path begins and ends, the speed of P, and the limits of the joints. */
function SetUp(props: WeldProps & { readonly onSet: (changes: Partial<Weld>) => void }): JSX.Element {
  const { arm, pose, reach, weld, onSet } = props;
  const suggest = (isRegular: boolean) => (): void =>
    onSet({ startPose: pose, target: suggestTarget(arm, pose, reach, isRegular) });
  const startButtons = [
    ["arm.weld.here", () => onSet({ startPose: pose })],
    ["arm.weld.regular", suggest(true)],
    ["arm.weld.singular", suggest(false)],
  ] as const;
  const axes = arm.task.filter((row) => row < 3);
  const hasPrismatic = arm.joints.some(({ kind }) => kind === "P");
  return (
    <>
      <div class="arm-row">
        {startButtons.map(([text, start]) => (
          <button key={text} type="button" onClick={start}>
            {say(text)}
          </button>
        ))}
      </div>
      <div class="arm-row">
        {axes.map((row) => (
          <Field
            key={row}
            letters={`B${"xyz"[row]}`}
            name={say("arm.weld.target", { axis: "xyz"[row]! })}
            unit="m"
            value={weld.target[row]!}
            step={0.01}
            onSet={(value) =>
              onSet({ target: weld.target.map((old, k) => (k === row ? value : old)) as unknown as Vec3 })
            }
          />
        ))}
        {FIELDS.filter(({ name }) => name !== "prismaticLimit" || hasPrismatic).map(
          ({ name, text, letter, ...field }) => (
            <Field
              key={name}
              {...field}
              letters={
                name === "speed" ? (
                  letter
                ) : (
                  <>
                    |<Dotted letter={letter} />|
                  </>
                )
              }
              name={say(text)}
              value={weld[name]}
              onSet={(value) => onSet({ [name]: value })}
            />
          ),
        )}
      </div>
      <p class="arm-hint">
        <Words text={say("arm.weld.task")} />
      </p>
    </>
  );
}

interface FieldProps {
  /** What is shown before the field, and the field's name for screen readers. */
  readonly letters: ComponentChildren;
  readonly name: string;
  readonly unit: string;
  readonly value: number;
  readonly step: number;
  readonly min?: number;
  readonly max?: number;
  readonly onSet: (value: number) => void;
}

/** A numeric field with its letter and unit. */
function Field({ letters, name, unit, value, step, min = -20, max = 20, onSet }: FieldProps): JSX.Element {
  return (
    <label class="arm-field">
      <span aria-hidden="true">
        <i>{letters}</i>
      </span>
      <input
        type="number"
        aria-label={name}
        title={name}
        value={roundToDecimals(value, 3)}
        step={step}
        min={min}
        max={max}
        onChange={(event) => {
          const next = event.currentTarget.valueAsNumber;
          if (Number.isFinite(next)) onSet(clamp(next, min, max));
        }}
      />
      <span class="arm-unit" aria-hidden="true">
        {unit}
      </span>
    </label>
  );
}

/** Return whether a path stops short, a joint exceeds its limit, or all joints keep theirs; null without a path. */
export function classifyJourney(
  arm: Arm,
  welding: Pick<Welded, "weld" | "journey"> | null,
): "stops" | "exceeds" | "keeps" | null {
  if (!welding || welding.journey.path.length === 0) return null;
  const { weld, journey } = welding;
  if (limitCrossings(journey, weld.speed, limitsOf(arm, weld)).some((s) => s !== null)) return "exceeds";
  return journey.reachesEnd ? "keeps" : "stops";
}

/** Up to this many joints that exceed their limits are listed; of more, only the first. */
const MAX_LISTED = 2;

/** Return how the journey goes, in sentences: whether it arrives, and which joints exceed their limits from where. */
function describeJourney(arm: Arm, journey: Journey, weld: Weld): string {
  const limits = limitsOf(arm, weld);
  const end = journey.stations.at(-1)!.s;
  const sentences = [
    journey.path.length === 0
      ? say("arm.weld.no-way")
      : journey.reachesEnd
        ? say("arm.weld.arrives", { length: roundToDecimals(end, 3), time: roundToDecimals(end / weld.speed, 1) })
        : say("arm.weld.stops", { s: roundToDecimals(end, 3), length: roundToDecimals(journey.path.length, 3) }),
  ];
  const exceeding = limitCrossings(journey, weld.speed, limits)
    .flatMap((s, i) => (s === null ? [] : [{ s, i }]))
    .sort((a, b) => a.s - b.s);
  const joint = (i: number): string => plainLetters(arm.joints[i]!.name);
  if (exceeding.length > MAX_LISTED) {
    const { s, i } = exceeding[0]!;
    sentences.push(say("arm.weld.exceed", { count: exceeding.length, joint: joint(i), s: roundToDecimals(s, 3) }));
  } else
    for (const { s, i } of exceeding) {
      const values = { joint: joint(i), s: roundToDecimals(s, 3), limit: limits[i]! };
      sentences.push(say(arm.joints[i]!.kind === "R" ? "arm.weld.exceeds-turn" : "arm.weld.exceeds-slide", values));
    }
  if (sentences.length === 1 && journey.path.length > 0) sentences.push(say("arm.weld.keeps"));
  return sentences.join(" ");
}

type Clock = [isPlaying: boolean, setPlaying: (on: boolean) => void];

/** Run a clock along the path, frame by frame, until its end; return whether it runs, and a setter. */
function useClock(place: number, end: number, speed: number, onPlace: (s: number) => void): Clock {
  const [isPlaying, setPlaying] = useState(false);
  const currentPlace = useRef(place);
  currentPlace.current = place;
  // Before the next frame, so that the motion stops at once when it is paused.
  useLayoutEffect(() => {
    if (!isPlaying) return;
    let lastTime = performance.now();
    let request = requestAnimationFrame(function tick(time) {
      const s = Math.min(end, currentPlace.current + (Math.max(0, time - lastTime) / 1000) * speed);
      lastTime = time;
      onPlace(s);
      if (s >= end) setPlaying(false);
      else request = requestAnimationFrame(tick);
    });
    const endAnimation = startAnimation();
    return () => {
      cancelAnimationFrame(request);
      endAnimation();
    };
  }, [isPlaying, end, speed]);
  return [isPlaying, setPlaying];
}

export const journeyOf = (arm: Arm, weld: Weld): Journey =>
  follow(arm, weld.startPose, pathTo(arm, weld.startPose, weld.target));

/** The path in the drawing: the part that the arm can follow, and the rest. */
export function Route({ journey, view, place }: { journey: Journey; view: View; place: number }): JSX.Element {
  const { path, stations } = journey;
  const ends = [0, stations.at(-1)!.s, path.length].map((s) => toPixel(view, pointOn(path, s)));
  const [[ax, ay], [ex, ey], [bx, by]] = ends as [Pixel, Pixel, Pixel];
  const [px, py] = toPixel(view, pointOn(path, place));
  return (
    <g class="arm-path">
      <path class="arm-path-rest" d={`M${ex} ${ey}L${bx} ${by}`} />
      <path class="arm-path-way" d={`M${ax} ${ay}L${ex} ${ey}`} />
      <path class="arm-path-done" d={`M${ax} ${ay}L${px} ${py}`} />
      <circle cx={ax} cy={ay} r={3.4} />
    </g>
  );
}
