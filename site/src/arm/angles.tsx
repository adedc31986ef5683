// Draw the joint angles of a planar arm as arcs from x_{i-1} to x_i, as in the textbook's figures.

import type { JSX } from "preact";

import { type Arm, thetaAndD, type State } from "./model.js";
import { dot } from "./vector.js";
import { vectorInPixels, toPixel, type Pixel, type View } from "./view.js";
import { jointClass } from "./letters.js";

/** The arc of a joint angle: SVG path data (pixels) of the arc, its arrowhead and the dashed line at angle zero. */
interface AngleArc {
  readonly path: string;
  readonly arrowhead: string;
  readonly zeroLine: string;
  /** Where the joint's letter is placed, and the direction from the joint to this place. */
  readonly labelPlace: Pixel;
  readonly labelDirection: Pixel;
}

/** Radius of an arc (pixels). */
const RADIUS = 34;
/** Below this absolute value (rad), an angle gets no arc. */
const MIN_ANGLE = 0.06;

/** Return the arc of joint i (from 0); null for a prismatic or hidden joint angle, and for an angle near zero. */
export function arcOf(arm: Arm, state: State, view: View, i: number): AngleArc | null {
  const joint = arm.joints[i]!;
  if (joint.kind !== "R") return null;
  const previousFrame = state.frames[i]!;
  const [angle] = thetaAndD(joint, state.pose[i]!);
  const wrappedAngle = Math.atan2(Math.sin(angle), Math.cos(angle));
  if (Math.abs(wrappedAngle) < MIN_ANGLE) return null;
  const [x, y] = toPixel(view, previousFrame.o);
  const [sx, sy] = vectorInPixels(view, previousFrame.x);
  const towardReader = dot(previousFrame.z, view.towardReader);
  const startAngle = Math.atan2(-sy, sx);
  const pageAngle = towardReader > 0 ? wrappedAngle : -wrappedAngle; // positive counterclockwise on the page
  const pointOnArc = (share: number, radius: number): Pixel => [
    x + radius * Math.cos(startAngle + share * pageAngle),
    y - radius * Math.sin(startAngle + share * pageAngle),
  ];
  const [start, end] = [pointOnArc(0, RADIUS), pointOnArc(1, RADIUS)];
  const headShare = Math.max(0, 1 - 7 / (RADIUS * Math.abs(pageAngle))); // the arrowhead is 7 pixels long
  const [left, right] = [pointOnArc(headShare, RADIUS - 3), pointOnArc(headShare, RADIUS + 3)];
  const dashEnd = pointOnArc(0, RADIUS + 12);
  const labelPlace = pointOnArc(0.5, RADIUS + 2);
  const largeArcFlag = Math.abs(pageAngle) > Math.PI ? 1 : 0;
  return {
    path: `M${start[0]} ${start[1]}A${RADIUS} ${RADIUS} 0 ${largeArcFlag} ${pageAngle > 0 ? 0 : 1} ${end[0]} ${end[1]}`,
    arrowhead: `M${end[0]} ${end[1]}L${left[0]} ${left[1]}L${right[0]} ${right[1]}Z`,
    zeroLine: `M${x} ${y}L${dashEnd[0]} ${dashEnd[1]}`,
    labelPlace,
    labelDirection: [labelPlace[0] - x, labelPlace[1] - y],
  };
}

export function Angles({ arm, state, view }: { arm: Arm; state: State; view: View }): JSX.Element {
  return (
    <g class="arm-angles">
      {arm.joints.map(({ name }, i) => {
        const arc = arcOf(arm, state, view, i);
        return arc ? (
          <g key={name} class={jointClass(i)}>
            <path class="arm-dashed" d={arc.zeroLine} />
            <path class="arm-arc" d={arc.path} />
            <path class="arm-head" d={arc.arrowhead} />
          </g>
        ) : null;
      })}
    </g>
  );
}
