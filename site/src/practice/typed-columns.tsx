// The columns of a typed Jacobian, dashed in the drawing beside the true ones.

import type { JSX } from "preact";

import { Arrow } from "../arm/line-drawing.js";
import { speedScale } from "../arm/marks.js";
import type { Stage } from "../arm/stage.js";
import { scaleVector, type Vec3 } from "../arm/vector.js";
import type { View } from "../arm/view.js";
import type { ColumnsAt } from "../grade/typed-jacobian.js";
import { jointClass } from "../arm/letters.js";
import { namedPose } from "../arm/model.js";

type TypedColumnsProps = { readonly stage: Stage; readonly view: View; readonly columns: ColumnsAt };

export function TypedColumns({ stage: { arm, robot, state }, view, columns }: TypedColumnsProps): JSX.Element | null {
  const vectors = columns({ ...robot.values, ...namedPose(arm, state.pose) });
  if (!vectors) return null;
  const scale = speedScale(arm);
  return (
    <g class="arm-own">
      {vectors.map((column, i) => (
        <Arrow
          key={i}
          view={view}
          start={state.point}
          vector={scaleVector(column as unknown as Vec3, scale)}
          className={jointClass(i)}
        />
      ))}
    </g>
  );
}
