// A small figure of an arm in a pose, for the explanation of a lesson: with the arrows of its tool, or the columns of J.

import type { JSX } from "preact";
import { useMemo } from "preact/hooks";

import { DrawnLetters, jointClass } from "../arm/letters.js";
import { Arrow, Body } from "../arm/line-drawing.js";
import { drawnColumns } from "../arm/marks.js";
import { type Arm, reachOf, stateAt } from "../arm/model.js";
import { extentOf } from "../arm/ranges.js";
import { add, addScaled, type Vec3 } from "../arm/vector.js";
import { FIRST_ORBIT, toPixel, vectorInPixels, type View, viewOf } from "../arm/view.js";
import { Rich } from "../practice/math.js";
import { say } from "../text/text.js";
import { linesOfTool, SKETCHED_DIALS, type Tool, ToolArrows } from "./tools.js";

const [WIDTH, HEIGHT] = [320, 220];
/** Pixels around what is drawn, for joints, the ground and names. */
const MARGIN = 38;

/** Return a view in which points fill the figure. */
function fitView(view: View, points: readonly Vec3[]): View {
  const pixels = points.map((point) => toPixel(view, point));
  const [xs, ys] = [pixels.map(([x]) => x), pixels.map(([, y]) => y)];
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const zoom = Math.min((WIDTH - 2 * MARGIN) / (right - left || 1), (HEIGHT - 2 * MARGIN) / (bottom - top || 1));
  const [x, y] = [(left + right - WIDTH) / 2 / view.scale, (top + bottom - HEIGHT) / 2 / view.scale];
  const centre = addScaled(addScaled(view.centre, view.right, x), view.up, -y);
  return { ...view, scale: zoom * view.scale, centre };
}

interface SketchProps {
  readonly arm: Arm;
  /** The joint angles. */
  readonly degrees: readonly number[];
  readonly tool: Tool | null;
}

export function Sketch({ arm, degrees, tool }: SketchProps): JSX.Element {
  const hasRates = tool === "rates" || tool === "links";
  const drawnTool = hasRates || tool === "area" ? tool : null;
  const { state, view, reach, columns } = useMemo(() => {
    const reach = reachOf(arm);
    const state = stateAt(
      arm,
      degrees.map((angle) => (angle * Math.PI) / 180),
    );
    const columns = hasRates ? [] : drawnColumns(arm, state, reach);
    const points = [
      ...state.frames.map(({ o }) => o),
      ...columns.map((vector) => add(state.point, vector)),
      ...(drawnTool ? linesOfTool(drawnTool, SKETCHED_DIALS, { arm, state, reach }).flat() : []),
    ];
    const view = fitView(viewOf(arm, extentOf(arm), WIDTH, HEIGHT, FIRST_ORBIT), points);
    return { state, view, reach, columns };
  }, [arm, degrees, drawnTool]);
  const [x, y] = toPixel(view, state.point);
  const describe = (write: (index: number, angle: number) => string): string =>
    say(hasRates ? "lesson.sketch-rates" : "lesson.sketch", {
      angles: degrees.map((angle, i) => write(i + 1, angle)).join(", "),
    });
  return (
    <div class="sketch">
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        role="img"
        aria-label={describe((index, angle) => `θ${index} = ${angle}°`)}
      >
        <Body arm={arm} state={state} view={view} reach={reach} />
        {drawnTool ? (
          <ToolArrows tool={drawnTool} dials={SKETCHED_DIALS} stage={{ arm, state, reach }} view={view} />
        ) : null}
        {columns.map((vector, i) => {
          const [tipX, tipY] = toPixel(view, add(state.point, vector));
          const [dx, dy] = [tipX - x, tipY - y];
          const [sumX, sumY] = vectorInPixels(view, columns.reduce(add));
          const side = dy * sumX - dx * sumY > 0 ? -1 : 1; // names stand beside their heads, away from each other
          const offset = (15 * side) / (Math.hypot(dx, dy) || 1);
          return (
            <g key={i} class={`arm-letter-layer ${jointClass(i)}`}>
              <Arrow view={view} start={state.point} vector={vector} className={`arm-column ${jointClass(i)}`} />
              <text x={tipX + offset * dy} y={tipY - offset * dx + 5}>
                <DrawnLetters name={`J${i + 1}`} />
              </text>
            </g>
          );
        })}
        <circle class="arm-point-dot" cx={x} cy={y} r={4} />
      </svg>
      <p class="muted">
        <Rich text={describe((index, angle) => `$\\theta_${index} = ${angle < 0 ? "-" : ""}${Math.abs(angle)}°$`)} />
      </p>
    </div>
  );
}
