// The trace of P: where P was while the arm was moved.

import { type Arm, type Pose, pointsAt } from "./model.js";
import { dot, subtract, type Vec3 } from "./vector.js";

/** The lines along which P was moved; the last one ends where P is now, unless the arm has jumped to another pose. */
export type Trace = readonly (readonly Vec3[])[];

export const NO_TRACE: Trace = [];

/** Maximum number of points; the oldest are dropped. */
const MAX_POINTS = 1500;
/** Between two points of a line, no joint moves further (rad or m). */
const MAX_STEP = 0.04;
const MAX_STEPS_PER_MOVE = 160;

/** Return a trace after a move from one pose to another, in which the joints move in proportion. */
export function extendTrace(trace: Trace, arm: Arm, from: Pose, to: Pose): Trace {
  const change = to.map((value, i) => {
    const difference = value - from[i]!;
    // A revolute joint takes the shorter way: its value jumps from 180° to -180°.
    return arm.joints[i]!.kind === "R" ? difference - 2 * Math.PI * Math.round(difference / (2 * Math.PI)) : difference;
  });
  const largestChange = Math.max(...change.map(Math.abs));
  if (largestChange < 1e-9) return trace;
  const count = Math.min(MAX_STEPS_PER_MOVE, Math.ceil(largestChange / MAX_STEP));
  const pointAt = (k: number): Vec3 =>
    pointsAt(
      arm,
      from.map((value, i) => value + (k / count) * change[i]!),
    ).point;
  const added = Array.from({ length: count }, (_, k) => pointAt(k + 1));
  const start = pointAt(0);
  const lastLine = trace.at(-1);
  const lastGap = lastLine && subtract(lastLine.at(-1)!, start);
  const isConnected = lastGap !== undefined && dot(lastGap, lastGap) < 1e-12;
  return limitLength(isConnected ? [...trace.slice(0, -1), [...lastLine!, ...added]] : [...trace, [start, ...added]]);
}

/** Return a trace without its oldest points if it has too many. */
function limitLength(trace: Trace): Trace {
  let excess = trace.reduce((sum, line) => sum + line.length, 0) - MAX_POINTS;
  const lines = trace.map((line) => {
    const dropped = Math.min(line.length, Math.max(0, excess));
    excess -= dropped;
    return dropped > 0 ? line.slice(dropped) : line;
  });
  return lines.filter((line) => line.length > 1);
}
