// Place labels beside what they name, clear of each other and, if possible, of the arm. A distant label gets a leader
// line; a label without room is left out.

import { partsOf } from "./letters.js";
import type { Pixel } from "./view.js";

/** A label wanted at `at`, on the side `toward` (a direction on the page) if it is free; `width` in pixels. */
export interface Wanted {
  readonly name: string;
  readonly style: string;
  readonly at: Pixel;
  readonly toward: Pixel;
  /** Pixels that are to be left free besides (the half width of a body). */
  readonly gap?: number;
  /** Whether it is left out where there is no room just beside: at an arrow's head nobody looks for a line. */
  readonly beside?: boolean;
}

/** Boxes of a drawing, in its pixels, over which words or buttons lie. */
export type Covered = readonly Readonly<Record<"left" | "right" | "top" | "bottom", number>>[];

/** Where letters may stand: in a drawing of so many pixels, but not under what lies over it. */
export type Room = { readonly width: number; readonly height: number; readonly covered: Covered };

export interface Placed {
  readonly name: string;
  readonly style: string;
  readonly x: number;
  readonly y: number;
  /** What it names, where that is too far away to be seen by itself. */
  readonly from: Pixel | null;
}

/** The half of a label, in pixels. */
type Half = { readonly width: number; readonly height: number };

const HALF_HEIGHT = 9;
const TURNS = [0, 35, -35, 70, -70, 110, -110, 150, -150, 180].map((angle) => (angle * Math.PI) / 180);
/** How far away the edge of a label is tried, ring by ring. */
const AWAY: readonly number[] = [4, 12, 22, 34, 49, 67];
/** So many rings are just beside. */
const BESIDE = 2;
/** From here on a line leads back. */
const FAR = 30;
/** What it costs to cover another label (never done) or the arm, to be out of sight, and to be a ring further out. */
const [OVER_LABEL, OVER_ARM, OVER_EDGE, RING] = [1000, 6, 400, 5];

/** Places for labels in the order of their rank; `lines` are what they should not cover, corner by corner. */
export function placed(wanted: readonly Wanted[], lines: readonly (readonly Pixel[])[], room: Room): Placed[] {
  const taken: { at: Pixel; half: Half }[] = [];
  const inTheWay = lines.flatMap(sampled);
  const found: Placed[] = [];
  for (const { name, style, at, toward, gap = 0, beside = false } of [...wanted].sort(
    (a, b) => rankOf(a) - rankOf(b),
  )) {
    const half = halfOf(name);
    const heading = Math.hypot(...toward) > 1e-6 ? Math.atan2(toward[1], toward[0]) : -Math.PI / 4;
    let best: Pixel = at;
    let least = Infinity;
    (beside ? AWAY.slice(0, BESIDE) : AWAY).forEach((away, ring) => {
      if (least < RING * ring) return; // nothing further out is better
      TURNS.forEach((turn, k) => {
        const angle = heading + turn;
        const edge = half.width * Math.abs(Math.cos(angle)) + 0.8 * HALF_HEIGHT * Math.abs(Math.sin(angle));
        const out = away + gap + edge;
        const spot: Pixel = [at[0] + out * Math.cos(angle), at[1] + out * Math.sin(angle)];
        let cost = RING * ring + 0.4 * k + (isInside(spot, half, room) ? 0 : OVER_EDGE);
        if (cost >= least) return;
        for (const other of taken) if (areOver(spot, half, other.at, other.half)) cost += OVER_LABEL;
        for (const other of inTheWay) {
          if (cost >= least) return;
          if (areOver(spot, half, other, POINT)) cost += OVER_ARM;
        }
        if (cost < least) [best, least] = [spot, cost];
      });
    });
    if (least >= OVER_EDGE) continue;
    taken.push({ at: best, half });
    const isFar = Math.hypot(best[0] - at[0], best[1] - at[1]) > FAR + gap + half.width;
    found.push({ name, style, x: best[0], y: best[1], from: isFar ? at : null });
  }
  return found;
}

const POINT: Half = { width: 2, height: 2 };

/** The order of placing: the point and the ends of a path, joints, columns of J, lengths, then frames. */
function rankOf({ name, style }: Wanted): number {
  if (/^[PAB]/.test(name)) return 0;
  if (/^(theta|d)\d/.test(name) && style !== "arm-length") return 1;
  if (/^J\d/.test(name)) return 2;
  if (style === "arm-length") return 3;
  return name.startsWith("O") ? 4 : 5;
}

/** Half the room of a label, as its letters are set: an index is small, a sign of equality stands free. */
function halfOf(name: string): Half {
  const width = name.split("=").reduce((sum, one, k) => {
    const [letter, star, index] = partsOf(one);
    const plain = /^[\d.,−]+$/.test(letter) ? 7.6 : 11;
    return sum + (k > 0 ? 19 : 0) + plain * [...letter].length + 7 * (star.length + index.length);
  }, 3);
  return { width: width / 2, height: HALF_HEIGHT };
}

function isInside([x, y]: Pixel, half: Half, { width, height, covered }: Room): boolean {
  return (
    x > half.width + 1 &&
    x < width - half.width - 1 &&
    y > HALF_HEIGHT + 1 &&
    y < height - HALF_HEIGHT - 1 &&
    covered.every(
      ({ left, right, top, bottom }) =>
        x + half.width < left || x - half.width > right || y + HALF_HEIGHT < top || y - HALF_HEIGHT > bottom,
    )
  );
}

function areOver(a: Pixel, halfA: Half, b: Pixel, halfB: Half): boolean {
  return Math.abs(a[0] - b[0]) < halfA.width + halfB.width && Math.abs(a[1] - b[1]) < halfA.height + halfB.height;
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
