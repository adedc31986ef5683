// Joint rates over time on a path, with their limits. Where a curve leaves the band, its joint exceeds its limit.

import type { JSX } from "preact";
import { useRef } from "preact/hooks";

import { say } from "../text/text.js";
import { DrawnLetters, jointClass } from "./letters.js";
import type { Arm } from "./model.js";
import { useSize } from "./size.js";
import { roundToDecimals } from "./number-format.js";
import type { Journey } from "./path.js";
import { clamp } from "./vector.js";
import { pointsText } from "./view.js";

interface ChartProps {
  readonly arm: Arm;
  readonly journey: Journey;
  /** Speed of P (m/s). */
  readonly speed: number;
  /** Limits of the joint rates (rad/s or m/s). */
  readonly limits: readonly number[];
  /** Time of the arm's current place on the path (s). */
  readonly time: number;
}

const [LEFT_MARGIN, BOTTOM_MARGIN, TOP_MARGIN] = [54, 26, 16];

/** A chart of rates as fractions of their limits, so that revolute and prismatic joints share one axis. */
export function Chart({ arm, journey, speed, limits, time }: ChartProps): JSX.Element {
  const box = useRef<HTMLDivElement>(null);
  const [width, height] = useSize(box, [420, 220]);
  const totalTime = journey.path.length / speed || 1;
  const limitShares = limits.map((limit, i) => journey.stations.map(({ slopes }) => (slopes[i]! * speed) / limit));
  const maxShare = Math.min(3, Math.max(1.25, 1.08 * Math.max(...limitShares.flat().map(Math.abs))));
  const plotHeight = height - TOP_MARGIN - BOTTOM_MARGIN;
  const columns = countColumns(limits.length, plotHeight);
  const plotWidth = width - LEFT_MARGIN - LEADER_LENGTH - COLUMN_WIDTH * columns;
  const x = (t: number): number => LEFT_MARGIN + (t / totalTime) * plotWidth;
  const y = (share: number): number =>
    TOP_MARGIN + (plotHeight * (maxShare - clamp(share, -maxShare, maxShare))) / (2 * maxShare);
  const endTime = journey.stations.at(-1)!.s / speed;
  const endHeights = limitShares.map((row) => y(row.at(-1)!));
  const names = spreadNames(endHeights, [TOP_MARGIN + DOT.up / 2, TOP_MARGIN + plotHeight], columns);
  return (
    <figure class="arm-chart">
      <figcaption>{say("arm.chart.title")}</figcaption>
      <div ref={box} class="arm-chart-frame">
        <svg viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
          <rect class="arm-band" x={LEFT_MARGIN} y={y(1)} width={plotWidth} height={y(-1) - y(1)} />
          <path class="arm-limit" d={`M${LEFT_MARGIN} ${y(1)}h${plotWidth}M${LEFT_MARGIN} ${y(-1)}h${plotWidth}`} />
          <path
            class="arm-axis"
            d={`M${LEFT_MARGIN} ${TOP_MARGIN}v${plotHeight}h${plotWidth}M${LEFT_MARGIN} ${y(0)}h${plotWidth}`}
          />
          {[1, 0, -1].map((share) => (
            <text key={share} class="arm-tick-text arm-end" x={LEFT_MARGIN - 6} y={y(share) + 4}>
              {share === 0 ? "0" : share > 0 ? "+100 %" : "−100 %"}
            </text>
          ))}
          {[0, 0.5, 1].map((share) => (
            <text key={share} class="arm-tick-text arm-middle" x={x(share * totalTime)} y={height - 8}>
              {say("arm.chart.seconds", { time: roundToDecimals(share * totalTime, 1) })}
            </text>
          ))}
          {!journey.reachesEnd && (
            <rect
              class="arm-never"
              x={x(endTime)}
              y={TOP_MARGIN}
              width={Math.max(0, x(totalTime) - x(endTime))}
              height={plotHeight}
            />
          )}
          {limitShares.map((row, i) => (
            <polyline
              key={i}
              class={`arm-rate ${jointClass(i)}`}
              points={pointsText(row.map((share, k) => [x(journey.stations[k]!.s / speed), y(share)]))}
            />
          ))}
          {names.map((name, i) => {
            const [left, middle] = [x(endTime) + LEADER_LENGTH + COLUMN_WIDTH * name.column, name.height + 4];
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
          <path class="arm-now" d={`M${x(time)} ${TOP_MARGIN}v${plotHeight}`} />
        </svg>
      </div>
    </figure>
  );
}

/** The dot of a rate: its offset (pixels) from the start of the letter. */
const DOT = { right: 5, up: 12.5 };

/** Pixels between the end of a curve and its name, between columns of names, and between names in a column. */
const [LEADER_LENGTH, COLUMN_WIDTH, NAME_HEIGHT] = [14, 26, 19];

/** Return how many columns are needed so that names in a column do not overlap. */
export function countColumns(count: number, height: number): number {
  return Math.max(1, Math.ceil(((count - 1) * NAME_HEIGHT) / Math.max(height, NAME_HEIGHT)));
}

type Interval = readonly [number, number];
type PlacedName = { readonly height: number; readonly column: number };

/** Return where the names of curves are placed: in the order of the curves' ends, a step apart in each column. */
export function spreadNames(
  heights: readonly number[],
  [top, bottom]: Interval,
  columns: number,
): readonly PlacedName[] {
  const order = heights.map((_, i) => i).sort((a, b) => heights[a]! - heights[b]!);
  const step = Math.min(NAME_HEIGHT / columns, (bottom - top) / Math.max(1, heights.length - 1));
  const placedHeights = heights.map((value) => Math.max(top, value));
  order.forEach((i, k) => {
    if (k > 0) placedHeights[i] = Math.max(placedHeights[i]!, placedHeights[order[k - 1]!]! + step);
  });
  // Move names up again if they would end below the chart.
  [...order].reverse().forEach((i, k, reversedOrder) => {
    placedHeights[i] = Math.min(placedHeights[i]!, k === 0 ? bottom : placedHeights[reversedOrder[k - 1]!]! - step);
  });
  return placedHeights.map((height, i) => ({ height, column: order.indexOf(i) % columns }));
}
