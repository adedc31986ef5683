// Draw the joint angles of a planar arm as arcs from x_{i-1} to x_i, as in the textbook's figures.

import type { JSX } from "preact";

import { type Arm, thetaAndD, type State } from "./model.js";
import { dot } from "./vector.js";
import { vectorInPixels, pixel, type Pixel, type View } from "./view.js";
import { jointClass } from "./letters.js";

/** The arc of a joint angle in pixels: its path, arrowhead, dashed zero line, and where its letter is placed. */
export interface Arc {
  readonly path: string;
  readonly head: string;
  readonly dashed: string;
  readonly middle: Pixel;
  readonly outward: Pixel;
}

const RADIUS = 34;

/** Return the arc of joint i (from 0); null for a prismatic or hidden joint angle, and for an angle near zero. */
export function arcOf(arm: Arm, state: State, view: View, i: number): Arc | null {
  const joint = arm.joints[i]!;
  if (joint.kind !== "R") return null;
  const before = state.frames[i]!;
  const [angle] = thetaAndD(joint, state.pose[i]!);
  const turn = Math.atan2(Math.sin(angle), Math.cos(angle));
  if (Math.abs(turn) < 0.06) return null;
  const [x, y] = pixel(view, before.o);
  const [sx, sy] = vectorInPixels(view, before.x);
  const towardReader = dot(before.z, view.towardReader);
  const start = Math.atan2(-sy, sx);
  const spin = towardReader > 0 ? turn : -turn; // positive counterclockwise on the page
  const at = (share: number, radius: number): Pixel => [
    x + radius * Math.cos(start + share * spin),
    y - radius * Math.sin(start + share * spin),
  ];
  const [p, q] = [at(0, RADIUS), at(1, RADIUS)];
  const back = Math.max(0, 1 - 7 / (RADIUS * Math.abs(spin)));
  const [left, right] = [at(back, RADIUS - 3), at(back, RADIUS + 3)];
  const dashEnd = at(0, RADIUS + 12);
  const middle = at(0.5, RADIUS + 2);
  const large = Math.abs(spin) > Math.PI ? 1 : 0;
  return {
    path: `M${p[0]} ${p[1]}A${RADIUS} ${RADIUS} 0 ${large} ${spin > 0 ? 0 : 1} ${q[0]} ${q[1]}`,
    head: `M${q[0]} ${q[1]}L${left[0]} ${left[1]}L${right[0]} ${right[1]}Z`,
    dashed: `M${x} ${y}L${dashEnd[0]} ${dashEnd[1]}`,
    middle,
    outward: [middle[0] - x, middle[1] - y],
  };
}

export function Angles({ arm, state, view }: { arm: Arm; state: State; view: View }): JSX.Element {
  return (
    <g class="arm-angles">
      {arm.joints.map(({ name }, i) => {
        const arc = arcOf(arm, state, view, i);
        return arc ? (
          <g key={name} class={jointClass(i)}>
            <path class="arm-dashed" d={arc.dashed} />
            <path class="arm-arc" d={arc.path} />
            <path class="arm-head" d={arc.head} />
          </g>
        ) : null;
      })}
    </g>
  );
}
