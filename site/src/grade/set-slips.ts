// Find what went wrong in a set of singular configurations: conditions that become right by one change, conditions that
// are too wide or too narrow, and missing conditions.

import { evaluate } from "../read/evaluate.js";
import { decimal, isConstant, name, findNames, type Node, node, type SymbolValues } from "../read/tree.js";
import { message, type Message, withGreek } from "../text/text.js";
import { type Kind, KINDS, buildRepairs, findSingleChanges } from "./single-changes.js";
import type { Atom, Claim } from "./claims.js";

/** Angles in radians. */
const HALF_TURN = Math.PI;
const DEGREE = Math.PI / 180;
/** Angles of at least the first size are hardly radians; angles of at most the second are hardly degrees. */
const MIN_DEGREES = 10;
const MAX_TINY_RADIANS = 0.12;
/** At most this many slips are reported. */
const MAX_SLIPS = 3;
/** At most this many wrong claims are examined: whole numbers make hundreds. */
const MAX_CLAIMS = 24;
/** Tolerance for zero, relative to the terms, at a configuration whose values have nine decimals. */
const ZERO_TOLERANCE = 1e-7;
/** The name of a symbol that is added to a formula; nobody can type it, because it begins with a space. */
const ONE_SYMBOL = " one";

/** A piece of the right set, given by some configurations on it. */
type Piece = readonly SymbolValues[];

/** The claims of an answer, the pieces of the right set, and functions to examine the claims. */
interface ClaimedSet {
  readonly claims: readonly Claim[];
  /** Claims that hold at regular configurations, too. */
  readonly wrongClaims: readonly Claim[];
  /** Pieces of the right set that no claim covers. */
  readonly uncoveredPieces: readonly Piece[];
  /** All pieces of the right set. */
  readonly pieces: readonly Piece[];
  /** Names of the joint variables, and of those that are angles. */
  readonly joints: readonly string[];
  readonly angles: ReadonlySet<string>;
  /** Nonzero constants that the table adds to joint variables (rad). */
  readonly offsets: ReadonlyMap<string, number>;
  /** Names of all symbols that have values in a configuration. */
  readonly symbols: readonly string[];
  /** Return whether a configuration is on a claim. */
  readonly holds: (claim: Claim, pose: SymbolValues) => boolean;
  /** Return whether all configurations on a claim are singular once `substitute` has changed their joint values. */
  readonly isSound: (claim: Claim, substitute: (pose: SymbolValues) => SymbolValues) => boolean;
}

/** A slip, with the claim of the answer, or the piece of the right set, to which it belongs. */
type SetSlip = { readonly slip: Message; readonly claim?: Claim; readonly piece?: Piece };

/** Return what went wrong in a set that is not right; too wide conditions first. */
export function findSlipsInSet(set: ClaimedSet): SetSlip[] {
  const slips = new Map<string, SetSlip>();
  const add = (setSlip: SetSlip): void => {
    const key = JSON.stringify(setSlip.slip);
    if (!slips.has(key)) slips.set(key, setSlip);
  };
  for (const claim of set.wrongClaims.slice(0, MAX_CLAIMS)) {
    if (slips.size === MAX_SLIPS) break;
    const slip = findSlipInClaim(set, claim);
    if (slip) add({ slip, claim });
  }
  if (set.wrongClaims.length === 0) findMissingParts(set).forEach(add);
  return [...slips.values()].slice(0, MAX_SLIPS);
}

/** Return why a claim is too wide: the change that makes it right, or what it lacks. */
function findSlipInClaim(set: ClaimedSet, claim: Claim): Message | null {
  return (
    findUnitSlip(set, claim) ??
    findFormulaSlip(set, claim) ??
    findValueSlip(set, claim) ??
    findMissingCondition(set, claim) ??
    findFreeJoint(set, claim)
  );
}

const keepPose = (pose: SymbolValues): SymbolValues => pose;

/**
 * Return whether a claim is right but for a substitution of joint values. `toMeant` changes a configuration on the
 * claim to the one that the student meant; all of these must be singular. `toTyped` is its inverse; the claim must then
 * cover a piece that no claim covers.
 */
function isRightAfterChange(
  { uncoveredPieces, holds, isSound }: ClaimedSet,
  claim: Claim,
  toMeant = keepPose,
  toTyped = keepPose,
): boolean {
  return uncoveredPieces.some((poses) => poses.every((pose) => holds(claim, toTyped(pose)))) && isSound(claim, toMeant);
}

// These functions make changes of poses, as `toMeant` and `toTyped` above.

const rotateJoint =
  (joint: string, angle: number) =>
  (pose: SymbolValues): SymbolValues => ({ ...pose, [joint]: (pose[joint] ?? NaN) + angle });

const exchangeJoints =
  (joint: string, other: string) =>
  (pose: SymbolValues): SymbolValues => ({ ...pose, [joint]: pose[other] ?? NaN, [other]: pose[joint] ?? NaN });

const mirrorJoint =
  (joint: string) =>
  (pose: SymbolValues): SymbolValues => ({ ...pose, [joint]: -(pose[joint] ?? NaN) });

/** Report values in degrees, or values converted from degrees to radians twice. */
function findUnitSlip(set: ClaimedSet, claim: Claim): Message | null {
  const isRightAfterScaling = (factor: number, isInRange: (size: number) => boolean) => {
    const scaledClaim = claim.map((atom) => scaleAngle(atom, set.angles, factor, isInRange));
    return scaledClaim.some((atom, i) => atom !== claim[i]) && isRightAfterChange(set, scaledClaim);
  };
  if (isRightAfterScaling(DEGREE, (size) => size >= MIN_DEGREES)) return message("slip.degrees");
  if (isRightAfterScaling(1 / DEGREE, (size) => size > 0 && size <= MAX_TINY_RADIANS)) return message("slip.radians");
  return null;
}

/** Return an angle's value times a factor if its size is in range; return other atoms unchanged. */
function scaleAngle(
  atom: Atom,
  angles: ReadonlySet<string>,
  factor: number,
  isInRange: (size: number) => boolean,
): Atom {
  const { joint, expression } = atom;
  if (joint === null || !angles.has(joint) || !isConstant(expression)) return atom;
  const value = evaluate(expression, {}).re;
  if (!isInRange(Math.abs(value))) return atom;
  return { joint, expression: decimal(value * factor) };
}

/** Report values that would be right for another angle of the joint, or for another joint. */
function findValueSlip(set: ClaimedSet, claim: Claim): Message | null {
  const { angles, offsets, joints } = set;
  const claimedJoints = new Set(
    claim.flatMap(({ joint, expression }) => (joint === null ? [...findNames(expression)] : [joint])),
  );
  const isRightAfterRotation = (joint: string, angle: number) =>
    isRightAfterChange(set, claim, rotateJoint(joint, angle), rotateJoint(joint, -angle));
  for (const joint of [...claimedJoints].filter((joint) => angles.has(joint))) {
    if ([HALF_TURN / 2, -HALF_TURN / 2].some((turn) => isRightAfterRotation(joint, turn)))
      return message("slip.quarter-turn", { joint: withGreek(joint) });
    const offset = offsets.get(joint) ?? 0;
    if (offset !== 0 && isRightAfterRotation(joint, -offset))
      return message("slip.offset", { joint: withGreek(joint) });
    if (offset !== 0 && isRightAfterRotation(joint, -2 * offset))
      return message("slip.offset-sign", { joint: withGreek(joint) });
    const hasValue = claim.some((atom) => atom.joint === joint);
    if (hasValue && isRightAfterChange(set, claim, mirrorJoint(joint), mirrorJoint(joint)))
      return message("slip.value-sign", { joint: withGreek(joint) });
  }
  for (const joint of claimedJoints)
    for (const other of joints)
      if (other !== joint && angles.has(joint) === angles.has(other)) {
        const swap = exchangeJoints(joint, other);
        if (isRightAfterChange(set, claim, swap, swap)) return message("slip.other-joint", { joint: withGreek(joint) });
      }
  for (const factor of [0.5, 2]) {
    const scaledClaim = claim.map((atom) => scaleAngle(atom, angles, factor, (size) => size > 0));
    const [joint] = claim.flatMap((atom, i) => (atom !== scaledClaim[i] && atom.joint ? [atom.joint] : []));
    if (joint !== undefined && isRightAfterChange(set, scaledClaim))
      return message("slip.half-radians", { joint: withGreek(joint) });
  }
  return null;
}

/** Report a joint that is claimed to be singular at some value, but is singular at none. */
function findFreeJoint({ pieces, angles }: ClaimedSet, claim: Claim): Message | null {
  const [atom, ...others] = claim;
  if (!atom || atom.joint === null || others.length > 0 || !isConstant(atom.expression)) return null;
  const { joint } = atom;
  const isFree = pieces.every((piece) => !isFixed(piece, joint, angles));
  return isFree ? message("slip.called-singular", { joint: withGreek(joint) }) : null;
}

/** Return whether a joint has the same value (modulo turns) in all poses of a piece. */
function isFixed(piece: Piece, joint: string, angles: ReadonlySet<string>): boolean {
  const difference = (pose: SymbolValues) => {
    const change = (pose[joint] ?? NaN) - (piece[0]?.[joint] ?? NaN);
    return angles.has(joint) ? Math.sin(change / 2) : change;
  };
  return piece.every((pose) => Math.abs(difference(pose)) < 1e-6);
}

/** Report the slip in a formula that should vanish: once undone, it vanishes on a piece that no claim covers. */
function findFormulaSlip({ uncoveredPieces, symbols, joints }: ClaimedSet, claim: Claim): Message | null {
  const [atom, ...others] = claim;
  if (!atom || atom.joint !== null || others.length > 0) return null;
  // a symbol is added to the expression that should be zero, so that relative tolerances apply
  const entry = node("+", atom.expression, name(ONE_SYMBOL));
  const slips = new Map<Kind, string>();
  for (const poses of uncoveredPieces) {
    const repairs = buildRepairs([atom.expression], { ...poses[0], [ONE_SYMBOL]: 1 }, { symbols });
    for (const { kind, what = "", entry: changed } of findSingleChanges(entry, 1, repairs))
      if (
        !slips.has(kind) &&
        poses.every((pose) => vanishes(changed, pose) && !vanishes(changed, moveAllJoints(pose, joints)))
      )
        slips.set(kind, what);
  }
  const kind = KINDS_IN_CONDITIONS.find((kind) => slips.has(kind));
  if (kind === undefined) return null;
  const what = slips.get(kind);
  return message(kind, { where: message("slip.tie"), ...(what ? { what } : {}) });
}

/** The kinds of slips in a condition, in order of preference; no missing factors, because a sine may itself vanish. */
const KINDS_IN_CONDITIONS = KINDS.filter(
  (kind) => !["slip.whole-sign", "slip.factor-missing", "slip.constant", "slip.number", "slip.zero"].includes(kind),
);

/** Return a pose in which all joints have other values. An expression that vanishes there, too, is zero everywhere. */
const moveAllJoints = (pose: SymbolValues, joints: readonly string[]): SymbolValues => ({
  ...pose,
  ...Object.fromEntries(joints.map((joint, i) => [joint, (pose[joint] ?? NaN) + 0.37 + 0.21 * i])),
});

/** Return whether an expression equals the added symbol in a pose, for several values of this symbol. */
function vanishes(tree: Node, pose: SymbolValues): boolean {
  return [1, 1.7].every((value) => {
    const { re, size } = evaluate(tree, { ...pose, [ONE_SYMBOL]: value });
    return Math.abs(re - value) <= ZERO_TOLERANCE * Math.max(1, size);
  });
}

/** Report a claim that covers a piece of the right set, and regular poses too: it needs another condition. */
function findMissingCondition({ pieces, holds }: ClaimedSet, claim: Claim): Message | null {
  const coversPiece = pieces.some((piece) => piece.every((pose) => holds(claim, pose)));
  const joints = [...new Set(claim.flatMap(({ joint }) => joint ?? []))];
  return coversPiece && joints.length > 0 ? message("slip.and-missing", { joint: withGreek(joints.join(", ")) }) : null;
}

/** Return the names of the joints in a condition, with commas. */
const nameJointsOfAtom = ({ joint, expression }: Atom, joints: readonly string[]): string =>
  joint ?? joints.filter((joint) => findNames(expression).has(joint)).join(", ");

/** Report what is missing in an answer whose claims are all sound. */
function findMissingParts({ claims, uncoveredPieces, angles, joints, holds, isSound }: ClaimedSet): SetSlip[] {
  for (const claim of claims.filter(({ length }) => length > 1))
    for (const atom of claim) {
      const others = claim.filter((condition) => condition !== atom);
      const piece = uncoveredPieces.find((poses) => poses.every((pose) => holds(others, pose)));
      if (piece && isSound(others, keepPose))
        return [{ slip: message("slip.too-narrow", { joint: withGreek(nameJointsOfAtom(atom, joints)) }), piece }];
    }
  for (const joint of angles) {
    const piece = uncoveredPieces.find((poses) =>
      poses.every((pose) => claims.some((claim) => holds(claim, rotateJoint(joint, HALF_TURN)(pose)))),
    );
    if (piece) return [{ slip: message("slip.half-turn", { joint: withGreek(joint) }), piece }];
  }
  const fixesJoint = (piece: Piece) => joints.some((joint) => isFixed(piece, joint, angles));
  const [pieceOfValues, tiePiece] = [
    uncoveredPieces.find(fixesJoint),
    uncoveredPieces.find((piece) => !fixesJoint(piece)),
  ];
  return [
    ...(pieceOfValues ? [{ slip: message("slip.values-left-out"), piece: pieceOfValues }] : []),
    ...(tiePiece ? [{ slip: message("slip.tie-left-out"), piece: tiePiece }] : []),
  ];
}
