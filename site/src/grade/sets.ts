// Sets of configurations: is every pose of the reference covered, and is every pose that is claimed singular?
//
// Gauss-Newton steps from random starts find poses on what is claimed; the arm tells whether they are singular. As in
// ../../../grader/formulas.py, only true claims earn anything: a claim that always holds covers everything.

import { damped } from "../arm/svd.js";
import type { ConfigurationsKey } from "../bank.js";
import { randomNumbers } from "../random.js";
import { evaluate } from "../read/evaluate.js";
import { withPointsOfLengths } from "../read/notation.js";
import { withPoints } from "../read/points.js";
import { read } from "../read/reader.js";
import { sizeOf } from "../read/products.js";
import {
  anyNode,
  CHAIN,
  chainOf,
  hasBlank,
  integer,
  name,
  namesIn,
  type Node,
  node,
  ReadError,
  replaced,
} from "../read/tree.js";
import { LIMITS, VOCABULARY } from "../read/vocabulary.js";
import { message, type Message } from "../text/text.js";
import { type Atom, claimedPieces, type Piece } from "./pieces.js";
import { falseConditions, shareOfSet } from "./credit.js";
import { slipsInSet } from "./set-slips.js";
import { type At, correct, graded, ifRead, missing, type Verdict, wrong } from "./verdict.js";
import { isBlank } from "./forms.js";
import { anyNumber, atText } from "./values.js";

/** How near a pose must be to a condition, in radians or metres; to a value, of which keys tell nine decimals. */
const NEAR = 1e-6;
const STATED = 1e-9;
/** How near a value must be that was typed, of its size; one that is so near is the one that is expected, rounded. */
const TYPED = 1e-12;
const ROUNDED = 5e-3;
const STARTS = 12;
const STEPS = 40;
const NUDGE = 1e-6;
/** What keeps steps short where conditions depend on each other. */
const DAMPING = 1e-7;
const TURN = 2 * Math.PI;
/** What is smaller, of the size of its terms, is rounding. */
const ROUNDING = 4e-16;
/** Where no pose is found, so many are looked at; none may come so near to zero, relative to its terms. */
const LOOKED_AT = 2000;
const NEAR_MISS = 1e-3;

/** Tells whether the arm is singular in a pose. */
export type IsSingular = (at: At) => boolean;

type Space = { readonly joints: readonly string[]; readonly angles: ReadonlySet<string> };

/** What else it takes to say what went wrong: all symbols, and what the table adds to variables of joints. */
type Table = Space & { readonly symbols: readonly string[]; readonly offsets: ReadonlyMap<string, number> };

/** Judge conditions; for joints in `angles` whole turns don't count, and the table adds `offsets` to them. */
export function judgeSet(
  typed: string,
  key: ConfigurationsKey,
  angles: ReadonlySet<string>,
  isSingular: IsSingular,
  offsets: ReadonlyMap<string, number> = new Map(),
): Verdict {
  if (!typed.trim()) return missing();
  const answer = withPointsOfLengths(typed);
  const space = { joints: key.joints, angles, offsets, symbols: key.symbols };
  return ifRead(() => {
    const tree = read(answer, new Set(key.symbols));
    if (isBlank(tree)) return missing();
    const said = withoutBlanks(counted(tree));
    const refused = unclear(answer, said, key);
    if (refused) return refused;
    const claims = claimedPieces(assigned(said, space), new Set(key.joints));
    return compared(claims, posesOf(key, said), space, isSingular);
  });
}

/** For each condition the poses on each of its pieces. */
type Conditions = readonly (readonly At[])[][];

/** The poses on each piece of each condition that has any; a name that the problem does not have is any number. */
function posesOf(key: ConfigurationsKey, tree: Node): Conditions {
  const unknown = [...namesIn(tree)].filter((each) => !key.symbols.includes(each));
  const poseOf = (values: readonly number[], k: number): At => ({
    ...Object.fromEntries(unknown.map((each) => [each, anyNumber(each, k)])),
    ...Object.fromEntries(key.symbols.map((symbol, i) => [symbol, values[i] as number])),
  });
  let start = 0;
  const ofConditions = (key.conditions ?? [key.pieces.length]).map((count) =>
    key.pieces.slice(start, (start += count)).filter((piece) => piece.length > 0),
  );
  return ofConditions.filter((pieces) => pieces.length > 0).map((pieces) => pieces.map((piece) => piece.map(poseOf)));
}

/** Put the listed values of an integer in, as in theta2 = k*pi, k = 0, 1. With dots after them it is any integer. */
function counted(tree: Node): Node {
  const at = tree.kind === "list" ? tree.args.findIndex(isWholeNumber) : 0;
  const behind = tree.args.slice(at + 1);
  const isMore = ({ kind }: Node): boolean => ["eq", "in", "and", "or", "dict", "list"].includes(kind);
  if (at <= 0 || behind.some(isMore)) return tree;
  const [whole, listed] = (tree.args[at] as Node).args as readonly [Node, Node];
  const values = [...(listed.kind === "list" || listed.kind === "set" ? listed.args : [listed]), ...behind];
  const rest = node("list", ...tree.args.slice(0, at));
  if (values.some(hasBlank)) return rest;
  const flat = values.flatMap((value) => (value.kind === "set" ? value.args : [value]));
  if (sizeOf(rest, Infinity) * flat.length > LIMITS.worked_out) throw new ReadError("read.many-cases");
  return node("list", ...flat.flatMap((value) => replaced(rest, whole.text, value).args));
}

/** Whether the values of a whole number are listed, as in k = 0, 1 or k in {0, 1}. */
function isWholeNumber({ kind, args: [left, right] }: Node): boolean {
  return (
    (kind === "eq" || kind === "in") && VOCABULARY.whole_numbers.includes(left?.text ?? "") && right?.kind !== "name"
  );
}

/** Conditions without what says nothing: blanks, dots behind 0, pi, 2*pi, …, det J = 0, k in Z. */
function withoutBlanks(tree: Node): Node {
  const [left, right] = tree.args;
  const isList = ({ kind }: Node) => kind === "list" || kind === "set";
  if (["eq", "in", "pair"].includes(tree.kind) && left && right && isList(right))
    return node(tree.kind, left, withoutBlanks(right));
  if (!["and", "or", "list", "set"].includes(tree.kind)) return tree;
  const saying = tree.args.filter((arg) => !saysNothing(arg));
  const kept = saying.length > 0 ? saying : tree.args;
  if (!isList(tree) && kept.length === 1) return withoutBlanks(kept[0] as Node);
  return { ...tree, args: tree.kind === "and" ? kept : kept.map(withoutBlanks) };
}

/** Whether an entry was left blank, or only says that k is a whole number, or that det J is asked or zero. */
function saysNothing(tree: Node): boolean {
  const [left, right] = tree.args;
  const called = tree.kind === "eq" && left ? [...namesIn(left)] : [];
  if (called.length > 0 && called.every((each) => VOCABULARY.determinant.includes(each))) return true;
  if (tree.kind === "in" && VOCABULARY.number_sets.includes(right?.text ?? "")) return true;
  if (tree.kind === "in" && VOCABULARY.whole_numbers.includes(left?.text ?? ""))
    return VOCABULARY.whole_number_sets.includes(right?.text ?? "");
  const isSeveral = ["eq", "in", "pair"].includes(tree.kind) && (right?.kind === "list" || right?.kind === "set");
  return hasBlank(tree) && !isSeveral;
}

/** The verdict on conditions that may mean two things, or of which one is no condition; null where there are none. */
function unclear(answer: string, tree: Node, key: ConfigurationsKey): Verdict | null {
  const joint = key.joints.at(-1) ?? "";
  const used = [...namesIn(tree)];
  const unknown = used.filter(
    (each) => !key.symbols.includes(each) && !key.joints.includes(each) && !VOCABULARY.whole_numbers.includes(each),
  );
  if (unknown.length > 0)
    return wrong("read.unknown", { names: unknown.sort().slice(0, 5).join(", "), known: key.symbols.join(", ") });
  if (withPoints(answer) !== answer) return wrong("read.comma");
  if (hasProductInChain(tree, key.joints)) return wrong("read.chain");
  const several = ["list", "set", "or"].includes(tree.kind) ? tree.args : [tree];
  const isBare = (each: Node) =>
    ["+", "-", "*", "/", "^", "neg", "call"].includes(each.kind) && key.joints.some((one) => namesIn(each).has(one));
  return several.some(isBare) ? wrong("read.bare-condition", { joint }) : null;
}

/** Whether a product with a joint stands between two signs of equality: the joint may begin a condition of its own. */
function hasProductInChain(tree: Node, joints: readonly string[]): boolean {
  const isOpen = ({ kind, args: [, last] }: Node): boolean =>
    kind === "*" && last?.kind === "name" && joints.includes(last.text);
  return anyNode(tree, (each) => each.kind === "and" && each.text === CHAIN && chainOf(each).slice(1, -1).some(isOpen));
}

/** Bare values, as in {0, pi}, given to the joint that they must mean. Throws ReadError where that is not clear. */
function assigned(tree: Node, { joints }: Space): Node {
  const values = tree.kind === "list" || tree.kind === "set" ? tree.args : [tree];
  const saysMore = (arg: Node) =>
    ["eq", "in", "dict", "and", "or", "list", "set"].includes(arg.kind) ||
    joints.some((joint) => namesIn(arg).has(joint));
  if (values.length === 0 || values.some(saysMore)) return tree;
  const [joint] = joints;
  if (joint === undefined || joints.length > 1) throw new ReadError("read.no-joint"); // which of them, nobody said
  return node("in", name(joint), node("set", ...values));
}

function compared(typed: readonly Piece[], conditions: Conditions, space: Table, isSingular: IsSingular): Verdict {
  const poses = conditions.flat();
  const claims = typed.map((claim) => exactly(claim, poses, space));
  const found = claims.map((claim, i) => counterexample(claim, space, isSingular, i, poses.flat()));
  const rounded = typed.find((claim, i) => claim !== claims[i] && found[i] === null);
  const sound = claims.filter((_, i) => found[i] === null);
  const bad = claims.filter((_, i) => found[i] !== null && found[i] !== "nowhere");
  const missedBy = (by: readonly Piece[], piece: readonly At[]) =>
    piece.find((at) => !by.some((claim) => holds(claim, at, space)));
  const uncovered = poses.flatMap((piece): At[] => {
    const at = missedBy([...sound, ...bad], piece);
    return at ? [at] : [];
  });
  if (claims.length > 0 && uncovered.length === 0 && bad.length === 0 && !rounded)
    return correct(message("verdict.set"), false);
  // What is claimed beyond the truth must not earn what it happens to cover.
  const isCovered = (piece: readonly At[]) => missedBy(sound, piece) === undefined;
  const share = shareOfSet(
    conditions.map((pieces) => [pieces.filter(isCovered).length, pieces.length]),
    falseConditions(
      bad.map((claim) => jointsOf(claim, space)),
      new Set(sound.map((claim) => jointsOf(claim, space))),
    ),
    rounded !== undefined,
  );
  const slips = slipsInSet({
    claims,
    bad,
    poses,
    open: poses.filter((piece) => missedBy(claims, piece) !== undefined),
    ...space,
    holds: (claim, at) => holds(claim, at, space),
    isSound: (claim, instead) =>
      counterexample(claim, space, (at) => isSingular(instead(at)), 0, poses.flat()) === null,
  });
  const [slip] = slips;
  const verdict = (reasons: readonly Message[], at?: At) =>
    graded(share, [...(rounded ? [message("verdict.rounded")] : []), ...reasons], {
      ...(at ? { at } : {}),
      ...(slip ? { slips: slips.map((each) => each.slip) } : {}),
    });
  // the pose that is told is one of what the first slip is about
  const ofSlip = slip?.claim && found[claims.indexOf(slip.claim)];
  const off = [ofSlip, ...found].find((each) => typeof each === "object" && each !== null);
  if (off) return verdict([message("verdict.unsound", { at: atText(shown(off, space)) })], off);
  const missed = (slip?.piece && missedBy(claims, slip.piece)) ?? uncovered[0];
  if (missed) return verdict([message("verdict.uncovered", { at: atText(shown(missed, space)) })], missed);
  if (rounded) {
    const values = rounded.map(({ joint, zero }) => [joint, evaluate(zero, {}).re]);
    return verdict([], { ...poses[0]?.[0], ...Object.fromEntries(values) });
  }
  const nowhere = found.findIndex((each) => each === "nowhere" || each === "close") + 1;
  return verdict([message("verdict.nowhere", { text: String(nowhere) })]);
}

/** The joints of which a piece says something. */
function jointsOf(piece: Piece, { joints }: Space): string {
  const named = new Set(piece.flatMap(({ joint, zero }) => [joint, ...namesIn(zero)]));
  return joints.filter((joint) => named.has(joint)).join(" ");
}

function shown(at: At, { joints }: Space): At {
  return Object.fromEntries(joints.map((joint) => [joint, at[joint] as number]));
}

// --- is a pose on a piece? ---

function holds(piece: Piece, at: At, space: Space): boolean {
  return piece.every((atom) => {
    const { re, im, size } = evaluate(atom.zero, at);
    if (atom.joint !== null) {
      const near = namesIn(atom.zero).size === 0 ? STATED : NEAR;
      return Math.abs(im) < near && distance(atom.joint, at[atom.joint] as number, re, space) < near;
    }
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

/** A regular pose on a piece; null if all are singular, "nowhere" if there is no pose, "close" if one is near. */
function counterexample(
  piece: Piece,
  space: Space,
  isSingular: IsSingular,
  seed: number,
  lengths: readonly At[],
): At | "nowhere" | "close" | null {
  const random = randomNumbers((seed + 1) * 0x9e3779b9);
  const given = (k: number): At => lengths[k % Math.max(lengths.length, 1)] ?? {};
  const zeros = zerosOf(piece);
  const free = space.joints.filter((joint) => zeros.some((zero) => namesIn(zero).has(joint)));
  let found = 0;
  for (let start = 0; start < STARTS; start += 1) {
    const at = solved(piece, zeros, free, randomPose(given(start), space, random));
    if (!at || !holds(piece, at, space)) continue;
    found += 1;
    if (!isSingular(at)) return at;
  }
  if (found > 0) return null;
  const nearest = Math.min(
    ...Array.from({ length: LOOKED_AT }, (_, k) => missOf(zeros, randomPose(given(k), space, random))),
  );
  return nearest < NEAR_MISS ? "close" : "nowhere";
}

/** How far from zero the conditions are in a pose, of the size of their terms. */
function missOf(zeros: readonly Node[], at: At): number {
  const misses = zeros.map((zero) => {
    const { re, im, size } = evaluate(zero, at);
    return Math.abs(im) < NEAR ? Math.abs(re) / Math.max(size, 1e-300) : Infinity;
  });
  return misses.some(Number.isNaN) ? Infinity : Math.max(...misses);
}

/** A claim on values alone, with the right values put for those that are rounded: pi for 3.14, also for 355/113. */
function exactly(claim: Piece, poses: readonly (readonly At[])[], space: Space): Piece {
  if (claim.some(({ joint }) => joint === null)) return claim;
  const atoms = claim.map((atom) => {
    const due = roundedFrom(atom, poses, space);
    return due === null ? atom : { ...atom, zero: integer(due) };
  });
  return atoms.every((atom, i) => atom === claim[i]) ? claim : atoms;
}

/** The value of a joint on some piece of which a typed value is a rounded one; null if there is none. */
function roundedFrom({ joint, zero }: Atom, poses: readonly (readonly At[])[], space: Space): number | null {
  if (joint === null || namesIn(zero).size > 0) return null;
  const value = evaluate(zero, {}).re;
  const found = poses
    .map((others) => others.map((other) => other[joint] as number))
    .filter((dues) => dues.every((due) => distance(joint, due, dues[0] as number, space) < STATED))
    .map(([due]) => ({ due: due as number, off: distance(joint, value, due as number, space) }))
    .filter(({ off }) => off < ROUNDED)
    .sort((a, b) => a.off - b.off)[0];
  if (!found) return null;
  // what a search found is told with nine decimals
  const isFound = found.due !== 0 && Math.round(found.due * 1e9) / 1e9 === found.due;
  return found.off >= (isFound ? STATED : TYPED * Math.max(1, Math.abs(found.due))) ? found.due : null;
}

function randomPose(given: At, { joints, angles }: Space, random: () => number): At {
  const values = joints.map((joint) => [joint, angles.has(joint) ? TURN * (random() - 0.5) : 0.2 + random()]);
  return { ...given, ...Object.fromEntries(values) };
}

/** What has to vanish where conditions hold. */
const zerosOf = (piece: Piece): Node[] =>
  piece.map(({ joint, zero }) => (joint === null ? zero : node("-", name(joint), zero)));

/** The pose with the values of a piece, moved towards where its conditions hold by Gauss-Newton steps of least norm. */
function solved(piece: Piece, zeros: readonly Node[], free: readonly string[], start: At): At | null {
  let at = start;
  for (const { joint, zero } of piece) if (joint !== null) at = { ...at, [joint]: evaluate(zero, at).re };
  for (let step = 0; step < STEPS; step += 1) {
    const here = at;
    const off = zeros.map((zero) => {
      const { re, size } = evaluate(zero, here);
      return Number.isFinite(size) && Math.abs(re) <= ROUNDING * size ? 0 : re;
    });
    if (off.every((each) => each === 0)) break;
    const moves = leastNorm(
      zeros.map((zero) => free.map((joint) => slopeOf(zero, here, joint))),
      off,
    );
    if (!moves.every(Number.isFinite)) return null;
    const moved = free.map((joint, i) => [joint, here[joint]! - Math.max(-1, Math.min(1, moves[i]!))]);
    at = { ...here, ...Object.fromEntries(moved) };
    if (Math.max(0, ...moves.map(Math.abs)) < 1e-12) break;
  }
  return at;
}

/** The shortest x with A x = b. Rows are normalised, because slopes vanish at a double zero, as of sin² or cos = 1. */
function leastNorm(a: readonly (readonly number[])[], b: readonly number[]): number[] {
  const open = a.flatMap((row, i) => {
    const length = Math.hypot(...row);
    return b[i] === 0 ? [] : [{ row: row.map((x) => x / length), due: (b[i] as number) / length }];
  });
  const [rows, right] = [open.map(({ row }) => row), open.map(({ due }) => due)];
  return damped(rows, right, DAMPING);
}
