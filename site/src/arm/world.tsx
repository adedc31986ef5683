// The world frame in a drawing, with the base's place in it as dashed legs along its axes; nothing where they agree.

import type { JSX } from "preact";

import { Arrow, ofPixels } from "./flat.js";
import type { Wanted } from "./labels.js";
import type { Arm } from "./model.js";
import { norm, subtract, type Vec3, ZERO } from "./vector.js";
import { drawn, pixel, type Pixel, type View } from "./view.js";

const AXES: readonly Vec3[] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const LENGTH = 40;

/** Whether the base stands elsewhere than the world frame, or is turned in it. */
function isApart({ base }: Arm): boolean {
  return (
    norm(base.o) > 1e-9 || norm(subtract(base.x, AXES[0]!)) > 1e-9 || norm(subtract(base.z, AXES[2]!)) > 1e-9
  );
}

/** The corners of the way from the world's origin to the base, along its axes one after the other. */
export function wayToBase({ base: { o } }: Arm): readonly Vec3[] {
  return [ZERO, [o[0], 0, 0], [o[0], o[1], 0], o];
}

interface WorldProps {
  readonly arm: Arm;
  readonly view: View;
  readonly flat: boolean;
}

export function World({ arm, view, flat }: WorldProps): JSX.Element | null {
  if (!isApart(arm)) return null;
  const corners = wayToBase(arm);
  return (
    <g class="arm-world">
      <path class="arm-dashed" d={`M${corners.map((corner) => pixel(view, corner).join(" ")).join("L")}`} />
      {AXES.map((axis, k) =>
        flat && Math.hypot(...drawn(view, axis)) < 1e-6 ? null : (
          <Arrow key={k} view={view} from={ZERO} vector={ofPixels(view, axis, LENGTH)} style="arm-w" />
        ),
      )}
    </g>
  );
}

/** The letters of the world frame: its axes, and its origin where the base stands elsewhere. */
export function worldLabels(arm: Arm, view: View, flat: boolean): Wanted[] {
  if (!isApart(arm)) return [];
  const [x, y] = pixel(view, ZERO);
  const wanted = AXES.flatMap((axis, k): Wanted[] => {
    const way = drawn(view, ofPixels(view, axis, LENGTH));
    const at: Pixel = [x + way[0], y + way[1]];
    return flat && Math.hypot(...way) < 1 ? [] : [{ name: `${"xyz"[k]}_w`, style: "arm-w", at, toward: way }];
  });
  if (norm(arm.base.o) > 1e-9) wanted.push({ name: "O_w", style: "arm-w", at: [x, y], toward: [-0.7, 0.7] });
  return wanted;
}
