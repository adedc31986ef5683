// Where J loses rank on a map over two joints: lines by marching squares, and places where the value touches zero.

import type { Kind } from "./classify.js";

export type Spot = readonly [u: number, v: number];

/**
 * Values at (u_i, v_j), the middles of cells, and of one row of cells more around: `values[j][i]`. Lines on the edges
 * of the ranges and at round angles run between these places, not through them.
 */
export interface Grid {
  readonly us: readonly number[];
  readonly vs: readonly number[];
  readonly values: readonly (readonly number[])[];
}

export interface Stretch {
  readonly kind: Kind | "unknown";
  readonly spots: readonly Spot[];
}

export function gridOf(
  [u0, u1]: Spot,
  [v0, v1]: Spot,
  count: number,
  value: (u: number, v: number) => number,
): Grid {
  const even = (low: number, high: number): number[] =>
    Array.from({ length: count + 2 }, (_, i) => low + ((high - low) * (i - 0.5)) / count);
  const [us, vs] = [even(u0, u1), even(v0, v1)];
  return { us, vs, values: vs.map((v) => us.map((u) => value(u, v))) };
}

/** The zero lines of a grid as runs of spots, each refined with the function itself. */
export function zeroLines(grid: Grid, value: (u: number, v: number) => number): Spot[][] {
  const { us, vs, values } = grid;
  const spots = new Map<string, Spot>();
  const links = new Map<string, string[]>();
  const positive = (i: number, j: number): boolean => values[j]![i]! >= 0;
  const edge = (i: number, j: number, across: boolean): string | null => {
    const [k, l] = across ? [i + 1, j] : [i, j + 1];
    if (positive(i, j) === positive(k, l)) return null;
    const key = `${i},${j},${across ? "u" : "v"}`;
    if (!spots.has(key)) spots.set(key, bisected(value, [us[i]!, vs[j]!], [us[k]!, vs[l]!]));
    return key;
  };
  const link = (a: string, b: string): void => {
    links.set(a, [...(links.get(a) ?? []), b]);
    links.set(b, [...(links.get(b) ?? []), a]);
  };
  for (let j = 0; j + 1 < vs.length; j += 1) {
    for (let i = 0; i + 1 < us.length; i += 1) {
      const met = [edge(i, j, true), edge(i + 1, j, false), edge(i, j + 1, true), edge(i, j, false)];
      const [low, right, high, left] = met;
      const found = met.filter((key) => key !== null);
      if (found.length === 2) link(found[0]!, found[1]!);
      if (found.length === 4) {
        const middle = value((us[i]! + us[i + 1]!) / 2, (vs[j]! + vs[j + 1]!) / 2) >= 0;
        const pairs = middle === positive(i, j) ? [low, right, high, left] : [low, left, high, right];
        link(pairs[0]!, pairs[1]!);
        link(pairs[2]!, pairs[3]!);
      }
    }
  }
  return runs(spots, links);
}

function bisected(value: (u: number, v: number) => number, a: Spot, b: Spot): Spot {
  let [low, high] = [0, 1];
  const at = (t: number): Spot => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
  const sign = value(...a) >= 0;
  for (let k = 0; k < 40; k += 1) {
    const middle = (low + high) / 2;
    if (value(...at(middle)) >= 0 === sign) low = middle;
    else high = middle;
  }
  return at((low + high) / 2);
}

function runs(spots: ReadonlyMap<string, Spot>, links: ReadonlyMap<string, readonly string[]>): Spot[][] {
  const left = new Set(links.keys());
  const ends = [...left].filter((key) => links.get(key)!.length === 1);
  const found: Spot[][] = [];
  for (const start of [...ends, ...left]) {
    if (!left.has(start)) continue;
    const run: string[] = [];
    for (let key: string | undefined = start; key !== undefined;) {
      left.delete(key);
      run.push(key);
      key = links.get(key)!.find((next) => left.has(next));
    }
    const closed = run.length > 2 && links.get(run.at(-1)!)!.includes(start);
    found.push((closed ? [...run, start] : run).map((key) => spots.get(key)!));
  }
  return found;
}

/** Places where a value that is never negative comes down to zero: least points of the grid, refined by smaller steps. */
export function touches(grid: Grid, value: (u: number, v: number) => number, zero: number): Spot[] {
  const { us, vs, values } = grid;
  const found: Spot[] = [];
  const [du, dv] = [us[1]! - us[0]!, vs[1]! - vs[0]!];
  const most = Math.max(...values.flat());
  for (let j = 0; j < vs.length; j += 1) {
    for (let i = 0; i < us.length; i += 1) {
      const here = values[j]![i]!;
      if (here > 0.25 * most) continue;
      const around = [-1, 0, 1].flatMap((b) => [-1, 0, 1].map((a) => values[j + b]?.[i + a] ?? Infinity));
      if (around.some((other) => other < here)) continue;
      const spot = descended(value, [us[i]!, vs[j]!], du, dv);
      const isNew = found.every(([u, v]) => Math.abs(u - spot[0]) + Math.abs(v - spot[1]) > 0.2 * (du + dv));
      if (value(...spot) < zero && isNew) found.push(spot);
    }
  }
  return found;
}

function descended(value: (u: number, v: number) => number, start: Spot, du: number, dv: number): Spot {
  let spot = start;
  let least = value(...spot);
  for (let step = 1; step > 1e-7;) {
    let best = spot;
    for (const [a, b] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
      [1, 1],
      [-1, -1],
      [1, -1],
      [-1, 1],
    ] as const) {
      const next: Spot = [spot[0] + a * step * du, spot[1] + b * step * dv];
      const there = value(...next);
      if (there < least) [best, least] = [next, there];
    }
    if (best === spot) step /= 2;
    spot = best;
  }
  return spot;
}

/** A line cut where its kind changes; the kind is asked at every few spots and between two that differ. */
export function stretches(
  line: readonly Spot[],
  every: number,
  kind: (spot: Spot) => Kind | "unknown",
): Stretch[] {
  const known = new Map<number, Kind | "unknown">();
  const at = (index: number): Kind | "unknown" => {
    const before = known.get(index);
    const found = before ?? kind(line[index]!);
    known.set(index, found);
    return found;
  };
  const kinds: (Kind | "unknown")[] = [];
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
  const found: Stretch[] = [];
  let start = 0;
  for (let k = 1; k <= last + 1; k += 1) {
    if (k <= last && kinds[k] === kinds[start]) continue;
    found.push({ kind: kinds[start]!, spots: line.slice(start, Math.min(k, last) + 1) });
    start = k;
  }
  return found.filter(({ spots }) => spots.length > 1);
}
