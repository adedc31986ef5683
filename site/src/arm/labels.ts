// Place labels beside what they name, without overlaps and, if possible, without covering the arm. A distant label gets
// a leader line; a label without room is omitted.

import { splitName } from "./letters.js";
import type { Pixel } from "./view.js";

/** A label wanted near `place` (pixels), preferably in a direction from there (in pixels, y down). */
export interface WantedLabel {
  readonly name: string;
  readonly className: string;
  readonly place: Pixel;
  readonly direction: Pixel;
  /** Distance from `place` to be left free (pixels), such as half the width of a joint's body. */
  readonly gap?: number;
  /** Whether the label must be just beside `place`, or is omitted: nobody looks for a leader line at an arrow's head. */
  readonly isClose?: boolean;
}

/** Boxes of a drawing, in its pixels, that texts or buttons cover. */
export type Covered = readonly Readonly<Record<"left" | "right" | "top" | "bottom", number>>[];

/** Where labels may be placed: within width x height pixels, but not in covered boxes. */
type LabelRoom = { readonly width: number; readonly height: number; readonly covered: Covered };

interface PlacedLabel {
  readonly name: string;
  readonly className: string;
  readonly x: number;
  readonly y: number;
  /** Where a leader line starts, if the label is far from what it names; else null. */
  readonly leaderStart: Pixel | null;
}

/** Half the width and height of a box, in pixels. */
type HalfSize = { readonly width: number; readonly height: number };

const HALF_HEIGHT = 9;
const ANGLES_TRIED = [0, 35, -35, 70, -70, 110, -110, 150, -150, 180].map((angle) => (angle * Math.PI) / 180);
/** Distances at which the edge of a label is tried, ring by ring (pixels). */
const RINGS: readonly number[] = [4, 12, 22, 34, 49, 67];
/** Number of rings that count as close. */
const CLOSE_RINGS = 2;
/** From this distance on, a label gets a leader line (pixels). */
const MIN_LEADER_DISTANCE = 30;
/** Costs of covering a label, the arm, or the room's edge (the first and last are never accepted), and of each ring. */
const [OVER_LABEL, OVER_ARM, OVER_EDGE, FURTHER_RING] = [1000, 6, 400, 5];

/** Return labels, placed by rank; `lines` are polylines (pixels) that labels should not cover. */
export function placeLabels(
  wantedLabels: readonly WantedLabel[],
  lines: readonly (readonly Pixel[])[],
  room: LabelRoom,
): PlacedLabel[] {
  const placedBoxes: { place: Pixel; half: HalfSize }[] = [];
  const obstacles = lines.flatMap(samplePoints);
  const labels: PlacedLabel[] = [];
  const byRank = [...wantedLabels].sort((a, b) => rankOf(a) - rankOf(b));
  for (const { name, className, place: wantedPlace, direction, gap = 0, isClose = false } of byRank) {
    const half = halfOf(name);
    const heading = Math.hypot(...direction) > 1e-6 ? Math.atan2(direction[1], direction[0]) : -Math.PI / 4;
    let bestPlace: Pixel = wantedPlace;
    let leastCost = Infinity;
    (isClose ? RINGS.slice(0, CLOSE_RINGS) : RINGS).forEach((distance, ring) => {
      if (leastCost < FURTHER_RING * ring) return; // nothing further out is better
      ANGLES_TRIED.forEach((turn, k) => {
        const angle = heading + turn;
        const distanceToEdge = half.width * Math.abs(Math.cos(angle)) + 0.8 * HALF_HEIGHT * Math.abs(Math.sin(angle));
        const distanceToCentre = distance + gap + distanceToEdge;
        const place: Pixel = addPolar(wantedPlace, distanceToCentre, angle);
        let cost = FURTHER_RING * ring + 0.4 * k + (isInside(place, half, room) ? 0 : OVER_EDGE);
        if (cost >= leastCost) return;
        for (const box of placedBoxes) if (overlap(place, half, box.place, box.half)) cost += OVER_LABEL;
        for (const obstacle of obstacles) {
          if (cost >= leastCost) return;
          if (overlap(place, half, obstacle, POINT)) cost += OVER_ARM;
        }
        if (cost < leastCost) [bestPlace, leastCost] = [place, cost];
      });
    });
    if (leastCost >= OVER_EDGE) continue;
    placedBoxes.push({ place: bestPlace, half });
    const isFar =
      Math.hypot(bestPlace[0] - wantedPlace[0], bestPlace[1] - wantedPlace[1]) > MIN_LEADER_DISTANCE + gap + half.width;
    labels.push({ name, className, x: bestPlace[0], y: bestPlace[1], leaderStart: isFar ? wantedPlace : null });
  }
  return labels;
}

/** Return the place at a distance from another one, at an angle (y down). */
const addPolar = ([x, y]: Pixel, distance: number, angle: number): Pixel => [
  x + distance * Math.cos(angle),
  y + distance * Math.sin(angle),
];

const POINT: HalfSize = { width: 2, height: 2 };

/** Return the order of placing: the point and the ends of a path, joints, columns of J, lengths, then frames. */
function rankOf({ name, className }: WantedLabel): number {
  if (/^[PAB]/.test(name)) return 0;
  if (/^(theta|d)\d/.test(name) && className !== "arm-length") return 1;
  if (/^J\d/.test(name)) return 2;
  if (className === "arm-length") return 3;
  return name.startsWith("O") ? 4 : 5;
}

/** Return half the size of a label: an index is small, and spaces surround an equals sign. */
function halfOf(name: string): HalfSize {
  const width = name.split("=").reduce((sum, part, k) => {
    const [letter, star, index] = splitName(part);
    const widthOfLetter = /^[\d.,−]+$/.test(letter) ? 7.6 : 11;
    return sum + (k > 0 ? 19 : 0) + widthOfLetter * [...letter].length + 7 * (star.length + index.length);
  }, 3);
  return { width: width / 2, height: HALF_HEIGHT };
}

function isInside([x, y]: Pixel, half: HalfSize, { width, height, covered }: LabelRoom): boolean {
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

function overlap(a: Pixel, halfA: HalfSize, b: Pixel, halfB: HalfSize): boolean {
  return Math.abs(a[0] - b[0]) < halfA.width + halfB.width && Math.abs(a[1] - b[1]) < halfA.height + halfB.height;
}

/** The maximum number of points of a side of a polyline: an arrow may be very much longer than the page. */
const MAX_SAMPLES = 300;

/** Return points along a polyline, about 9 pixels apart. */
function samplePoints(line: readonly Pixel[]): Pixel[] {
  return line.slice(1).flatMap((end, k) => {
    const start = line[k]!;
    const count = Math.max(1, Math.ceil(Math.hypot(end[0] - start[0], end[1] - start[1]) / 9));
    return Array.from({ length: Math.min(count, MAX_SAMPLES) + 1 }, (_, i): Pixel => {
      const t = i / count;
      return [start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])];
    });
  });
}
