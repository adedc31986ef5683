// Joint rates over time on a path, with their limits: where a curve leaves the band, the joint is too slow for it.

import type { JSX } from "preact";
import { useRef } from "preact/hooks";

import { say } from "../text/text.js";
import { DrawnLetters, jointClass } from "./letters.js";
import type { Arm } from "./model.js";
import { useSize } from "./size.js";
import { decimals } from "./speech.js";
import type { Journey } from "./path.js";

export interface ChartProps {
  readonly arm: Arm;
  readonly journey: Journey;
  readonly speed: number;
  readonly limits: readonly number[];
  /** Time of the place that is shown (s). */
  readonly time: number;
}

const [LEFT, BOTTOM, TOP] = [54, 26, 16];

/** Rates as parts of their limits, so that turns and slides share one axis. */
export function Chart({ arm, journey, speed, limits, time }: ChartProps): JSX.Element {
  const frame = useRef<HTMLDivElement>(null);
  const [width, height] = useSize(frame, [420, 220]);
  const total = journey.path.length / speed || 1;
  const shares = limits.map((limit, i) => journey.stations.map(({ slopes }) => (slopes[i]! * speed) / limit));
  const most = Math.min(3, Math.max(1.25, 1.08 * Math.max(...shares.flat().map(Math.abs))));
  const h = height - TOP - BOTTOM;
  const columns = columnsFor(limits.length, h);
  const w = width - LEFT - LEAD - COLUMN * columns;
  const x = (t: number): number => LEFT + (t / total) * w;
  const y = (share: number): number => TOP + (h * (most - Math.max(-most, Math.min(most, share)))) / (2 * most);
  const end = journey.stations.at(-1)!.s / speed;
  const ends = shares.map((row) => y(row.at(-1)!));
  const names = spread(ends, [TOP + DOT.up / 2, TOP + h], columns);
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
            <rect class="arm-never" x={x(end)} y={TOP} width={Math.max(0, x(total) - x(end))} height={h} />
          )}
          {shares.map((row, i) => (
            <polyline
              key={i}
              class={`arm-rate ${jointClass(i)}`}
              points={row
                .map((share, k) => `${x(journey.stations[k]!.s / speed).toFixed(1)},${y(share).toFixed(1)}`)
                .join(" ")}
            />
          ))}
          {names.map((name, i) => {
            const [left, middle] = [x(end) + LEAD + COLUMN * name.column, name.at + 4];
            return (
              <g key={i} class={`arm-rate-name ${jointClass(i)}`}>
                <path class="arm-leader" d={`M${x(end)} ${y(shares[i]!.at(-1)!)}L${left - 3} ${name.at}`} />
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

/** Where the dot of a rate is, from where its letter begins (pixels). */
const DOT = { right: 5, up: 12.5 };

/** Pixels from the end of a curve to its name, between columns of names, and between two names of a column. */
const [LEAD, COLUMN, STEP] = [14, 26, 19];

/** In how many columns so many names stand one below the other, each clear of the next. */
export function columnsFor(count: number, height: number): number {
  return Math.max(1, Math.ceil(((count - 1) * STEP) / Math.max(height, STEP)));
}

type Pair = readonly [number, number];
type Name = { readonly at: number; readonly column: number };

/** Spread the names of curves that end at these heights, in order and over the columns, a step apart in each column. */
export function spread(heights: readonly number[], [top, bottom]: Pair, columns: number): readonly Name[] {
  const order = heights.map((_, i) => i).sort((a, b) => heights[a]! - heights[b]!);
  const step = Math.min(STEP / columns, (bottom - top) / Math.max(1, heights.length - 1));
  const moved = heights.map((value) => Math.max(top, value));
  order.forEach((i, k) => {
    if (k > 0) moved[i] = Math.max(moved[i]!, moved[order[k - 1]!]! + step);
  });
  // back up from the bottom, where there is no room below
  [...order].reverse().forEach((i, k, all) => {
    moved[i] = Math.min(moved[i]!, k === 0 ? bottom : moved[all[k - 1]!]! - step);
  });
  return moved.map((at, i) => ({ at, column: order.indexOf(i) % columns }));
}
