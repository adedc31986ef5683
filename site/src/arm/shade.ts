// The colours of the map: one hue for positive values, another for negative ones, the paper's colour at zero.

import type { Terrain } from "./terrain.js";

/** Paint a terrain on a canvas, one pixel per inner grid point; the page smooths the image. */
export function paintTerrain(canvas: HTMLCanvasElement | null, { grid, max }: Terrain, isSigned: boolean): void {
  const context = canvas?.getContext("2d");
  if (!canvas || !context) return;
  const color = (name: string): number[] =>
    colorOf(canvas, name)
      .match(/[\d.]+/g)!
      .map(Number);
  const [zeroColor, positiveColor, negativeColor] = [color("--arm-paper"), color("--arm-above"), color("--arm-below")];
  const [columns, rows] = [grid.us.length - 2, grid.vs.length - 2];
  canvas.width = columns;
  canvas.height = rows;
  const image = context.createImageData(columns, rows);
  grid.values.slice(1, -1).forEach((row, j) =>
    row.slice(1, -1).forEach((value, i) => {
      const depth = max > 0 ? Math.abs(value / max) ** 0.7 : 0;
      const fullColor = isSigned && value < 0 ? negativeColor : positiveColor;
      const firstByte = 4 * ((rows - 1 - j) * columns + i);
      const mixedColor = [0, 1, 2].map((channel) => (1 - depth) * zeroColor[channel]! + depth * fullColor[channel]!);
      image.data.set([...mixedColor, 255], firstByte);
    }),
  );
  context.putImageData(image, 0, 0);
}

/** Return the colour of a CSS custom property in an element, in the current light or dark scheme: "rgb(r, g, b)". */
export function colorOf(element: HTMLElement, name: string): string {
  const previousColor = element.style.color;
  element.style.color = `var(${name})`;
  const color = getComputedStyle(element).color;
  element.style.color = previousColor;
  return color;
}
