// The colours of the map: one hue for positive values, another for negative ones, the paper's colour at zero.

import type { Terrain } from "./terrain.js";

type Rgb = readonly [number, number, number];

/** Paint a terrain on a canvas, one pixel per inner grid point; the page smooths the image. */
export function shade(canvas: HTMLCanvasElement | null, { grid, max }: Terrain, signed: boolean): void {
  const context = canvas?.getContext("2d");
  if (!canvas || !context) return;
  const color = (name: string): Rgb => rgbOf(colorOf(canvas, name));
  const [paper, above, below] = [color("--arm-paper"), color("--arm-above"), color("--arm-below")];
  const [columns, rows] = [grid.us.length - 2, grid.vs.length - 2];
  canvas.width = columns;
  canvas.height = rows;
  const image = context.createImageData(columns, rows);
  grid.values.slice(1, -1).forEach((row, j) =>
    row.slice(1, -1).forEach((value, i) => {
      const depth = max > 0 ? Math.abs(value / max) ** 0.7 : 0;
      const toward = signed && value < 0 ? below : above;
      const at = 4 * ((rows - 1 - j) * columns + i);
      paper.forEach((part, k) => (image.data[at + k] = part + depth * (toward[k]! - part)));
      image.data[at + 3] = 255;
    }),
  );
  context.putImageData(image, 0, 0);
}

/** Return the colour of a CSS custom property in an element, in the current light or dark scheme: "rgb(r, g, b)". */
export function colorOf(element: HTMLElement, name: string): string {
  const before = element.style.color;
  element.style.color = `var(${name})`;
  const color = getComputedStyle(element).color;
  element.style.color = before;
  return color;
}

function rgbOf(text: string): Rgb {
  const [red = 0, green = 0, blue = 0] = (text.match(/[\d.]+/g) ?? []).map(Number);
  return [red, green, blue];
}
