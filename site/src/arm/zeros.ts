// Where J loses rank on a map over two joints: lines by marching squares, and spots at which the value touches zero.

import type { SingularityKind } from "./classify.js";

/** A place on the map: the values of its two joints (rad or m). */
export type Spot = readonly [u: number, v: number];

/** Values at cell centres (u_i, v_j), `values[j][i]`, with one more row around, so lines reach the range's ends. */
export interface Grid {
  readonly us: readonly number[];
  readonly vs: readonly number[];
  readonly values: readonly (readonly number[])[];
}

/** A line or, if it has one spot, an isolated spot of the singular set, all of one kind. */
export type Stretch = { readonly kind: SingularityKind | "unknown"; readonly spots: readonly Spot[] };

export function gridOf([u0, u1]: Spot, [v0, v1]: Spot, count: number, value: ValueFunction): Grid {
  const cellCentres = (low: number, high: number): number[] =>
    Array.from({ length: count + 2 }, (_, i) => low + ((high - low) * (i - 0.5)) / count);
  const [us, vs] = [cellCentres(u0, u1), cellCentres(v0, v1)];
  return { us, vs, values: vs.map((v) => us.map((u) => value(u, v))) };
}

type ValueFunction = (u: number, v: number) => number;

/** Return where a line crosses the edge from grid point (i, j) to the next one across or up; null if none does. */
type Crossing = (i: number, j: number, isAcross: boolean) => Spot | null;

/** Steps of the fine grid in a step of the coarse grid. The fine grid separates lines that are close to each other. */
const FINE_STEPS = 4;

/** Return the lines on which a value changes sign, each as a list of spots refined by the function itself. */
export function findZeroLines(grid: Grid, value: ValueFunction): Spot[][] {
  const fineGrid = { us: refine(grid.us), vs: refine(grid.vs) };
  const knownValues = new Map<number, number>();
  const valueAt = (i: number, j: number): number => {
    if (i % FINE_STEPS === 0 && j % FINE_STEPS === 0) return grid.values[j / FINE_STEPS]![i / FINE_STEPS]!;
    const key = j * fineGrid.us.length + i;
    const computedValue = knownValues.get(key) ?? value(fineGrid.us[i]!, fineGrid.vs[j]!);
    knownValues.set(key, computedValue);
    return computedValue;
  };
  const findCrossing: Crossing = (i, j, isAcross) => {
    const [k, l] = isAcross ? [i + 1, j] : [i, j + 1];
    if (valueAt(i, j) >= 0 === valueAt(k, l) >= 0) return null;
    return bisect(value, [fineGrid.us[i]!, fineGrid.vs[j]!], [fineGrid.us[k]!, fineGrid.vs[l]!]);
  };
  const cells: Spot[] = [];
  for (const [i, j] of cellsNearZero(grid)) {
    for (let b = 0; b < FINE_STEPS; b += 1) {
      for (let a = 0; a < FINE_STEPS; a += 1) cells.push([FINE_STEPS * i + a, FINE_STEPS * j + b]);
    }
  }
  return linkCrossings(cells, findCrossing, (i, j) => {
    const [u, v] = [(fineGrid.us[i]! + fineGrid.us[i + 1]!) / 2, (fineGrid.vs[j]! + fineGrid.vs[j + 1]!) / 2];
    return value(u, v) >= 0 === valueAt(i, j) >= 0;
  });
}

/** Return the lines on which a value is zero without changing its sign: minima of its size below `zeroTolerance`. */
export function findZeroMinimumLines({ us, vs, values }: Grid, value: ValueFunction, zeroTolerance: number): Spot[][] {
  const findCrossing: Crossing = (i, j, isAcross) => {
    const valueAt = (step: number): number =>
      Math.abs((isAcross ? values[j]?.[i + step] : values[j + step]?.[i]) ?? Infinity);
    if (valueAt(-1) <= valueAt(0) || valueAt(2) <= valueAt(1)) return null;
    const [k, l] = isAcross ? [i + 1, j] : [i, j + 1];
    if (values[j]![i]! >= 0 !== values[l]![k]! >= 0) return null;
    const spot = findMinimumBetween(value, [us[i]!, vs[j]!], [us[k]!, vs[l]!]);
    return Math.abs(value(...spot)) < zeroTolerance ? spot : null;
  };
  const cells = vs.slice(1).flatMap((_, j) => us.slice(1).map((_u, i): Spot => [i, j]));
  return linkCrossings(cells, findCrossing, null);
}

/** Return places with `FINE_STEPS` steps between neighbours. */
function refine(places: readonly number[]): number[] {
  const [first, ...others] = places;
  const steps = others.flatMap((place, i) =>
    Array.from({ length: FINE_STEPS }, (_, k) => places[i]! + ((k + 1) * (place - places[i]!)) / FINE_STEPS),
  );
  return [first!, ...steps];
}

/** Return the cells through which a line of zeros may run, judged by the values around them. */
function cellsNearZero({ us, vs, values }: Grid): Spot[] {
  const cells: Spot[] = [];
  for (let j = 0; j + 1 < vs.length; j += 1) {
    for (let i = 0; i + 1 < us.length; i += 1) {
      const neighbours = values.slice(Math.max(0, j - 1), j + 3).flatMap((row) => row.slice(Math.max(0, i - 1), i + 3));
      const corners = [values[j]![i]!, values[j]![i + 1]!, values[j + 1]![i]!, values[j + 1]![i + 1]!];
      const range = Math.max(...neighbours) - Math.min(...neighbours);
      const hasSignChange = corners.filter((corner) => corner >= 0).length % 4 !== 0;
      if (hasSignChange || Math.min(...corners.map(Math.abs)) < range / 4) cells.push([i, j]);
    }
  }
  return cells;
}

/** Return crossings linked to lines; if a cell has four, `joinsLowAndRight` decides how they are paired. */
function linkCrossings(
  cells: readonly Spot[],
  findCrossing: Crossing,
  joinsLowAndRight: ((i: number, j: number) => boolean) | null,
): Spot[][] {
  const spots = new Map<string, Spot | null>();
  const links = new Map<string, string[]>();
  const keyOfCrossing = (i: number, j: number, isAcross: boolean): string | null => {
    const key = `${i},${j},${isAcross ? "u" : "v"}`;
    if (!spots.has(key)) spots.set(key, findCrossing(i, j, isAcross));
    return spots.get(key) ? key : null;
  };
  const link = (a: string, b: string): void => {
    links.set(a, [...(links.get(a) ?? []), b]);
    links.set(b, [...(links.get(b) ?? []), a]);
  };
  for (const [i, j] of cells) {
    const edges = [
      keyOfCrossing(i, j, true),
      keyOfCrossing(i + 1, j, false),
      keyOfCrossing(i, j + 1, true),
      keyOfCrossing(i, j, false),
    ];
    const [low, right, high, left] = edges;
    const crossedEdges = edges.filter((key) => key !== null);
    if (crossedEdges.length === 2) link(crossedEdges[0]!, crossedEdges[1]!);
    if (crossedEdges.length === 4) {
      const pairs =
        joinsLowAndRight === null
          ? [low, high, left, right]
          : joinsLowAndRight(i, j)
            ? [low, right, high, left]
            : [low, left, high, right];
      link(pairs[0]!, pairs[1]!);
      link(pairs[2]!, pairs[3]!);
    }
  }
  return chainLinks(spots as ReadonlyMap<string, Spot>, links);
}

/** Return the lowest spot between two, of a value with a minimum there (golden section). */
function findMinimumBetween(value: ValueFunction, a: Spot, b: Spot): Spot {
  const spotAt = interpolate(a, b);
  const sizeAt = (t: number): number => Math.abs(value(...spotAt(t)));
  let [low, high] = [0, 1];
  for (let k = 0; k < 48; k += 1) {
    const [x, y] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    if (sizeAt(x) < sizeAt(y)) high = y;
    else low = x;
  }
  return spotAt((low + high) / 2);
}

/** Return a function that returns the spot at a share of the way from one spot to another. */
export const interpolate =
  ([u0, v0]: Spot, [u1, v1]: Spot) =>
  (share: number): Spot => [u0 + share * (u1 - u0), v0 + share * (v1 - v0)];

const GOLDEN = (Math.sqrt(5) - 1) / 2;

function bisect(value: ValueFunction, a: Spot, b: Spot): Spot {
  let [low, high] = [0, 1];
  const spotAt = interpolate(a, b);
  const sign = value(...a) >= 0;
  for (let k = 0; k < 40; k += 1) {
    const middle = (low + high) / 2;
    if (value(...spotAt(middle)) >= 0 === sign) low = middle;
    else high = middle;
  }
  return spotAt((low + high) / 2);
}

/** Return linked crossings as lines; a closed line ends at its start. */
function chainLinks(spots: ReadonlyMap<string, Spot>, links: ReadonlyMap<string, readonly string[]>): Spot[][] {
  const unusedKeys = new Set(links.keys());
  const ends = [...unusedKeys].filter((key) => links.get(key)!.length === 1);
  const lines: Spot[][] = [];
  for (const start of [...ends, ...unusedKeys]) {
    if (!unusedKeys.has(start)) continue;
    const keys: string[] = [];
    for (let key: string | undefined = start; key !== undefined;) {
      unusedKeys.delete(key);
      keys.push(key);
      key = links.get(key)!.find((next) => unusedKeys.has(next));
    }
    const isClosed = keys.length > 2 && links.get(keys.at(-1)!)!.includes(start);
    lines.push((isClosed ? [...keys, start] : keys).map((key) => spots.get(key)!));
  }
  return lines;
}

/** Return the spots at which a nonnegative value is zero: minima on the grid, refined, below `zeroTolerance`. */
export function findZeroMinima(grid: Grid, value: ValueFunction, zeroTolerance: number): Spot[] {
  const { us, vs, values } = grid;
  const spots: Spot[] = [];
  const [du, dv] = [us[1]! - us[0]!, vs[1]! - vs[0]!];
  const largest = Math.max(...values.flat());
  for (let j = 0; j < vs.length; j += 1) {
    for (let i = 0; i < us.length; i += 1) {
      const gridValue = values[j]![i]!;
      if (gridValue > 0.25 * largest) continue;
      const neighbours = NEIGHBOURS.map(([a, b]) => values[j + b]?.[i + a] ?? Infinity);
      if (neighbours.some((other) => other < gridValue)) continue;
      const spot = descend(value, [us[i]!, vs[j]!], du, dv);
      const isNew = spots.every(([u, v]) => Math.abs(u - spot[0]) + Math.abs(v - spot[1]) > 0.2 * (du + dv));
      if (value(...spot) < zeroTolerance && isNew) spots.push(spot);
    }
  }
  return spots;
}

/** The steps to the eight neighbours of a grid point. */
const NEIGHBOURS = [-1, 0, 1]
  .flatMap((a) => [-1, 0, 1].map((b): Spot => [a, b]))
  .filter(([a, b]) => a !== 0 || b !== 0);

/** Return the lowest spot that smaller and smaller steps find. */
function descend(value: ValueFunction, start: Spot, du: number, dv: number): Spot {
  let spot = start;
  let leastValue = value(...spot);
  for (let step = 1; step > 1e-7;) {
    let bestSpot = spot;
    for (const [a, b] of NEIGHBOURS) {
      const next: Spot = [spot[0] + a * step * du, spot[1] + b * step * dv];
      const nextValue = value(...next);
      if (nextValue < leastValue) [bestSpot, leastValue] = [next, nextValue];
    }
    if (bestSpot === spot) step /= 2;
    spot = bestSpot;
  }
  return spot;
}

/** Return a line cut where its kind changes. The kind is asked at every few spots, and between two that differ. */
export function cutByKind(
  line: readonly Spot[],
  step: number,
  kind: (spot: Spot) => SingularityKind | "unknown",
): Stretch[] {
  const knownKinds = new Map<number, SingularityKind | "unknown">();
  const kindAt = (index: number): SingularityKind | "unknown" => {
    const kindHere = knownKinds.get(index) ?? kind(line[index]!);
    knownKinds.set(index, kindHere);
    return kindHere;
  };
  const kinds: (SingularityKind | "unknown")[] = [];
  const fillKinds = (from: number, to: number): void => {
    if (to - from <= 1 || kindAt(from) === kindAt(to)) {
      for (let k = from; k < to; k += 1) kinds[k] = k - from < (to - from) / 2 ? kindAt(from) : kindAt(to);
      return;
    }
    const middle = Math.floor((from + to) / 2);
    fillKinds(from, middle);
    fillKinds(middle, to);
  };
  const last = line.length - 1;
  for (let k = 0; k < last; k += step) fillKinds(k, Math.min(k + step, last));
  kinds[last] = kindAt(last);
  const pieces: Stretch[] = [];
  let start = 0;
  for (let k = 1; k <= last + 1; k += 1) {
    if (k <= last && kinds[k] === kinds[start]) continue;
    pieces.push({ kind: kinds[start]!, spots: line.slice(start, Math.min(k, last) + 1) });
    start = k;
  }
  return pieces.filter(({ spots }) => spots.length > 1);
}
