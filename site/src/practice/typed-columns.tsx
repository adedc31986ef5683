// The columns of a typed Jacobian, dashed in the drawing beside the true ones.

import { Arrow } from "../arm/line-drawing.js";
import { speedScale } from "../arm/marks.js";
import type { Overlay, OverlayStage } from "../arm/panel.js";
import { add, scaleVector, type Vec3 } from "../arm/vector.js";
import type { ColumnsAt } from "../grade/typed-jacobian.js";
import { jointClass } from "../arm/letters.js";
import { namedPose } from "../arm/model.js";

/** Return what draws the columns of a typed Jacobian at P. */
export function drawTypedColumns(columns: ColumnsAt): Overlay {
  const vectorsAt = ({ arm, robot, state }: OverlayStage): readonly Vec3[] => {
    const vectors = columns({ ...robot.values, ...namedPose(arm, state.pose) });
    return (vectors ?? []).map((column) => scaleVector(column as unknown as Vec3, speedScale(arm)));
  };
  return {
    draw: (stage, view) => (
      <g class="arm-own">
        {vectorsAt(stage).map((vector, i) => (
          <Arrow key={i} view={view} start={stage.state.point} vector={vector} className={jointClass(i)} />
        ))}
      </g>
    ),
    linesAt: (stage) => vectorsAt(stage).map((vector) => [stage.state.point, add(stage.state.point, vector)]),
  };
}
