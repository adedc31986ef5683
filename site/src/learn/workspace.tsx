// The workspace of an arm in the plane that joint 1 rotates: where P can be, and where det J is zero.

import type { JSX } from "preact";
import { useMemo } from "preact/hooks";

import { Words } from "../arm/letters.js";
import { type Arm, pointsAt, reachOf, signedVolume, type State } from "../arm/model.js";
import { say } from "../text/text.js";

/** The number of values of each joint, the number of cells along each side of the chart, its size in pixels. */
const [STEP_COUNT, CELL_COUNT, SIZE] = [120, 80, 280];

type PlanePoint = readonly [radius: number, height: number];

/** The cells that P can reach, and the points P of singular configurations, as paths in the chart. */
type WorkspacePaths = { readonly reached: string; readonly singular: string };

/** The chart, with the current place of P. The radius is negative beyond the axis of joint 1. */
export function WorkspaceChart({ arm, state }: { readonly arm: Arm; readonly state: State }): JSX.Element {
  const { toChart, paths } = useMemo(() => {
    const scale = SIZE / (2.1 * reachOf(arm));
    const base = pointsAt(arm, [0, 0, 0]).frames[1]!.o[2];
    const toChart = ([radius, height]: PlanePoint): PlanePoint => [
      SIZE / 2 + scale * radius,
      SIZE / 2 - scale * (height - base),
    ];
    return { toChart, paths: findWorkspace(arm, toChart) };
  }, [arm]);
  const { point, pose } = state;
  const angle = pose[0]!;
  const [x, y] = toChart([point[0] * Math.cos(angle) + point[1] * Math.sin(angle), point[2]]);
  return (
    <div class="workspace-chart">
      <svg viewBox={`0 0 ${SIZE} ${SIZE}`} role="img" aria-label={say("lesson.workspace-chart")}>
        <path class="workspace-reached" d={paths.reached} />
        <path class="workspace-axis" d={`M${SIZE / 2} 0V${SIZE}`} />
        <path class="workspace-singular" d={paths.singular} />
        <circle class="workspace-point" cx={x} cy={y} r={6} />
      </svg>
      <p class="muted">
        <Words text={say("lesson.workspace-chart")} />
      </p>
    </div>
  );
}

/** Return what the chart shows of an arm whose joints 2 and 3 move P in the plane y = 0 while theta1 = 0. */
function findWorkspace(arm: Arm, toChart: (point: PlanePoint) => PlanePoint): WorkspacePaths {
  const step = (2 * Math.PI) / STEP_COUNT;
  const angles = Array.from({ length: STEP_COUNT }, (_, k) => -Math.PI + (k + 0.5) * step);
  const cell = SIZE / CELL_COUNT;
  const cells = new Set<string>();
  const dots: string[] = [];
  const chartPoint = (theta2: number, theta3: number): PlanePoint => {
    const { point } = pointsAt(arm, [0, theta2, theta3]);
    return toChart([point[0], point[2]]);
  };
  const sizes = angles.map((theta3) => angles.map((theta2) => signedVolume(arm, [0, theta2, theta3])));
  angles.forEach((theta3, row) =>
    angles.forEach((theta2, column) => {
      const [x, y] = chartPoint(theta2, theta3);
      for (const mirrored of [x, SIZE - x]) cells.add(`${Math.floor(mirrored / cell)} ${Math.floor(y / cell)}`);
      const size = sizes[row]![column]!;
      // angles repeat after a full turn, and so at(-1) is the neighbour of the first one
      const neighbours = [
        { neighbour: sizes[row]!.at(column - 1)!, change: [step, 0] },
        { neighbour: sizes.at(row - 1)![column]!, change: [0, step] },
      ] as const;
      for (const { neighbour, change } of neighbours) {
        if (Math.sign(size) === Math.sign(neighbour)) continue;
        const share = size / (size - neighbour);
        const [u, v] = chartPoint(theta2 - share * change[0], theta3 - share * change[1]);
        for (const mirrored of [u, SIZE - u]) dots.push(`M${mirrored.toFixed(1)} ${v.toFixed(1)}h0`);
      }
    }),
  );
  const squares = [...cells].map((name) => name.split(" ").map((index) => (Number(index) * cell).toFixed(1)));
  return { reached: squares.map(([x, y]) => `M${x} ${y}h${cell}v${cell}h-${cell}z`).join(""), singular: dots.join("") };
}
