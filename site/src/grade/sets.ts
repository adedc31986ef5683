// Sets of configurations: is every pose of the reference covered, and is every pose that is claimed singular?
//
// Poses on what is claimed are searched for from random starts by Gauss-Newton steps; what is singular is told by the arm.

import type { ConfigurationsKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { read } from "../read/reader.js";
import { digitsOfDecimals, type Node, ReadError } from "../read/tree.js";
import { message } from "../text/text.js";
import { type Piece, pieces } from "./pieces.js";
import { type At, correct, graded, missing, unreadable, type Verdict } from "./verdict.js";
import { atText, isBlank } from "./values.js";

/** How near a pose must be to a condition, in radians or metres. */
const NEAR = 1e-6;
const STARTS = 12;
const STEPS = 40;
const NUDGE = 1e-6;
const TURN = 2 * Math.PI;

/** Tells whether the arm is singular in a pose. */
export type IsSingular = (at: At) => boolean;

interface Space {
  readonly joints: readonly string[];
  readonly angles: ReadonlySet<string>;
}

/** Judge conditions; `angles` are the joints of which a whole turn is no difference. */
export function judgeSet(
  answer: string,
  key: ConfigurationsKey,
  angles: ReadonlySet<string>,
  isSingular: IsSingular,
): Verdict {
  if (!answer.trim()) return missing();
  const space = { joints: key.joints, angles };
  try {
    const tree = read(answer, new Set(key.symbols));
    if (isBlank(tree)) return missing();
    return compared(pieces(tree, new Set(key.joints)), key, space, isSingular);
  } catch (error) {
    if (error instanceof ReadError) return unreadable(error.why);
    throw error;
  }
}

function compared(
  claims: readonly Piece[],
  key: ConfigurationsKey,
  space: Space,
  isSingular: IsSingular,
): Verdict {
  const poses = key.pieces.map((piece) => piece.map((pose) => posed(key, pose)));
  const lengths = poses.flat();
  const uncovered = poses.map((piece) =>
    piece.find((at) => !claims.some((claim) => holds(claim, at, space))),
  );
  const unsound = claims.map((claim, i) => counterexample(claim, lengths, space, isSingular, i));
  const bad = unsound.filter((each) => each !== null);
  const covered = uncovered.filter((at) => at === undefined).length;
  if (covered === poses.length && bad.length === 0) return correct(message("verdict.set"), false);
  const share = Math.min(Math.max(0, covered - bad.length) / poses.length, 0.99);
  const off = bad.find((each) => each !== "nowhere");
  if (off) return graded(share, [message("verdict.unsound", { at: atText(shown(off, space)) })], { at: off });
  const open = uncovered.find((at) => at !== undefined);
  if (open)
    return graded(share, [message("verdict.uncovered", { at: atText(shown(open, space)) })], { at: open });
  return graded(share, [message("verdict.nowhere", { text: String(unsound.indexOf("nowhere") + 1) })]);
}

function posed(key: ConfigurationsKey, pose: readonly number[]): At {
  return Object.fromEntries(key.symbols.map((symbol, i) => [symbol, pose[i] as number]));
}

function shown(at: At, { joints }: Space): At {
  return Object.fromEntries(joints.map((joint) => [joint, at[joint] as number]));
}

// --- is a pose on a piece? ---

function holds(piece: Piece, at: At, space: Space): boolean {
  return piece.every((atom) => {
    const { re, im, size } = evaluate(atom.zero, at);
    if (atom.joint !== null)
      return Math.abs(im) < NEAR && distance(atom.joint, at[atom.joint] as number, re, space) < NEAR;
    if (!Number.isFinite(re)) return false;
    const slope = Math.hypot(...space.joints.map((joint) => slopeOf(atom.zero, at, joint)));
    return Math.hypot(re, im) <= Math.max(NEAR * slope, 1e-11 * size);
  });
}

function distance(joint: string, a: number, b: number, { angles }: Space): number {
  const apart = Math.abs(a - b);
  if (!angles.has(joint)) return apart;
  const turned = apart % TURN;
  return Math.min(turned, TURN - turned);
}

function slopeOf(zero: Piece[number]["zero"], at: At, joint: string): number {
  const above = evaluate(zero, { ...at, [joint]: (at[joint] as number) + NUDGE }).re;
  const below = evaluate(zero, { ...at, [joint]: (at[joint] as number) - NUDGE }).re;
  return (above - below) / (2 * NUDGE);
}

// --- poses on what is claimed ---

/** A pose on a piece in which the arm is not singular; null where all are, "nowhere" where there is none. */
function counterexample(
  piece: Piece,
  lengths: readonly At[],
  space: Space,
  isSingular: IsSingular,
  seed: number,
): At | "nowhere" | null {
  const random = stream(seed + 1);
  let found = 0;
  for (let start = 0; start < STARTS; start += 1) {
    const given = lengths[start % Math.max(lengths.length, 1)] ?? {};
    const at = solved(piece, randomPose(given, space, random), space);
    if (!at) continue;
    found += 1;
    if (!isSingular(at)) return at;
  }
  return found > 0 ? null : "nowhere";
}

function randomPose(given: At, { joints, angles }: Space, random: () => number): At {
  const values = joints.map((joint) => [joint, angles.has(joint) ? TURN * (random() - 0.5) : 0.2 + random()]);
  return { ...given, ...Object.fromEntries(values) };
}

/** The pose moved onto the piece: values assigned, the free joints moved by Gauss-Newton steps of least norm. */
function solved(piece: Piece, start: At, space: Space): At | null {
  const assigned = new Set(piece.map((atom) => atom.joint));
  const free = space.joints.filter((joint) => !assigned.has(joint));
  const zeros = piece.filter((atom) => atom.joint === null).map((atom) => atom.zero);
  let at = assign(piece, start);
  for (let step = 0; at && zeros.length > 0 && step < STEPS; step += 1) {
    const here = at;
    const values = zeros.map((zero) => evaluate(zero, here).re);
    const rows = zeros.map((zero) => free.map((joint) => slopeOf(zero, here, joint)));
    const moves = leastNorm(rows, values);
    if (!moves || moves.some((move) => !Number.isFinite(move))) return null;
    at = assign(piece, {
      ...here,
      ...Object.fromEntries(
        free.map((joint, i) => [joint, (here[joint] as number) - limited(moves[i] as number)]),
      ),
    });
    if (Math.max(0, ...moves.map(Math.abs)) < 1e-12) break;
  }
  return at && holds(piece, at, space) ? at : null;
}

function limited(move: number): number {
  return Math.max(-1, Math.min(1, move));
}

function assign(piece: Piece, at: At): At | null {
  let found = at;
  for (let round = 0; round < 2; round += 1) {
    for (const { joint, zero } of piece) {
      if (joint === null) continue;
      const { re, im } = evaluate(zero, found);
      if (!Number.isFinite(re) || Math.abs(im) > NEAR) return null;
      found = { ...found, [joint]: re };
    }
  }
  return found;
}

/** The shortest x with A x = b, by the normal equations of A Aᵀ; null where its rows depend on each other. */
function leastNorm(a: readonly (readonly number[])[], b: readonly number[]): number[] | null {
  const gram = a.map((row, i) => [
    ...a.map((other, j) => dot(row, other) + (i === j ? 1e-14 : 0)),
    b[i] as number,
  ]);
  const weights = eliminated(gram);
  if (!weights) return null;
  return (a[0] ?? []).map((_, j) =>
    a.reduce((sum, row, i) => sum + (row[j] as number) * (weights[i] as number), 0),
  );
}

function dot(a: readonly number[], b: readonly number[]): number {
  return a.reduce((sum, value, i) => sum + value * (b[i] as number), 0);
}

/** The solution of a small system, its right sides in the last column, by elimination with pivots. */
function eliminated(system: readonly (readonly number[])[]): number[] | null {
  const rows = system.map((row) => [...row]);
  const n = rows.length;
  for (let k = 0; k < n; k += 1) {
    const pivot = rows
      .slice(k)
      .reduce(
        (best, row, i) => (Math.abs(row[k] as number) > Math.abs(rows[best]?.[k] as number) ? k + i : best),
        k,
      );
    [rows[k], rows[pivot]] = [rows[pivot] as number[], rows[k] as number[]];
    const top = rows[k] as number[];
    if (!(Math.abs(top[k] as number) > 1e-13)) return null;
    for (let i = 0; i < n; i += 1) {
      const row = rows[i] as number[];
      if (i === k) continue;
      const factor = (row[k] as number) / (top[k] as number);
      row.forEach((value, j) => (row[j] = value - factor * (top[j] as number)));
    }
  }
  return rows.map((row, k) => (row[n] as number) / (row[k] as number));
}

/** Random numbers from 0 to 1 that are the same each time (mulberry32). */
function stream(seed: number): () => number {
  let state = seed * 0x9e3779b9;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

// --- angles ---

/** Whether two sets of angles are the same, modulo whole turns; typed decimals mean what they say. */
export function sameAngles(mine: readonly Node[], right: readonly number[]): boolean {
  const space = { joints: ["angle"], angles: new Set(["angle"]) };
  const found = mine.map((angle) => {
    const digits = digitsOfDecimals(angle);
    return { value: evaluate(angle, {}).re, room: digits > 0 && digits < 16 ? 1e-15 : 1e-9 };
  });
  const near = (one: (typeof found)[number], due: number) =>
    distance("angle", one.value, due, space) < one.room;
  return (
    found.every((one) => right.some((due) => near(one, due))) &&
    right.every((due) => found.some((one) => near(one, due)))
  );
}
