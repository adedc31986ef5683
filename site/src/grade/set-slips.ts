// Find what went wrong in a set of singular configurations: conditions that are right after one change, conditions that
// are too wide or too narrow, and missing conditions.

import { evaluate } from "../read/evaluate.js";
import { decimal, name, namesIn, type Node, node } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import { type Kind, KINDS, repairsFor, singleChanges } from "./single-changes.js";
import type { Atom, Piece } from "./claims.js";
import { displayName } from "./values.js";
import type { SymbolValues } from "./verdict.js";

const HALF_TURN = Math.PI;
const DEGREE = Math.PI / 180;
/** Angles from the first limit on are hardly radians; angles below the second are hardly degrees. */
const MIN_DEGREES = 10;
const MAX_TINY_RADIANS = 0.12;
/** At most this many slips are reported. */
const MAX_SLIPS = 3;
/** At most this many wrong claims are examined: whole numbers make hundreds. */
const MAX_CLAIMS = 24;
/** Relative tolerance for zero at a configuration whose values have nine decimals. */
const ZERO_TOLERANCE = 1e-7;
/** A symbol that nobody types. */
const ONE = " one";

/** The claims (pieces) of an answer, and what is needed to examine them. */
export interface Claims {
  readonly claims: readonly Piece[];
  /** Claims that contain regular configurations. */
  readonly wrongClaims: readonly Piece[];
  /** Pieces of the right set that no claim covers. */
  readonly uncovered: readonly (readonly SymbolValues[])[];
  /** All pieces of the right set, each by some configurations. */
  readonly pieces: readonly (readonly SymbolValues[])[];
  readonly joints: readonly string[];
  readonly angles: ReadonlySet<string>;
  /** Nonzero constants that the table adds to joint variables (rad). */
  readonly offsets: ReadonlyMap<string, number>;
  readonly symbols: readonly string[];
  readonly holds: (claim: Piece, at: SymbolValues) => boolean;
  /** Return whether all configurations on a claim are singular after a substitution of joint values. */
  readonly isSound: (claim: Piece, substitute: (at: SymbolValues) => SymbolValues) => boolean;
}

/** A slip, with the claim of the answer, or the piece of the right set, to which it belongs. */
export type SetSlip = { readonly slip: Message; readonly claim?: Piece; readonly piece?: readonly SymbolValues[] };

/** Return what went wrong in a set that is not right; too wide conditions first. */
export function slipsInSet(set: Claims): SetSlip[] {
  const slips = new Map<string, SetSlip>();
  const add = (setSlip: SetSlip): void => {
    const key = JSON.stringify(setSlip.slip);
    if (!slips.has(key)) slips.set(key, setSlip);
  };
  for (const claim of set.wrongClaims.slice(0, MAX_CLAIMS)) {
    if (slips.size === MAX_SLIPS) break;
    const slip = slipInClaim(set, claim);
    if (slip) add({ slip, claim });
  }
  if (set.wrongClaims.length === 0) findMissing(set).forEach(add);
  return [...slips.values()].slice(0, MAX_SLIPS);
}

/** Return why a claim is too wide: the change that makes it right, or what it lacks. */
function slipInClaim(set: Claims, claim: Piece): Message | null {
  return (
    findUnitSlip(set, claim) ??
    findFormulaSlip(set, claim) ??
    findValueSlip(set, claim) ??
    findMissingCondition(set, claim) ??
    findFreeJoint(set, claim)
  );
}

const unchanged = (at: SymbolValues): SymbolValues => at;

/** Return whether a claim with substitutions is sound, and covers a piece that no claim covers. */
function fits({ uncovered, holds, isSound }: Claims, claim: Piece, meant = unchanged, typed = unchanged): boolean {
  return uncovered.some((poses) => poses.every((at) => holds(claim, typed(at)))) && isSound(claim, meant);
}

const rotated =
  (joint: string, by: number) =>
  (at: SymbolValues): SymbolValues => ({ ...at, [joint]: (at[joint] ?? NaN) + by });

const exchanged =
  (joint: string, other: string) =>
  (at: SymbolValues): SymbolValues => ({ ...at, [joint]: at[other] ?? NaN, [other]: at[joint] ?? NaN });

const mirrored =
  (joint: string) =>
  (at: SymbolValues): SymbolValues => ({ ...at, [joint]: -(at[joint] ?? NaN) });

/** Report values in degrees, or in radians that were converted twice. */
function findUnitSlip(set: Claims, claim: Piece): Message | null {
  const scaled = (factor: number, isInRange: (size: number) => boolean) => {
    const other = claim.map((atom) => scaleAngle(atom, set.angles, factor, isInRange));
    return other.some((atom, i) => atom !== claim[i]) && fits(set, other);
  };
  if (scaled(DEGREE, (size) => size >= MIN_DEGREES)) return message("slip.degrees");
  if (scaled(1 / DEGREE, (size) => size > 0 && size <= MAX_TINY_RADIANS)) return message("slip.radians");
  return null;
}

/** Return an angle's value times a factor if its size is in range; return other atoms unchanged. */
function scaleAngle(
  atom: Atom,
  angles: ReadonlySet<string>,
  factor: number,
  isInRange: (size: number) => boolean,
): Atom {
  const { joint, zero } = atom;
  if (joint === null || !angles.has(joint) || namesIn(zero).size > 0) return atom;
  const value = evaluate(zero, {}).re;
  if (!isInRange(Math.abs(value))) return atom;
  return { joint, zero: decimal(value * factor) };
}

/** Report a joint's values that belong to another angle, or to another joint. */
function findValueSlip(set: Claims, claim: Piece): Message | null {
  const { angles, offsets, joints } = set;
  const claimed = new Set(claim.flatMap(({ joint, zero }) => (joint === null ? [...namesIn(zero)] : [joint])));
  const isRotated = (joint: string, angle: number) => fits(set, claim, rotated(joint, angle), rotated(joint, -angle));
  for (const joint of [...claimed].filter((joint) => angles.has(joint))) {
    if ([HALF_TURN / 2, -HALF_TURN / 2].some((turn) => isRotated(joint, turn)))
      return message("slip.quarter-turn", { joint: displayName(joint) });
    const offset = offsets.get(joint) ?? 0;
    if (offset !== 0 && isRotated(joint, -offset)) return message("slip.offset", { joint: displayName(joint) });
    if (offset !== 0 && isRotated(joint, -2 * offset))
      return message("slip.offset-sign", { joint: displayName(joint) });
    const hasValue = claim.some((atom) => atom.joint === joint);
    if (hasValue && fits(set, claim, mirrored(joint), mirrored(joint)))
      return message("slip.value-sign", { joint: displayName(joint) });
  }
  for (const joint of claimed)
    for (const other of joints)
      if (other !== joint && angles.has(joint) === angles.has(other)) {
        const swap = exchanged(joint, other);
        if (fits(set, claim, swap, swap)) return message("slip.other-joint", { joint: displayName(joint) });
      }
  for (const factor of [0.5, 2]) {
    const other = claim.map((atom) => scaleAngle(atom, angles, factor, (size) => size > 0));
    const [joint] = claim.flatMap((atom, i) => (atom !== other[i] && atom.joint ? [atom.joint] : []));
    if (joint !== undefined && fits(set, other)) return message("slip.half-radians", { joint: displayName(joint) });
  }
  return null;
}

/** Report a joint that is claimed to be singular at some value, but is singular at none. */
function findFreeJoint({ pieces, angles }: Claims, claim: Piece): Message | null {
  const [atom, ...others] = claim;
  if (!atom || atom.joint === null || others.length > 0 || namesIn(atom.zero).size > 0) return null;
  const { joint } = atom;
  const isFree = pieces.every((piece) => !isFixed(piece, joint, angles));
  return isFree ? message("slip.called-singular", { joint: displayName(joint) }) : null;
}

/** Return whether a joint has the same value in all poses of a piece. */
function isFixed(piece: readonly SymbolValues[], joint: string, angles: ReadonlySet<string>): boolean {
  const difference = (at: SymbolValues) => {
    const change = (at[joint] ?? NaN) - (piece[0]?.[joint] ?? NaN);
    return angles.has(joint) ? Math.sin(change / 2) : change;
  };
  return piece.every((at) => Math.abs(difference(at)) < 1e-6);
}

/** Report the slip in a formula that should vanish: once undone, it vanishes on a piece that no claim covers. */
function findFormulaSlip({ uncovered, symbols, joints }: Claims, claim: Piece): Message | null {
  const [atom, ...others] = claim;
  if (!atom || atom.joint !== null || others.length > 0) return null;
  // one is added to what should be zero, so that relative tolerances apply
  const entry = node("+", atom.zero, name(ONE));
  const slips = new Map<Kind, string>();
  for (const poses of uncovered) {
    const repairs = repairsFor([atom.zero], { ...poses[0], [ONE]: 1 }, { symbols });
    for (const { kind, what = "", entry: changed } of singleChanges(entry, 1, repairs))
      if (!slips.has(kind) && poses.every((at) => vanishes(changed, at) && !vanishes(changed, elsewhere(at, joints))))
        slips.set(kind, what);
  }
  const kind = KINDS_IN_FORMULAS.find((kind) => slips.has(kind));
  if (kind === undefined) return null;
  const what = slips.get(kind);
  return message(kind, { where: message("slip.tie"), ...(what ? { what } : {}) });
}

/** The kinds of slips in a condition, in their order; a sine as a factor may itself vanish. */
const KINDS_IN_FORMULAS = KINDS.filter(
  (kind) => !["slip.whole-sign", "slip.factor-missing", "slip.constant", "slip.number", "slip.zero"].includes(kind),
);

/** Return a pose in which all joints have other values: there only identities vanish. */
const elsewhere = (at: SymbolValues, joints: readonly string[]): SymbolValues => ({
  ...at,
  ...Object.fromEntries(joints.map((joint, i) => [joint, (at[joint] ?? NaN) + 0.37 + 0.21 * i])),
});

/** Return whether an expression exceeds zero by `ONE` in a pose, for several values of `ONE`. */
function vanishes(tree: Node, at: SymbolValues): boolean {
  return [1, 1.7].every((value) => {
    const { re, size } = evaluate(tree, { ...at, [ONE]: value });
    return Math.abs(re - value) <= ZERO_TOLERANCE * Math.max(1, size);
  });
}

/** Report a claim that covers a piece of the right set, and regular poses too: it needs another condition. */
function findMissingCondition({ pieces, holds }: Claims, claim: Piece): Message | null {
  const coversPiece = pieces.some((piece) => piece.every((at) => holds(claim, at)));
  const joints = [...new Set(claim.flatMap(({ joint }) => joint ?? []))];
  return coversPiece && joints.length > 0
    ? message("slip.and-missing", { joint: displayName(joints.join(", ")) })
    : null;
}

/** Return the joints in a condition. */
const jointsOf = ({ joint, zero }: Atom, joints: readonly string[]): string =>
  joint ?? joints.filter((joint) => namesIn(zero).has(joint)).join(", ");

/** Report what is missing if all claims are singular. */
function findMissing({ claims, uncovered, angles, joints, holds, isSound }: Claims): SetSlip[] {
  for (const claim of claims.filter(({ length }) => length > 1))
    for (const atom of claim) {
      const others = claim.filter((condition) => condition !== atom);
      const piece = uncovered.find((poses) => poses.every((at) => holds(others, at)));
      if (piece && isSound(others, unchanged))
        return [{ slip: message("slip.too-narrow", { joint: displayName(jointsOf(atom, joints)) }), piece }];
    }
  for (const joint of angles) {
    const piece = uncovered.find((poses) =>
      poses.every((at) => claims.some((claim) => holds(claim, rotated(joint, HALF_TURN)(at)))),
    );
    if (piece) return [{ slip: message("slip.half-turn", { joint: displayName(joint) }), piece }];
  }
  const isOfJoints = (piece: readonly SymbolValues[]) => joints.some((joint) => isFixed(piece, joint, angles));
  const [values, tie] = [uncovered.find(isOfJoints), uncovered.find((piece) => !isOfJoints(piece))];
  return [
    ...(values ? [{ slip: message("slip.values-left-out"), piece: values }] : []),
    ...(tie ? [{ slip: message("slip.tie-left-out"), piece: tie }] : []),
  ];
}
