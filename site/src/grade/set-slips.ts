// Find what went wrong in a set of singular configurations: a condition that one change makes right, that claims too
// much or too little, and missing conditions.

import { evaluate } from "../read/evaluate.js";
import { decimal, name, namesIn, type Node, node } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import { changes, type Kind, KINDS, meansOf } from "./changes.js";
import type { Atom, Piece } from "./pieces.js";
import { seen } from "./values.js";
import type { At } from "./verdict.js";

const HALF_TURN = Math.PI;
const DEGREE = Math.PI / 180;
/** An angle from here on is none in radians, and one below this is hardly one in degrees. */
const DEGREES_FROM = 10;
const RADIANS_TO = 0.12;
/** So many slips are told of a set. */
const MOST_TOLD = 3;
/** So many claims that say too much are looked at: whole numbers make hundreds. */
const MOST_CLAIMS = 24;
/** What vanishes in a pose whose values are told with nine decimals, of the size of its terms. */
const VANISHES = 1e-7;
/** A symbol that nobody types. */
const ONE = " one";

export interface Claims {
  readonly claims: readonly Piece[];
  /** Those of which some pose is not singular, and pieces of the right set that no claim covers. */
  readonly bad: readonly Piece[];
  readonly open: readonly (readonly At[])[];
  /** All pieces of the right set. */
  readonly poses: readonly (readonly At[])[];
  readonly joints: readonly string[];
  readonly angles: ReadonlySet<string>;
  /** What the table adds to variables of joints, where it adds something (rad). */
  readonly offsets: ReadonlyMap<string, number>;
  readonly symbols: readonly string[];
  readonly holds: (claim: Piece, at: At) => boolean;
  /** Whether all poses on a claim are singular where each is another one than it says. */
  readonly isSound: (claim: Piece, instead: (at: At) => At) => boolean;
}

/** A slip, and what it is about: a claim of the answer, or a piece of the right set that no claim covers. */
export type SetSlip = { readonly slip: Message; readonly claim?: Piece; readonly piece?: readonly At[] };

/** What went wrong in a set that is not right, the conditions that say too much first. */
export function slipsInSet(set: Claims): SetSlip[] {
  const named = new Map<string, SetSlip>();
  const add = (found: SetSlip): void => {
    const known = JSON.stringify(found.slip);
    if (!named.has(known)) named.set(known, found);
  };
  for (const claim of set.bad.slice(0, MOST_CLAIMS)) {
    if (named.size === MOST_TOLD) break;
    const slip = slipInClaim(set, claim);
    if (slip) add({ slip, claim });
  }
  if (set.bad.length === 0) missing(set).forEach(add);
  return [...named.values()].slice(0, MOST_TOLD);
}

/** Why a claim says too much: the change by which it says what no claim says rightly, or what it lacks. */
function slipInClaim(set: Claims, claim: Piece): Message | null {
  return (
    inAngles(set, claim) ??
    inTie(set, claim) ??
    inValues(set, claim) ??
    besides(set, claim) ??
    calledSingular(set, claim)
  );
}

const same = (at: At): At => at;

/** Whether a claim, read as another one, holds wherever it says, and covers a piece that none covers. */
function fits({ open, holds, isSound }: Claims, claim: Piece, meant = same, said = same): boolean {
  return open.some((poses) => poses.every((at) => holds(claim, said(at)))) && isSound(claim, meant);
}

const turned =
  (joint: string, by: number) =>
  (at: At): At => ({ ...at, [joint]: (at[joint] ?? NaN) + by });

const exchanged =
  (joint: string, other: string) =>
  (at: At): At => ({ ...at, [joint]: at[other] ?? NaN, [other]: at[joint] ?? NaN });

const mirrored =
  (joint: string) =>
  (at: At): At => ({ ...at, [joint]: -(at[joint] ?? NaN) });

// --- values ---

/** Values in degrees, or in the wrong radians. */
function inAngles(set: Claims, claim: Piece): Message | null {
  const scaled = (factor: number, isOne: (size: number) => boolean) => {
    const other = claim.map((atom) => times(atom, set.angles, factor, isOne));
    return other.some((atom, i) => atom !== claim[i]) && fits(set, other);
  };
  if (scaled(DEGREE, (size) => size >= DEGREES_FROM)) return message("slip.degrees");
  if (scaled(1 / DEGREE, (size) => size > 0 && size <= RADIANS_TO)) return message("slip.radians");
  return null;
}

/** A value of an angle times a factor, if its size is such a one; everything else as it is. */
function times(atom: Atom, angles: ReadonlySet<string>, factor: number, isOne: (size: number) => boolean): Atom {
  const { joint, zero } = atom;
  if (joint === null || !angles.has(joint) || namesIn(zero).size > 0) return atom;
  const value = evaluate(zero, {}).re;
  if (!isOne(Math.abs(value))) return atom;
  return { joint, zero: decimal(value * factor) };
}

/** A joint's values that are those of another angle, or of another joint. */
function inValues(set: Claims, claim: Piece): Message | null {
  const { angles, offsets, joints } = set;
  const said = new Set(claim.flatMap(({ joint, zero }) => (joint === null ? [...namesIn(zero)] : [joint])));
  const isTurned = (joint: string, by: number) => fits(set, claim, turned(joint, by), turned(joint, -by));
  for (const joint of [...said].filter((each) => angles.has(each))) {
    if ([HALF_TURN / 2, -HALF_TURN / 2].some((turn) => isTurned(joint, turn)))
      return message("slip.quarter-turn", { joint: seen(joint) });
    const offset = offsets.get(joint) ?? 0;
    if (offset !== 0 && isTurned(joint, -offset)) return message("slip.offset", { joint: seen(joint) });
    if (offset !== 0 && isTurned(joint, -2 * offset)) return message("slip.offset-sign", { joint: seen(joint) });
    if (isOfValues(claim, joint) && fits(set, claim, mirrored(joint), mirrored(joint)))
      return message("slip.value-sign", { joint: seen(joint) });
  }
  for (const joint of said)
    for (const other of joints)
      if (other !== joint && angles.has(joint) === angles.has(other)) {
        const swap = exchanged(joint, other);
        if (fits(set, claim, swap, swap)) return message("slip.other-joint", { joint: seen(joint) });
      }
  for (const factor of [0.5, 2]) {
    const other = claim.map((atom) => times(atom, angles, factor, (size) => size > 0));
    const [joint] = claim.flatMap((atom, i) => (atom !== other[i] && atom.joint ? [atom.joint] : []));
    if (joint !== undefined && fits(set, other)) return message("slip.half-radians", { joint: seen(joint) });
  }
  return null;
}

const isOfValues = (claim: Piece, joint: string): boolean => claim.some((atom) => atom.joint === joint);

/** A joint that is called singular at some value, and is so at none. */
function calledSingular({ poses, angles }: Claims, claim: Piece): Message | null {
  const [atom, ...more] = claim;
  if (!atom || atom.joint === null || more.length > 0 || namesIn(atom.zero).size > 0) return null;
  const { joint } = atom;
  const isFree = poses.every((piece) => !isFixed(piece, joint, angles));
  return isFree ? message("slip.called-singular", { joint: seen(joint) }) : null;
}

/** Whether a joint has one value in all poses of a piece. */
function isFixed(piece: readonly At[], joint: string, angles: ReadonlySet<string>): boolean {
  const apart = (at: At) => {
    const difference = (at[joint] ?? NaN) - (piece[0]?.[joint] ?? NaN);
    return angles.has(joint) ? Math.sin(difference / 2) : difference;
  };
  return piece.every((at) => Math.abs(apart(at)) < 1e-6);
}

// --- conditions that tie several joints ---

/** The slip in a formula that should vanish: once undone, it vanishes on a piece that no claim covers. */
function inTie({ open, symbols, joints }: Claims, claim: Piece): Message | null {
  const [atom, ...more] = claim;
  if (!atom || atom.joint !== null || more.length > 0) return null;
  // one more than what should be zero: shares of it can be compared
  const entry = node("+", atom.zero, name(ONE));
  const found = new Map<Kind, string>();
  for (const poses of open) {
    const means = meansOf([atom.zero], { ...poses[0], [ONE]: 1 }, { symbols });
    for (const { kind, what = "", entry: changed } of changes(entry, 1, means))
      if (!found.has(kind) && poses.every((at) => vanishes(changed, at) && !vanishes(changed, elsewhere(at, joints))))
        found.set(kind, what);
  }
  const kind = IN_TIES.find((each) => found.has(each));
  if (kind === undefined) return null;
  const what = found.get(kind);
  return message(kind, { where: message("slip.tie"), ...(what ? { what } : {}) });
}

/** Those that a condition may have, in their order; a sine that it is multiplied by may vanish itself. */
const IN_TIES = KINDS.filter(
  (kind) => !["slip.whole-sign", "slip.factor-missing", "slip.constant", "slip.number", "slip.zero"].includes(kind),
);

/** A pose in which all joints are elsewhere: there nothing vanishes that does not vanish everywhere. */
const elsewhere = (at: At, joints: readonly string[]): At => ({
  ...at,
  ...Object.fromEntries(joints.map((joint, i) => [joint, (at[joint] ?? NaN) + 0.37 + 0.21 * i])),
});

/** Whether a formula is `ONE` more than nothing in a pose, whatever that is worth. */
function vanishes(tree: Node, at: At): boolean {
  return [1, 1.7].every((one) => {
    const { re, size } = evaluate(tree, { ...at, [ONE]: one });
    return Math.abs(re - one) <= VANISHES * Math.max(1, size);
  });
}

// --- what is too little ---

/** A claim that holds on a piece of the right set, and elsewhere, too: something has to hold with it. */
function besides({ poses, holds }: Claims, claim: Piece): Message | null {
  const isPart = poses.some((piece) => piece.every((at) => holds(claim, at)));
  const joints = [...new Set(claim.flatMap(({ joint }) => joint ?? []))];
  return isPart && joints.length > 0 ? message("slip.and-missing", { joint: seen(joints.join(", ")) }) : null;
}

/** The joints of which a condition speaks. */
const spokenOf = ({ joint, zero }: Atom, joints: readonly string[]): string =>
  joint ?? joints.filter((each) => namesIn(zero).has(each)).join(", ");

/** What is missing where all that is claimed is singular. */
function missing({ claims, open, angles, joints, holds, isSound }: Claims): SetSlip[] {
  for (const claim of claims.filter(({ length }) => length > 1))
    for (const atom of claim) {
      const rest = claim.filter((each) => each !== atom);
      const piece = open.find((poses) => poses.every((at) => holds(rest, at)));
      if (piece && isSound(rest, same))
        return [{ slip: message("slip.too-narrow", { joint: seen(spokenOf(atom, joints)) }), piece }];
    }
  for (const joint of angles) {
    const piece = open.find((poses) =>
      poses.every((at) => claims.some((claim) => holds(claim, turned(joint, HALF_TURN)(at)))),
    );
    if (piece) return [{ slip: message("slip.half-turn", { joint: seen(joint) }), piece }];
  }
  const isOfJoints = (piece: readonly At[]) => joints.some((joint) => isFixed(piece, joint, angles));
  const [values, tie] = [open.find(isOfJoints), open.find((piece) => !isOfJoints(piece))];
  return [
    ...(values ? [{ slip: message("slip.values-left-out"), piece: values }] : []),
    ...(tie ? [{ slip: message("slip.tie-left-out"), piece: tie }] : []),
  ];
}
