// Draw the path over the arm: the part that the arm can follow, and the rest.

import type { JSX } from "preact";

import { type Journey, pointOn } from "./path.js";
import { pixel, type Pixel, type View } from "./view.js";

export function Route({ journey, view, place }: { journey: Journey; view: View; place: number }): JSX.Element {
  const { path, stations } = journey;
  const ends = [0, stations.at(-1)!.s, path.length].map((s) => pixel(view, pointOn(path, s)));
  const [[ax, ay], [ex, ey], [bx, by]] = ends as [Pixel, Pixel, Pixel];
  const [px, py] = pixel(view, pointOn(path, place));
  return (
    <g class="arm-path">
      <path class="arm-path-rest" d={`M${ex} ${ey}L${bx} ${by}`} />
      <path class="arm-path-way" d={`M${ax} ${ay}L${ex} ${ey}`} />
      <path class="arm-path-done" d={`M${ax} ${ay}L${px} ${py}`} />
      <circle cx={ax} cy={ay} r={3.4} />
    </g>
  );
}
