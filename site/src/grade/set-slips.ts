// Slips in sets of singular configurations: a condition that is right once one thing in it is changed.

import { evaluate } from "../read/evaluate.js";
import { namesIn } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import type { Atom, Piece } from "./pieces.js";
import { seen } from "./values.js";
import type { At } from "./verdict.js";

const HALF_TURN = Math.PI;
/** An angle from here on is none in radians. */
const DEGREES_FROM = 10;

export interface Claims {
  readonly claims: readonly Piece[];
  /** Those of which some pose is not singular, and pieces of the right set that no claim covers. */
  readonly bad: readonly Piece[];
  readonly open: readonly (readonly At[])[];
  readonly joints: readonly string[];
  readonly angles: ReadonlySet<string>;
  readonly holds: (claim: Piece, at: At) => boolean;
  /** Whether all poses on a claim are singular where each is another one than it says. */
  readonly isSound: (claim: Piece, instead: (at: At) => At) => boolean;
}

/** A slip, and what it is about: a claim of the answer, or a piece of the right set that no claim covers. */
export interface SetSlip {
  readonly slip: Message;
  readonly claim?: Piece;
  readonly piece?: readonly At[];
}

/** What went wrong in a set that is not right; null where no one change helps. */
export function slipInSet(set: Claims): SetSlip | null {
  const { claims, bad, open, angles, holds } = set;
  for (const claim of bad) {
    const radians = claim.map((atom) => inRadians(atom, angles));
    if (radians.some((atom, i) => atom !== claim[i]) && fits(set, radians))
      return { slip: message("slip.degrees"), claim };
  }
  for (const claim of bad) {
    const said = claim.flatMap(({ joint, zero }) => (joint === null ? [...namesIn(zero)] : [joint]));
    for (const joint of new Set(said.filter((each) => angles.has(each))))
      for (const turn of [HALF_TURN / 2, -HALF_TURN / 2])
        if (fits(set, claim, turned(joint, turn), turned(joint, -turn)))
          return { slip: message("slip.quarter-turn", { joint: seen(joint) }), claim };
    for (const joint of new Set(said))
      for (const other of set.joints)
        if (other !== joint && angles.has(joint) === angles.has(other)) {
          const swap = exchanged(joint, other);
          if (fits(set, claim, swap, swap))
            return { slip: message("slip.other-joint", { joint: seen(joint) }), claim };
        }
  }
  if (bad.length > 0) return null;
  for (const joint of angles) {
    const piece = open.find((poses) =>
      poses.every((at) => claims.some((claim) => holds(claim, turned(joint, HALF_TURN)(at)))),
    );
    if (piece) return { slip: message("slip.half-turn", { joint: seen(joint) }), piece };
  }
  return null;
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

/** A value of an angle that was typed in degrees, in radians; everything else as it is. */
function inRadians(atom: Atom, angles: ReadonlySet<string>): Atom {
  const { joint, zero } = atom;
  if (joint === null || !angles.has(joint) || namesIn(zero).size > 0) return atom;
  const value = evaluate(zero, {}).re;
  if (!(Math.abs(value) >= DEGREES_FROM)) return atom;
  return { joint, zero: { ...zero, kind: "decimal", args: [], value: (value * Math.PI) / 180 } };
}
