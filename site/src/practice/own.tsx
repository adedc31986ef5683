// The columns of a Jacobian that was typed, dashed in the drawing beside the true ones.

import type { JSX } from "preact";

import { Arrow } from "../arm/flat.js";
import { speedScale } from "../arm/marks.js";
import type { Stage } from "../arm/stage.js";
import { scaled, type Vec3 } from "../arm/vector.js";
import type { View } from "../arm/view.js";
import type { OwnColumns } from "../grade/own.js";
import { jointClass } from "../arm/letters.js";
import { namedPose } from "../arm/model.js";

type OwnProps = { readonly stage: Stage; readonly view: View; readonly columns: OwnColumns };

export function Own({ stage: { arm, state }, view, columns }: OwnProps): JSX.Element | null {
  const drawn = columns(namedPose(arm, state.pose));
  if (!drawn) return null;
  const by = speedScale(arm);
  return (
    <g class="arm-own">
      {drawn.map((column, i) => (
        <Arrow
          key={i}
          view={view}
          from={state.point}
          vector={scaled(column as unknown as Vec3, by)}
          style={jointClass(i)}
        />
      ))}
    </g>
  );
}
