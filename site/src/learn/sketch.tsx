// A small figure of an arm in a pose, with the columns of J at P, for the explanation of a lesson.

import type { JSX } from "preact";
import { useMemo } from "preact/hooks";

import { jointClass } from "../arm/letters.js";
import { Arrow, Body } from "../arm/line-drawing.js";
import { drawnColumns } from "../arm/marks.js";
import { type Arm, reachOf, stateAt } from "../arm/model.js";
import { extentOf } from "../arm/ranges.js";
import { FIRST_ORBIT, toPixel, viewOf } from "../arm/view.js";
import { say } from "../text/text.js";

const [WIDTH, HEIGHT] = [300, 220];

/** The figure; `degrees` are the joint angles. */
export function Sketch({ arm, degrees }: { readonly arm: Arm; readonly degrees: readonly number[] }): JSX.Element {
  const { state, view, reach, columns } = useMemo(() => {
    const reach = reachOf(arm);
    const state = stateAt(
      arm,
      degrees.map((angle) => (angle * Math.PI) / 180),
    );
    const view = viewOf(arm, extentOf(arm), WIDTH, HEIGHT, FIRST_ORBIT);
    return { state, view, reach, columns: drawnColumns(arm, state, reach) };
  }, [arm, degrees]);
  const [x, y] = toPixel(view, state.point);
  const angles = degrees.map((angle, i) => `θ${i + 1} = ${angle}°`).join(", ");
  const caption = say("lesson.sketch", { angles });
  return (
    <div class="sketch">
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={caption}>
        <Body arm={arm} state={state} view={view} reach={reach} />
        {columns.map((vector, i) => (
          <Arrow key={i} view={view} start={state.point} vector={vector} className={`arm-column ${jointClass(i)}`} />
        ))}
        <circle class="arm-point-dot" cx={x} cy={y} r={4} />
      </svg>
      <p class="muted">{caption}</p>
    </div>
  );
}
