// Where the letters of a drawing stand: beside what they name, clear of each other and of the arm as far as can be.

import { plainLetters } from "./letters.js";
import type { Pixel } from "./view.js";

/** A label wanted at `at`, on the side `toward` (a direction on the page) if it is free; `width` in pixels. */
export interface Wanted {
  readonly name: string;
  readonly style: string;
  readonly at: Pixel;
  readonly toward: Pixel;
  /** Pixels that are to be left free besides (the half width of a body). */
  readonly gap?: number;
}

export interface Placed {
  readonly name: string;
  readonly style: string;
  readonly x: number;
  readonly y: number;
}

const [HALF_WIDTH, HALF_HEIGHT] = [11, 9];
const TURNS = [0, 35, -35, 70, -70, 110, -110, 150, -150, 180].map((angle) => (angle * Math.PI) / 180);
const AWAY = [15, 23];

/** Places for labels in their order; `lines` are what they should not cover, corner by corner. */
export function placed(
  wanted: readonly Wanted[],
  lines: readonly (readonly Pixel[])[],
  width: number,
  height: number,
): Placed[] {
  const taken: Pixel[] = [];
  const covered = lines.flatMap(sampled);
  return wanted.map(({ name, style, at, toward, gap = 0 }) => {
    const half = Math.max(HALF_WIDTH, 4 * plainLetters(name).length);
    const heading = Math.hypot(...toward) > 1e-6 ? Math.atan2(toward[1], toward[0]) : -Math.PI / 4;
    let best: Pixel = at;
    let least = Infinity;
    for (const away of AWAY) {
      TURNS.forEach((turn, k) => {
        const out = away + gap + (half - HALF_WIDTH) * Math.abs(Math.cos(heading + turn));
        const spot: Pixel = [at[0] + out * Math.cos(heading + turn), at[1] + out * Math.sin(heading + turn)];
        const cost =
          40 * taken.filter((other) => near(spot, other, 2)).length +
          6 * covered.filter((other) => near(spot, other, 1)).length +
          (spot[0] < half + 1 || spot[0] > width - half - 1 || spot[1] < 10 || spot[1] > height - 10
            ? 200
            : 0) +
          k +
          (away - AWAY[0]!) / 4;
        if (cost < least) [best, least] = [spot, cost];
      });
    }
    for (let x = -half + HALF_WIDTH; x <= half - HALF_WIDTH; x += HALF_WIDTH)
      taken.push([best[0] + x, best[1]]);
    return { name, style, x: best[0], y: best[1] };
  });
}

function near(a: Pixel, b: Pixel, boxes: number): boolean {
  return Math.abs(a[0] - b[0]) < boxes * HALF_WIDTH && Math.abs(a[1] - b[1]) < boxes * HALF_HEIGHT;
}

function sampled(line: readonly Pixel[]): Pixel[] {
  return line.slice(1).flatMap((end, k) => {
    const start = line[k]!;
    const count = Math.max(1, Math.ceil(Math.hypot(end[0] - start[0], end[1] - start[1]) / 9));
    return Array.from({ length: count + 1 }, (_, i): Pixel => {
      const t = i / count;
      return [start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])];
    });
  });
}
