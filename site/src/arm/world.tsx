// The world frame in a drawing, and the base's position as dashed lines; nothing if base and world frame coincide.

import type { JSX } from "preact";

import { Arrow, headLabel, lengthInPixels, type NamedArrow, vectorOfLength } from "./line-drawing.js";
import type { WantedLabel } from "./labels.js";
import type { Arm } from "./model.js";
import { norm, subtract, type Vec3, ZERO } from "./vector.js";
import { toPixel, type View } from "./view.js";

const AXES: readonly Vec3[] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const AXIS_LENGTH = 40;

/** Return whether the base frame differs from the world frame. */
function isBaseMoved({ base }: Arm): boolean {
  return norm(base.o) > 1e-9 || norm(subtract(base.x, AXES[0]!)) > 1e-9 || norm(subtract(base.z, AXES[2]!)) > 1e-9;
}

/** Return the corners of the way from the world's origin to the base, along the world's axes one after the other. */
export const wayToBase = ({ base: { o } }: Arm): readonly Vec3[] => [ZERO, [o[0], 0, 0], [o[0], o[1], 0], o];

/** Return the axes of the world frame that are visible. */
function worldAxes(view: View, isFlat: boolean): NamedArrow[] {
  return AXES.map((axis, k) => ({
    name: `${"xyz"[k]}_w`,
    className: "arm-w",
    start: ZERO,
    vector: vectorOfLength(view, axis, AXIS_LENGTH),
  })).filter((arrow) => !isFlat || lengthInPixels(view, arrow) >= 1);
}

type WorldProps = { readonly arm: Arm; readonly view: View; readonly isFlat: boolean };

export function World({ arm, view, isFlat }: WorldProps): JSX.Element | null {
  if (!isBaseMoved(arm)) return null;
  const corners = wayToBase(arm);
  return (
    <g class="arm-world">
      <path class="arm-dashed" d={`M${corners.map((corner) => toPixel(view, corner).join(" ")).join("L")}`} />
      {worldAxes(view, isFlat).map(({ name, ...arrow }) => (
        <Arrow key={name} view={view} {...arrow} />
      ))}
    </g>
  );
}

/** Return the labels of the world frame: its axes, and its origin if the base is elsewhere. */
export function worldLabels(arm: Arm, view: View, isFlat: boolean): WantedLabel[] {
  if (!isBaseMoved(arm)) return [];
  const labels = worldAxes(view, isFlat).map((axis) => headLabel(view, axis));
  if (norm(arm.base.o) > 1e-9)
    labels.push({ name: "O_w", className: "arm-w", place: toPixel(view, ZERO), direction: [-0.7, 0.7] });
  return labels;
}
