// The colours of the map: one hue above zero, another below, the paper's own colour at zero.

import type { Terrain } from "./terrain.js";

type Rgb = readonly [number, number, number];

/** Paint a terrain on a canvas, one pixel for each inner point of the grid; the page smooths it. */
export function shade(canvas: HTMLCanvasElement | null, { grid, most }: Terrain, signed: boolean): void {
  const context = canvas?.getContext("2d");
  if (!canvas || !context) return;
  const style = getComputedStyle(canvas);
  const color = (name: string): Rgb => rgbOf(style.getPropertyValue(name));
  const [paper, above, below] = [color("--arm-paper"), color("--arm-above"), color("--arm-below")];
  const [columns, rows] = [grid.us.length - 2, grid.vs.length - 2];
  canvas.width = columns;
  canvas.height = rows;
  const image = context.createImageData(columns, rows);
  grid.values.slice(1, -1).forEach((row, j) =>
    row.slice(1, -1).forEach((value, i) => {
      const depth = most > 0 ? Math.abs(value / most) ** 0.7 : 0;
      const toward = signed && value < 0 ? below : above;
      const at = 4 * ((rows - 1 - j) * columns + i);
      paper.forEach((part, k) => (image.data[at + k] = part + depth * (toward[k]! - part)));
      image.data[at + 3] = 255;
    }),
  );
  context.putImageData(image, 0, 0);
}

/** The parts of "#rrggbb" or "#rgb". */
function rgbOf(text: string): Rgb {
  const digits = text.trim().slice(1);
  const whole = digits.length === 3 ? [...digits].map((digit) => digit + digit).join("") : digits;
  const number = parseInt(whole, 16) || 0;
  return [(number >> 16) & 255, (number >> 8) & 255, number & 255];
}
