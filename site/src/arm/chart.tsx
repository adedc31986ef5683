// Joint rates over time on a path, with their limits. Where a curve leaves the band, its joint exceeds its limit.

import type { JSX } from "preact";
import { useRef } from "preact/hooks";

import { say } from "../text/text.js";
import { DrawnLetters, jointClass } from "./letters.js";
import type { Arm } from "./model.js";
import { useSize } from "./size.js";
import { decimals } from "./number-format.js";
import type { Journey } from "./path.js";
import { pointsText } from "./view.js";

export interface ChartProps {
  readonly arm: Arm;
  readonly journey: Journey;
  readonly speed: number;
  readonly limits: readonly number[];
  /** Time of the arm's current place on the path (s). */
  readonly time: number;
}

const [LEFT, BOTTOM, TOP] = [54, 26, 16];

/** The chart shows rates as fractions of their limits, so revolute and prismatic joints share one axis. */
export function Chart({ arm, journey, speed, limits, time }: ChartProps): JSX.Element {
  const frame = useRef<HTMLDivElement>(null);
  const [width, height] = useSize(frame, [420, 220]);
  const total = journey.path.length / speed || 1;
  const shares = limits.map((limit, i) => journey.stations.map(({ slopes }) => (slopes[i]! * speed) / limit));
  const maxShare = Math.min(3, Math.max(1.25, 1.08 * Math.max(...shares.flat().map(Math.abs))));
  const h = height - TOP - BOTTOM;
  const columns = columnsFor(limits.length, h);
  const w = width - LEFT - LEAD - COLUMN * columns;
  const x = (t: number): number => LEFT + (t / total) * w;
  const y = (share: number): number =>
    TOP + (h * (maxShare - Math.max(-maxShare, Math.min(maxShare, share)))) / (2 * maxShare);
  const endTime = journey.stations.at(-1)!.s / speed;
  const endHeights = shares.map((row) => y(row.at(-1)!));
  const names = spreadNames(endHeights, [TOP + DOT.up / 2, TOP + h], columns);
  return (
    <figure class="arm-chart">
      <figcaption>{say("arm.chart.title")}</figcaption>
      <div ref={frame} class="arm-chart-frame">
        <svg viewBox={`0 0 ${width} ${height}`} width={width} height={height} aria-hidden="true">
          <rect class="arm-band" x={LEFT} y={y(1)} width={w} height={y(-1) - y(1)} />
          <path class="arm-limit" d={`M${LEFT} ${y(1)}h${w}M${LEFT} ${y(-1)}h${w}`} />
          <path class="arm-axis" d={`M${LEFT} ${TOP}v${h}h${w}M${LEFT} ${y(0)}h${w}`} />
          {[1, 0, -1].map((share) => (
            <text key={share} class="arm-tick-text arm-end" x={LEFT - 6} y={y(share) + 4}>
              {share === 0 ? "0" : share > 0 ? "+100 %" : "−100 %"}
            </text>
          ))}
          {[0, 0.5, 1].map((part) => (
            <text key={part} class="arm-tick-text arm-middle" x={x(part * total)} y={height - 8}>
              {say("arm.chart.seconds", { time: decimals(part * total, 1) })}
            </text>
          ))}
          {!journey.arrives && (
            <rect class="arm-never" x={x(endTime)} y={TOP} width={Math.max(0, x(total) - x(endTime))} height={h} />
          )}
          {shares.map((row, i) => (
            <polyline
              key={i}
              class={`arm-rate ${jointClass(i)}`}
              points={pointsText(row.map((share, k) => [x(journey.stations[k]!.s / speed), y(share)]))}
            />
          ))}
          {names.map((name, i) => {
            const [left, middle] = [x(endTime) + LEAD + COLUMN * name.column, name.height + 4];
            return (
              <g key={i} class={`arm-rate-name ${jointClass(i)}`}>
                <path class="arm-leader" d={`M${x(endTime)} ${endHeights[i]}L${left - 3} ${name.height}`} />
                <text x={left} y={middle}>
                  <DrawnLetters name={arm.joints[i]!.name} />
                </text>
                <circle cx={left + DOT.right} cy={middle - DOT.up} r={1.3} />
              </g>
            );
          })}
          <path class="arm-now" d={`M${x(time)} ${TOP}v${h}`} />
        </svg>
      </div>
    </figure>
  );
}

/** The dot of a rate: its offset (pixels) from the start of the letter. */
const DOT = { right: 5, up: 12.5 };

/** Pixels between the end of a curve and its name, between columns of names, and between names in a column. */
const [LEAD, COLUMN, STEP] = [14, 26, 19];

/** Return how many columns are needed so that names in a column do not overlap. */
export function columnsFor(count: number, height: number): number {
  return Math.max(1, Math.ceil(((count - 1) * STEP) / Math.max(height, STEP)));
}

type Pair = readonly [number, number];
type Name = { readonly height: number; readonly column: number };

/** Return where the names of curves are placed: in the order of the curves' ends, a step apart in each column. */
export function spreadNames(heights: readonly number[], [top, bottom]: Pair, columns: number): readonly Name[] {
  const order = heights.map((_, i) => i).sort((a, b) => heights[a]! - heights[b]!);
  const step = Math.min(STEP / columns, (bottom - top) / Math.max(1, heights.length - 1));
  const placed = heights.map((value) => Math.max(top, value));
  order.forEach((i, k) => {
    if (k > 0) placed[i] = Math.max(placed[i]!, placed[order[k - 1]!]! + step);
  });
  // Move names up again if they would end below the chart.
  [...order].reverse().forEach((i, k, all) => {
    placed[i] = Math.min(placed[i]!, k === 0 ? bottom : placed[all[k - 1]!]! - step);
  });
  return placed.map((height, i) => ({ height, column: order.indexOf(i) % columns }));
}
