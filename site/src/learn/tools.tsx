// The controls of a lesson: sliders for joint rates or for a direction of P, and the resulting arrows in the drawing.

import type { JSX } from "preact";

import { Arrow } from "../arm/line-drawing.js";
import { jointClass, Letters, plainLetters } from "../arm/letters.js";
import { speedScale } from "../arm/marks.js";
import { type Arm, arrowsOf, type State } from "../arm/model.js";
import { roundToDecimals } from "../arm/number-format.js";
import type { Stage } from "../arm/stage.js";
import { leastSquares } from "../arm/svd.js";
import { add, clamp, scaleVector, type Vec3, ZERO } from "../arm/vector.js";
import type { View } from "../arm/view.js";
import { formatNumber, say } from "../text/text.js";

/** Which sliders a lesson has: for joint rates, or for the wanted direction of P. */
export type Tool = "rates" | "wanted";

/** The values of the sliders: joint rates (rad/s), and a direction on the page (degrees). */
type Dials = { readonly rates: readonly number[]; readonly direction: number };

export const FIRST_DIALS: Dials = { rates: [0.5, 0.5], direction: 0 };

/** The wanted speed of P (m/s). */
const WANTED_SPEED = 0.5;
/** The damping of the least squares problem (m), which bounds the joint rates at a singularity. */
const DAMPING = 1e-6;

/** Return the joint rates (rad/s) that a tool sets: those of the sliders, or those that move P as wanted. None: []. */
export function computeRates(tool: Tool | null, dials: Dials, { taskJacobian }: State): readonly number[] {
  if (tool === "rates") return dials.rates;
  if (tool !== "wanted") return [];
  const angle = (dials.direction * Math.PI) / 180;
  return leastSquares(taskJacobian, [WANTED_SPEED * Math.cos(angle), WANTED_SPEED * Math.sin(angle)], DAMPING);
}

/** Return the velocity of P (m/s) at given joint rates. */
export function computeVelocity(arm: Arm, state: State, rates: readonly number[]): Vec3 {
  return arrowsOf(arm, state).columns.reduce((sum, column, i) => add(sum, scaleVector(column, rates[i] ?? 0)), ZERO);
}

/** Larger rates (rad/s), as near a singularity, are drawn like this one. */
const MAX_RATE = 1e3;
/** Velocities are drawn longer than columns of J by this factor, because the rates are small. */
const ARROW_SCALE = 2;

type ContributionsProps = { readonly stage: Stage; readonly view: View; readonly rates: readonly number[] };

/** The contribution of each joint to the velocity of P, head to tail, and their sum. */
export function Contributions({ stage, view, rates }: ContributionsProps): JSX.Element {
  const { arm, state } = stage;
  const scale = ARROW_SCALE * speedScale(arm);
  const contributions = arrowsOf(arm, state).columns.map((column, i) =>
    scaleVector(column, scale * clamp(rates[i] ?? 0, -MAX_RATE, MAX_RATE)),
  );
  let end = state.point;
  return (
    <g class="arm-shares">
      {contributions.map((contribution, i) => {
        const start = end;
        end = add(end, contribution);
        return (
          <Arrow key={i} view={view} start={start} vector={contribution} className={`arm-share ${jointClass(i)}`} />
        );
      })}
      <Arrow
        view={view}
        start={state.point}
        vector={scaleVector(computeVelocity(arm, state, rates), scale)}
        className="arm-sum"
      />
    </g>
  );
}

/** Format a number with two decimals. */
const formatRounded = (value: number): string => formatNumber(roundToDecimals(value, 2));

interface DialsProps {
  readonly tool: Tool;
  readonly arm: Arm;
  readonly dials: Dials;
  /** The joint rates that the tool sets (rad/s), and the resulting velocity of P (m/s). */
  readonly rates: readonly number[];
  readonly velocity: Vec3;
  readonly onDials: (dials: Dials) => void;
}

/** The sliders of a tool, and the resulting numbers. */
export function DialBoard({ tool, arm, dials, rates, velocity, onDials }: DialsProps): JSX.Element {
  const [vx, vy] = velocity.map((value) => formatRounded(value)) as [string, string, string];
  return (
    <div class="dials">
      {tool === "rates" ? (
        arm.joints.map(({ name }, i) => (
          <label key={name} class={`dial ${jointClass(i)}`}>
            <Letters name={name} hasDot />
            <input
              type="range"
              min={-1}
              max={1}
              step={0.05}
              value={dials.rates[i] ?? 0}
              aria-label={say("lesson.rate-of", { joint: plainLetters(name) })}
              onInput={(event) => {
                const value = Number(event.currentTarget.value);
                onDials({ ...dials, rates: dials.rates.with(i, value) });
              }}
            />
            <output>{formatRounded(dials.rates[i] ?? 0)} rad/s</output>
          </label>
        ))
      ) : (
        <label class="dial">
          <i>v</i>
          <input
            type="range"
            min={-180}
            max={180}
            step={5}
            value={dials.direction}
            aria-label={say("lesson.direction")}
            onInput={(event) => onDials({ ...dials, direction: Number(event.currentTarget.value) })}
          />
          <output>{formatRounded(dials.direction)}°</output>
        </label>
      )}
      <p class="muted">
        {tool === "rates"
          ? say("lesson.velocity", { vx, vy })
          : say("lesson.rates-due", { first: formatRounded(rates[0] ?? 0), second: formatRounded(rates[1] ?? 0) })}
      </p>
    </div>
  );
}
