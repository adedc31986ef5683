// Where J loses rank on a map over two joints: lines by marching squares, and spots at which the value touches zero.

import type { SingularityKind } from "./classify.js";

export type Spot = readonly [u: number, v: number];

/** Values at cell centres (u_i, v_j), `values[j][i]`, with one more row around, so lines reach the range's ends. */
export interface Grid {
  readonly us: readonly number[];
  readonly vs: readonly number[];
  readonly values: readonly (readonly number[])[];
}

export type Stretch = { readonly kind: SingularityKind | "unknown"; readonly spots: readonly Spot[] };

export function gridOf([u0, u1]: Spot, [v0, v1]: Spot, count: number, value: Value): Grid {
  const spaced = (low: number, high: number): number[] =>
    Array.from({ length: count + 2 }, (_, i) => low + ((high - low) * (i - 0.5)) / count);
  const [us, vs] = [spaced(u0, u1), spaced(v0, v1)];
  return { us, vs, values: vs.map((v) => us.map((u) => value(u, v))) };
}

type Value = (u: number, v: number) => number;

/** Return where a line crosses the edge of the grid at (i, j), across or up; null if none does. */
type Crossing = (i: number, j: number, across: boolean) => Spot | null;

/** Steps of the fine grid in a step of the coarse grid. The fine grid separates lines that are close to each other. */
const FINER = 4;

/** Return the lines on which a value changes sign, each as a list of spots refined by the function itself. */
export function zeroLines(grid: Grid, value: Value): Spot[][] {
  const fine = { us: finer(grid.us), vs: finer(grid.vs) };
  const known = new Map<number, number>();
  const at = (i: number, j: number): number => {
    if (i % FINER === 0 && j % FINER === 0) return grid.values[j / FINER]![i / FINER]!;
    const key = j * fine.us.length + i;
    const here = known.get(key) ?? value(fine.us[i]!, fine.vs[j]!);
    known.set(key, here);
    return here;
  };
  const crossing: Crossing = (i, j, across) => {
    const [k, l] = across ? [i + 1, j] : [i, j + 1];
    if (at(i, j) >= 0 === at(k, l) >= 0) return null;
    return bisected(value, [fine.us[i]!, fine.vs[j]!], [fine.us[k]!, fine.vs[l]!]);
  };
  const cells: Spot[] = [];
  for (const [i, j] of cellsNearZero(grid)) {
    for (let b = 0; b < FINER; b += 1) {
      for (let a = 0; a < FINER; a += 1) cells.push([FINER * i + a, FINER * j + b]);
    }
  }
  return linesThrough(cells, crossing, (i, j) => {
    const [u, v] = [(fine.us[i]! + fine.us[i + 1]!) / 2, (fine.vs[j]! + fine.vs[j + 1]!) / 2];
    return value(u, v) >= 0 === at(i, j) >= 0;
  });
}

/** Return the lines on which a value that keeps its sign touches zero. */
export function valleys({ us, vs, values }: Grid, value: Value, zero: number): Spot[][] {
  const crossing: Crossing = (i, j, across) => {
    const valueAt = (step: number): number =>
      Math.abs((across ? values[j]?.[i + step] : values[j + step]?.[i]) ?? Infinity);
    if (valueAt(-1) <= valueAt(0) || valueAt(2) <= valueAt(1)) return null;
    const [k, l] = across ? [i + 1, j] : [i, j + 1];
    if (values[j]![i]! >= 0 !== values[l]![k]! >= 0) return null;
    const spot = lowest(value, [us[i]!, vs[j]!], [us[k]!, vs[l]!]);
    return Math.abs(value(...spot)) < zero ? spot : null;
  };
  const cells = vs.slice(1).flatMap((_, j) => us.slice(1).map((_u, i): Spot => [i, j]));
  return linesThrough(cells, crossing, null);
}

/** Return places with `FINER` steps between neighbours. */
function finer(places: readonly number[]): number[] {
  const [first, ...others] = places;
  const steps = others.flatMap((place, i) =>
    Array.from({ length: FINER }, (_, k) => places[i]! + ((k + 1) * (place - places[i]!)) / FINER),
  );
  return [first!, ...steps];
}

/** Return the cells through which a line of zeros may run, judged by the values around them. */
function cellsNearZero({ us, vs, values }: Grid): Spot[] {
  const cells: Spot[] = [];
  for (let j = 0; j + 1 < vs.length; j += 1) {
    for (let i = 0; i + 1 < us.length; i += 1) {
      const around = values.slice(Math.max(0, j - 1), j + 3).flatMap((row) => row.slice(Math.max(0, i - 1), i + 3));
      const corners = [values[j]![i]!, values[j]![i + 1]!, values[j + 1]![i]!, values[j + 1]![i + 1]!];
      const differ = Math.max(...around) - Math.min(...around);
      const signs = corners.filter((corner) => corner >= 0).length % 4 !== 0;
      if (signs || Math.min(...corners.map(Math.abs)) < differ / 4) cells.push([i, j]);
    }
  }
  return cells;
}

/** Return crossings linked to lines; if a cell has four, `joinsLowAndRight` decides how they are paired. */
function linesThrough(
  cells: readonly Spot[],
  crossing: Crossing,
  joinsLowAndRight: ((i: number, j: number) => boolean) | null,
): Spot[][] {
  const spots = new Map<string, Spot | null>();
  const links = new Map<string, string[]>();
  const edge = (i: number, j: number, across: boolean): string | null => {
    const key = `${i},${j},${across ? "u" : "v"}`;
    if (!spots.has(key)) spots.set(key, crossing(i, j, across));
    return spots.get(key) ? key : null;
  };
  const link = (a: string, b: string): void => {
    links.set(a, [...(links.get(a) ?? []), b]);
    links.set(b, [...(links.get(b) ?? []), a]);
  };
  for (const [i, j] of cells) {
    const edges = [edge(i, j, true), edge(i + 1, j, false), edge(i, j + 1, true), edge(i, j, false)];
    const [low, right, high, left] = edges;
    const crossed = edges.filter((key) => key !== null);
    if (crossed.length === 2) link(crossed[0]!, crossed[1]!);
    if (crossed.length === 4) {
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
  return chains(spots as ReadonlyMap<string, Spot>, links);
}

/** Return the lowest spot between two, of a value with a minimum there (golden section). */
function lowest(value: Value, a: Spot, b: Spot): Spot {
  const at = between(a, b);
  const level = (t: number): number => Math.abs(value(...at(t)));
  let [low, high] = [0, 1];
  for (let k = 0; k < 48; k += 1) {
    const [x, y] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    if (level(x) < level(y)) high = y;
    else low = x;
  }
  return at((low + high) / 2);
}

const between =
  ([u, v]: Spot, b: Spot) =>
  (t: number): Spot => [u + t * (b[0] - u), v + t * (b[1] - v)];

const GOLDEN = (Math.sqrt(5) - 1) / 2;

function bisected(value: Value, a: Spot, b: Spot): Spot {
  let [low, high] = [0, 1];
  const at = between(a, b);
  const sign = value(...a) >= 0;
  for (let k = 0; k < 40; k += 1) {
    const middle = (low + high) / 2;
    if (value(...at(middle)) >= 0 === sign) low = middle;
    else high = middle;
  }
  return at((low + high) / 2);
}

/** Return linked crossings as lines; a closed line ends at its start. */
function chains(spots: ReadonlyMap<string, Spot>, links: ReadonlyMap<string, readonly string[]>): Spot[][] {
  const open = new Set(links.keys());
  const ends = [...open].filter((key) => links.get(key)!.length === 1);
  const lines: Spot[][] = [];
  for (const start of [...ends, ...open]) {
    if (!open.has(start)) continue;
    const run: string[] = [];
    for (let key: string | undefined = start; key !== undefined;) {
      open.delete(key);
      run.push(key);
      key = links.get(key)!.find((next) => open.has(next));
    }
    const closed = run.length > 2 && links.get(run.at(-1)!)!.includes(start);
    lines.push((closed ? [...run, start] : run).map((key) => spots.get(key)!));
  }
  return lines;
}

/** Return the spots at which a value that is never negative is zero: minima on the grid, refined by smaller steps. */
export function minima(grid: Grid, value: Value, zero: number): Spot[] {
  const { us, vs, values } = grid;
  const spots: Spot[] = [];
  const [du, dv] = [us[1]! - us[0]!, vs[1]! - vs[0]!];
  const largest = Math.max(...values.flat());
  for (let j = 0; j < vs.length; j += 1) {
    for (let i = 0; i < us.length; i += 1) {
      const here = values[j]![i]!;
      if (here > 0.25 * largest) continue;
      const around = NEIGHBOURS.map(([a, b]) => values[j + b]?.[i + a] ?? Infinity);
      if (around.some((other) => other < here)) continue;
      const spot = descend(value, [us[i]!, vs[j]!], du, dv);
      const isNew = spots.every(([u, v]) => Math.abs(u - spot[0]) + Math.abs(v - spot[1]) > 0.2 * (du + dv));
      if (value(...spot) < zero && isNew) spots.push(spot);
    }
  }
  return spots;
}

/** The steps to the eight neighbours of a grid point. */
const NEIGHBOURS = [-1, 0, 1]
  .flatMap((a) => [-1, 0, 1].map((b): Spot => [a, b]))
  .filter(([a, b]) => a !== 0 || b !== 0);

/** Return the lowest spot that smaller and smaller steps find. */
function descend(value: Value, start: Spot, du: number, dv: number): Spot {
  let spot = start;
  let least = value(...spot);
  for (let step = 1; step > 1e-7;) {
    let best = spot;
    for (const [a, b] of NEIGHBOURS) {
      const next: Spot = [spot[0] + a * step * du, spot[1] + b * step * dv];
      const there = value(...next);
      if (there < least) [best, least] = [next, there];
    }
    if (best === spot) step /= 2;
    spot = best;
  }
  return spot;
}

/** Return a line cut where its kind changes. The kind is asked at every few spots, and between two that differ. */
export function cutByKind(
  line: readonly Spot[],
  every: number,
  kind: (spot: Spot) => SingularityKind | "unknown",
): Stretch[] {
  const known = new Map<number, SingularityKind | "unknown">();
  const at = (index: number): SingularityKind | "unknown" => {
    const kindHere = known.get(index) ?? kind(line[index]!);
    known.set(index, kindHere);
    return kindHere;
  };
  const kinds: (SingularityKind | "unknown")[] = [];
  const fill = (from: number, to: number): void => {
    if (to - from <= 1 || at(from) === at(to)) {
      for (let k = from; k < to; k += 1) kinds[k] = k - from < (to - from) / 2 ? at(from) : at(to);
      return;
    }
    const middle = Math.floor((from + to) / 2);
    fill(from, middle);
    fill(middle, to);
  };
  const last = line.length - 1;
  for (let k = 0; k < last; k += every) fill(k, Math.min(k + every, last));
  kinds[last] = at(last);
  const pieces: Stretch[] = [];
  let start = 0;
  for (let k = 1; k <= last + 1; k += 1) {
    if (k <= last && kinds[k] === kinds[start]) continue;
    pieces.push({ kind: kinds[start]!, spots: line.slice(start, Math.min(k, last) + 1) });
    start = k;
  }
  return pieces.filter(({ spots }) => spots.length > 1);
}
