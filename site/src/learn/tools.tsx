// The controls of a lesson: sliders for joint rates, for a direction of P or for a force at P, and the resulting arrows.

import type { JSX } from "preact";

import { Arrow } from "../arm/line-drawing.js";
import { jointClass, Letters, plainLetters, Words } from "../arm/letters.js";
import { drawnColumns, speedScale } from "../arm/marks.js";
import { type Arm, arrowsOf, type State } from "../arm/model.js";
import { roundToDecimals } from "../arm/number-format.js";
import type { Stage } from "../arm/stage.js";
import { leastSquares } from "../arm/svd.js";
import { add, addScaled, clamp, cross, norm, scaleVector, subtract, type Vec3, ZERO } from "../arm/vector.js";
import { pointsText, toPixel, type View } from "../arm/view.js";
import { formatNumber, say } from "../text/text.js";

/**
 * What a lesson has beside the arm: sliders for joint rates, whose contributions are drawn at P ("rates") or link by link
 * ("links"); a slider for the direction of P ("wanted") or of a force at P ("force"); the parallelogram of the columns
 * ("area"); or a chart of the workspace.
 */
export type Tool = "rates" | "links" | "wanted" | "force" | "area" | "workspace";

/** The values of the sliders: joint rates (rad/s), and a direction on the page (degrees). */
type Dials = { readonly rates: readonly number[]; readonly direction: number };

/** The sliders at first, when nothing moves: an arrow would give away what the student is to predict. */
export const FIRST_DIALS: Dials = { rates: [0, 0], direction: 0 };
/** The sliders in the figure of an explanation. */
export const SKETCHED_DIALS: Dials = { rates: [0.5, 0.5], direction: 0 };

/** The wanted speed of P (m/s). */
const WANTED_SPEED = 0.5;
/** The damping of the least squares problem (m), which bounds the joint rates at a singularity. */
const DAMPING = 1e-6;

/** The force at P (N). */
export const FORCE = 10;

/**
 * Return the joint rates (rad/s) that a tool sets: those of the sliders, or those that move P as wanted. For a force they
 * are the joint torques (N m) with which P pushes. A tool that sets nothing returns [].
 */
export function computeRates(tool: Tool | null, dials: Dials, { taskJacobian }: State): readonly number[] {
  if (tool === "rates" || tool === "links") return dials.rates;
  const direction = directionOf(dials);
  if (tool === "wanted")
    return leastSquares(
      taskJacobian,
      direction.map((component) => WANTED_SPEED * component),
      DAMPING,
    );
  if (tool !== "force") return [];
  const [firstRow, secondRow] = taskJacobian as [readonly number[], readonly number[]];
  return firstRow.map((entry, k) => FORCE * (entry * direction[0] + secondRow[k]! * direction[1]));
}

/** Return the unit vector in the direction of the slider. */
function directionOf({ direction }: Dials): readonly [number, number] {
  const angle = (direction * Math.PI) / 180;
  return [Math.cos(angle), Math.sin(angle)];
}

/** Return the velocity of P (m/s) at given joint rates. */
export function computeVelocity(arm: Arm, state: State, rates: readonly number[]): Vec3 {
  return arrowsOf(arm, state).columns.reduce((sum, column, i) => add(sum, scaleVector(column, rates[i] ?? 0)), ZERO);
}

/** Return the speed of joint 2 (m/s). */
export const computeJointSpeed = ({ state: { frames } }: Pick<Stage, "state">, rates: readonly number[]): number =>
  Math.abs(rates[0]!) * norm(subtract(frames[1]!.o, frames[0]!.o));

/** Larger rates (rad/s), as near a singularity, are drawn like this one. */
const MAX_RATE = 1e3;
/** Velocities are drawn longer than columns of J by this factor, because the rates are small. */
const ARROW_SCALE = 2;

/** What the arrows of a tool depend on. */
type DrawnStage = Pick<Stage, "arm" | "state" | "reach">;

/** An arrow that a tool draws. */
type ToolArrow = { readonly start: Vec3; readonly vector: Vec3; readonly className: string };

/** Return the contribution of each joint to the velocity of P, head to tail, and their sum. */
function listContributions({ arm, state }: DrawnStage, rates: readonly number[]): ToolArrow[] {
  const scale = ARROW_SCALE * speedScale(arm);
  let end = state.point;
  const contributions = arrowsOf(arm, state).columns.map((column, i) => {
    const start = end;
    const vector = scaleVector(column, scale * clamp(rates[i] ?? 0, -MAX_RATE, MAX_RATE));
    end = add(end, vector);
    return { start, vector, className: `arm-share ${jointClass(i)}` };
  });
  const sum = scaleVector(computeVelocity(arm, state, rates), scale);
  return [...contributions, { start: state.point, vector: sum, className: "arm-sum" }];
}

/** Return the velocity of each joint, and at P that of the last joint plus what the rotation of the last link adds. */
function listLinkVelocities({ arm, state }: DrawnStage, rates: readonly number[]): ToolArrow[] {
  const scale = ARROW_SCALE * speedScale(arm);
  const origins = state.frames.map(({ o }) => o);
  let angularVelocity = ZERO;
  let velocity = ZERO;
  return arm.joints.flatMap((_, i) => {
    angularVelocity = addScaled(angularVelocity, state.frames[i]!.z, rates[i] ?? 0);
    const carried = scaleVector(velocity, scale);
    const added = scaleVector(cross(angularVelocity, subtract(origins[i + 1]!, origins[i]!)), scale);
    velocity = addScaled(velocity, added, 1 / scale);
    const start = origins[i + 1]!;
    return [
      { start, vector: carried, className: `arm-share ${jointClass(Math.max(i - 1, 0))}` },
      { start: add(start, carried), vector: added, className: `arm-share ${jointClass(i)}` },
      { start, vector: add(carried, added), className: "arm-sum" },
    ];
  });
}

/** The length at which the force is drawn, as a share of the arm's reach. */
const FORCE_LENGTH = 0.35;

/** Return the arrows of a tool. */
function listArrows(tool: Tool, dials: Dials, stage: DrawnStage): ToolArrow[] {
  const { state, reach } = stage;
  if (tool === "workspace" || tool === "area") return [];
  if (tool === "force") {
    const vector = scaleVector([...directionOf(dials), 0], FORCE_LENGTH * reach);
    return [{ start: state.point, vector, className: "arm-sum" }];
  }
  const rates = computeRates(tool, dials, state);
  return tool === "links" ? listLinkVelocities(stage, rates) : listContributions(stage, rates);
}

/** Return the corners of the parallelogram that the first two columns of J span at P. */
function cornersOfArea({ arm, state, reach }: DrawnStage): Vec3[] {
  const [first, second] = drawnColumns(arm, state, reach) as [Vec3, Vec3];
  return [ZERO, first, add(first, second), second].map((corner) => add(state.point, corner));
}

/** Return the lines of what a tool draws: the sides of the parallelogram, or the arrows. */
export function linesOfTool(tool: Tool, dials: Dials, stage: DrawnStage): readonly (readonly Vec3[])[] {
  if (tool === "area") return [cornersOfArea(stage)];
  return listArrows(tool, dials, stage).map(({ start, vector }) => [start, add(start, vector)]);
}

type OverlayProps = { readonly tool: Tool; readonly dials: Dials; readonly stage: DrawnStage; readonly view: View };

/** The arrows that a tool draws over the arm, or the parallelogram. */
export function ToolArrows({ tool, dials, stage, view }: OverlayProps): JSX.Element {
  if (tool === "area") {
    const corners = cornersOfArea(stage).map((corner) => toPixel(view, corner));
    return <polygon class="arm-ellipse" points={pointsText(corners)} />;
  }
  return (
    <g>
      {listArrows(tool, dials, stage).map((arrow, i) => (
        <Arrow key={i} view={view} {...arrow} />
      ))}
    </g>
  );
}

/** Format a number with two decimals. */
const formatRounded = (value: number): string => formatNumber(roundToDecimals(value, 2));

interface DialsProps {
  readonly tool: Exclude<Tool, "workspace" | "area">;
  readonly stage: Stage;
  readonly dials: Dials;
  /** The joint rates that the tool sets (rad/s; torques in N m for a force), and the resulting velocity of P (m/s). */
  readonly rates: readonly number[];
  readonly velocity: Vec3;
  readonly onDials: (dials: Dials) => void;
}

/** The sliders of a tool, and the resulting numbers. */
export function DialBoard(props: DialsProps): JSX.Element {
  const { tool, stage, dials, onDials } = props;
  return (
    <div class="dials">
      {tool === "rates" || tool === "links" ? (
        stage.arm.joints.map(({ name }, i) => (
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
          <i>{tool === "force" ? "f" : "v"}</i>
          <input
            type="range"
            min={-180}
            max={180}
            step={5}
            value={dials.direction}
            aria-label={say(tool === "force" ? "lesson.force-direction" : "lesson.direction")}
            onInput={(event) => onDials({ ...dials, direction: Number(event.currentTarget.value) })}
          />
          <output>{formatRounded(dials.direction)}°</output>
        </label>
      )}
      <p class="muted">
        <Words text={describeResult(props)} />
      </p>
    </div>
  );
}

/** Return the numbers that result from the sliders, in words. */
function describeResult({ tool, stage, rates, velocity }: DialsProps): string {
  const [vx, vy] = velocity.map((value) => formatRounded(value)) as [string, string, string];
  const [first, second] = [formatRounded(rates[0] ?? 0), formatRounded(rates[1] ?? 0)];
  if (tool === "rates") return say("lesson.velocity", { vx, vy });
  if (tool === "links") {
    const [omega, joint, point] = [rates[0]! + rates[1]!, computeJointSpeed(stage, rates), norm(velocity)].map(
      formatRounded,
    );
    return say("lesson.link-velocity", { omega: omega!, joint: joint!, point: point! });
  }
  return say(tool === "force" ? "lesson.torques-due" : "lesson.rates-due", { first, second });
}
