// Judge sets of configurations: every pose of the reference must be covered, and every claimed pose must be singular.
//
// Gauss-Newton steps from random starts find poses on a claim, and the arm decides whether they are singular. As in
// ../../../grader/formulas.py, only true claims earn points: a claim that always holds would cover everything.

import { solveDamped } from "../arm/svd.js";
import type { ConfigurationsKey } from "../bank.js";
import { randomNumbers } from "../random.js";
import { evaluate } from "../read/evaluate.js";
import { withPointsOfLengths } from "../read/notation.js";
import { withPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { sizeOf } from "../read/products.js";
import {
  anyNode,
  CHAIN,
  chainOf,
  decimal,
  hasBlank,
  integer,
  name,
  namesIn,
  type Node,
  node,
  ParseError,
  replaceName,
} from "../read/tree.js";
import { LIMITS, VOCABULARY } from "../read/vocabulary.js";
import { message, type Message } from "../text/text.js";
import { type Atom, parseClaims, type Piece, vanishingModuloTurns } from "./claims.js";
import { falseConditions, shareOfSet } from "./credit.js";
import { slipsInSet } from "./set-slips.js";
import { type SymbolValues, correct, verdictOf, parseOrVerdict, missing, type Verdict, wrong } from "./verdict.js";
import { isBlank } from "./forms.js";
import { arbitraryNumber, atText } from "./values.js";

/** Tolerance of a condition (rad or m), and of a value, which keys state with nine decimals. */
const CONDITION_TOLERANCE = 1e-6;
const VALUE_TOLERANCE = 1e-9;
/** Relative tolerance of a typed value, and the distance (rad or m) up to which it counts as rounded. */
const TYPED_TOLERANCE = 1e-12;
const ROUNDED_WITHIN = 5e-3;
const START_COUNT = 12;
const MAX_STEPS = 40;
const DIFFERENCE_STEP = 1e-6;
/** Damping, which keeps steps short if conditions depend on each other. */
const DAMPING = 1e-7;
const FULL_TURN = 2 * Math.PI;
/** A smaller value, relative to its terms, is a rounding error. */
const ROUNDING_ERROR = 4e-16;
/** If no pose is found, this many random poses are checked; below the second limit, a condition almost holds. */
const CHECKED_POSES = 2000;
const CLOSE_RESIDUAL = 1e-3;

/** Return whether the arm is singular in a pose. */
export type IsSingular = (at: SymbolValues) => boolean;

type Space = { readonly joints: readonly string[]; readonly angles: ReadonlySet<string> };

/** What the search for slips needs, too: all symbols, and the constants that the table adds to joint variables. */
type Table = Space & { readonly symbols: readonly string[]; readonly offsets: ReadonlyMap<string, number> };

/** Judge conditions. Values of joints in `angles` count modulo full turns; the table adds `offsets` to them. */
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
  return parseOrVerdict(() => {
    const tree = parse(answer, new Set(key.symbols));
    if (isBlank(tree)) return missing();
    const conditions = withoutBlanks(substituteIntegers(tree));
    const refused = ambiguityIn(answer, conditions, key);
    if (refused) return refused;
    const claims = parseClaims(assignJoint(conditions, space), new Set(key.joints));
    return compare(claims, posesOf(key, conditions), space, isSingular);
  });
}

/** For each condition, the poses on each of its pieces. */
type Conditions = readonly (readonly SymbolValues[])[][];

/** Return the poses of each nonempty piece; names that the problem does not have get arbitrary numbers. */
function posesOf(key: ConfigurationsKey, tree: Node): Conditions {
  const unknown = [...namesIn(tree)].filter((symbol) => !key.symbols.includes(symbol));
  const poseOf = (values: readonly number[], k: number): SymbolValues => ({
    ...Object.fromEntries(unknown.map((symbol) => [symbol, arbitraryNumber(symbol, k)])),
    ...Object.fromEntries(key.symbols.map((symbol, i) => [symbol, values[i] as number])),
  });
  let start = 0;
  const piecesByCondition = (key.conditions ?? [key.pieces.length]).map((count) =>
    key.pieces.slice(start, (start += count)).filter((piece) => piece.length > 0),
  );
  return piecesByCondition
    .filter((pieces) => pieces.length > 0)
    .map((pieces) => pieces.map((piece) => piece.map(poseOf)));
}

/** Substitute the listed values of an integer, as in theta2 = k*pi, k = 0, 1; dots after them mean any integer. */
function substituteIntegers(tree: Node): Node {
  const at = tree.kind === "list" ? tree.args.findIndex(isWholeNumber) : 0;
  const following = tree.args.slice(at + 1);
  const isStatement = ({ kind }: Node): boolean => ["eq", "in", "and", "or", "dict", "list"].includes(kind);
  if (at <= 0 || following.some(isStatement)) return tree;
  const [integerName, listed] = (tree.args[at] as Node).args as readonly [Node, Node];
  const values = [...(listed.kind === "list" || listed.kind === "set" ? listed.args : [listed]), ...following];
  const conditions = node("list", ...tree.args.slice(0, at));
  if (values.some(hasBlank)) return conditions;
  const flat = values.flatMap((value) => (value.kind === "set" ? value.args : [value]));
  if (sizeOf(conditions, Infinity) * flat.length > LIMITS.nodes_of_results) throw new ParseError("read.many-cases");
  return node("list", ...flat.flatMap((value) => replaceName(conditions, integerName.text, value).args));
}

/** Return whether the values of an integer are listed, as in k = 0, 1 or k in {0, 1}. */
function isWholeNumber({ kind, args: [left, right] }: Node): boolean {
  return (
    (kind === "eq" || kind === "in") && VOCABULARY.whole_numbers.includes(left?.text ?? "") && right?.kind !== "name"
  );
}

/** Return conditions without parts that state nothing: blanks, dots behind 0, pi, 2*pi, …, det J = 0, k in Z. */
function withoutBlanks(tree: Node): Node {
  const [left, right] = tree.args;
  const isList = ({ kind }: Node) => kind === "list" || kind === "set";
  if (["eq", "in", "pair"].includes(tree.kind) && left && right && isList(right))
    return node(tree.kind, left, withoutBlanks(right));
  if (!["and", "or", "list", "set"].includes(tree.kind)) return tree;
  const statements = tree.args.filter((arg) => !isEmptyStatement(arg));
  const relevant = statements.length > 0 ? statements : tree.args;
  if (!isList(tree) && relevant.length === 1) return withoutBlanks(relevant[0] as Node);
  return { ...tree, args: tree.kind === "and" ? relevant : relevant.map(withoutBlanks) };
}

/** Return whether an entry is blank, or only states that k is an integer, or that det J is zero. */
function isEmptyStatement(tree: Node): boolean {
  const [left, right] = tree.args;
  const names = tree.kind === "eq" && left ? [...namesIn(left)] : [];
  if (names.length > 0 && names.every((symbol) => VOCABULARY.determinant.includes(symbol))) return true;
  if (tree.kind === "in" && VOCABULARY.number_sets.includes(right?.text ?? "")) return true;
  if (tree.kind === "in" && VOCABULARY.whole_numbers.includes(left?.text ?? ""))
    return VOCABULARY.whole_number_sets.includes(right?.text ?? "");
  const hasSeveralValues =
    ["eq", "in", "pair"].includes(tree.kind) && (right?.kind === "list" || right?.kind === "set");
  return hasBlank(tree) && !hasSeveralValues;
}

/** Return the verdict on conditions that are ambiguous or no conditions; null if there are none. */
function ambiguityIn(answer: string, tree: Node, key: ConfigurationsKey): Verdict | null {
  const joint = key.joints.at(-1) ?? "";
  const used = [...namesIn(tree)];
  const unknown = used.filter(
    (symbol) =>
      !key.symbols.includes(symbol) && !key.joints.includes(symbol) && !VOCABULARY.whole_numbers.includes(symbol),
  );
  if (unknown.length > 0)
    return wrong("read.unknown", { names: unknown.sort().slice(0, 5).join(", "), known: key.symbols.join(", ") });
  if (withPoints(answer) !== answer) return wrong("read.comma");
  if (hasProductInChain(tree, key.joints)) return wrong("read.chain");
  const conditions = ["list", "set", "or"].includes(tree.kind) ? tree.args : [tree];
  const isBare = (condition: Node) =>
    ["+", "-", "*", "/", "^", "neg", "call"].includes(condition.kind) &&
    key.joints.some((joint) => namesIn(condition).has(joint));
  return conditions.some(isBare) ? wrong("read.bare-condition", { joint }) : null;
}

/** Return whether a product with a joint is between two equals signs: the joint might begin another condition. */
function hasProductInChain(tree: Node, joints: readonly string[]): boolean {
  const endsInJoint = ({ kind, args: [, last] }: Node): boolean =>
    kind === "*" && last?.kind === "name" && joints.includes(last.text);
  return anyNode(
    tree,
    (statement) =>
      statement.kind === "and" && statement.text === CHAIN && chainOf(statement).slice(1, -1).some(endsInJoint),
  );
}

/** Assign bare values, as in {0, pi}, to the only joint. Throws ParseError if there are several joints. */
function assignJoint(tree: Node, { joints }: Space): Node {
  const values = tree.kind === "list" || tree.kind === "set" ? tree.args : [tree];
  const isStatement = (arg: Node) =>
    ["eq", "in", "dict", "and", "or", "list", "set"].includes(arg.kind) ||
    joints.some((joint) => namesIn(arg).has(joint));
  if (values.length === 0 || values.some(isStatement)) return tree;
  const [joint] = joints;
  if (joint === undefined || joints.length > 1) throw new ParseError("read.no-joint"); // it is unclear which one
  return node("in", name(joint), node("set", ...values));
}

function compare(typed: readonly Piece[], conditions: Conditions, space: Table, isSingular: IsSingular): Verdict {
  const pieces = conditions.flat();
  const claims = typed.map((claim) => withExactValues(claim, pieces, space));
  const counterexamples = claims.map((claim, i) => counterexample(claim, space, isSingular, i, pieces.flat()));
  const rounded = typed.find((claim, i) => claim !== claims[i] && counterexamples[i] === null);
  const sound = claims.filter((_, i) => counterexamples[i] === null);
  const wrongClaims = claims.filter((_, i) => counterexamples[i] !== null && counterexamples[i] !== "nowhere");
  const findUncovered = (by: readonly Piece[], piece: readonly SymbolValues[]) =>
    piece.find((at) => !by.some((claim) => holdsAt(claim, at, space)));
  const uncovered = pieces.flatMap((piece): SymbolValues[] => {
    const at = findUncovered([...sound, ...wrongClaims], piece);
    return at ? [at] : [];
  });
  if (claims.length > 0 && uncovered.length === 0 && wrongClaims.length === 0 && !rounded)
    return correct(message("verdict.set"), false);
  // A claim beyond the right set must not earn points for what it happens to cover.
  const isCovered = (piece: readonly SymbolValues[]) => findUncovered(sound, piece) === undefined;
  const share = shareOfSet(
    conditions.map((pieces) => [pieces.filter(isCovered).length, pieces.length]),
    falseConditions(
      wrongClaims.map((claim) => jointsOf(claim, space)),
      new Set(sound.map((claim) => jointsOf(claim, space))),
    ),
    rounded !== undefined,
  );
  const slips = slipsInSet({
    claims,
    wrongClaims,
    pieces,
    uncovered: pieces.filter((piece) => findUncovered(claims, piece) !== undefined),
    ...space,
    holds: (claim, at) => holdsAt(claim, at, space),
    isSound: (claim, substitute) =>
      counterexample(claim, space, (at) => isSingular(substitute(at)), 0, pieces.flat()) === null,
  });
  const [slip] = slips;
  const verdict = (reasons: readonly Message[], at?: SymbolValues) =>
    verdictOf(share, [...(rounded ? [message("verdict.rounded")] : []), ...reasons], {
      ...(at ? { at } : {}),
      ...(slip ? { slips: slips.map((setSlip) => setSlip.slip) } : {}),
    });
  // show the pose to which the first slip refers
  const counterexampleOfSlip = slip?.claim && counterexamples[claims.indexOf(slip.claim)];
  const regularPose = [counterexampleOfSlip, ...counterexamples].find(
    (result) => typeof result === "object" && result !== null,
  );
  if (regularPose)
    return verdict([message("verdict.unsound", { at: atText(jointValues(regularPose, space)) })], regularPose);
  const missed = (slip?.piece && findUncovered(claims, slip.piece)) ?? uncovered[0];
  if (missed) return verdict([message("verdict.uncovered", { at: atText(jointValues(missed, space)) })], missed);
  if (rounded) {
    const constants = rounded.filter(({ joint, zero }) => joint !== null && namesIn(zero).size === 0);
    const values = constants.map(({ joint, zero }) => [joint, evaluate(zero, {}).re]);
    return verdict([], { ...pieces[0]?.[0], ...Object.fromEntries(values) });
  }
  const nowhere = counterexamples.findIndex((result) => result === "nowhere" || result === "close") + 1;
  return verdict([message("verdict.nowhere", { text: String(nowhere) })]);
}

/** Return the joints in a piece. */
function jointsOf(piece: Piece, { joints }: Space): string {
  const named = new Set(piece.flatMap(({ joint, zero }) => [joint, ...namesIn(zero)]));
  return joints.filter((joint) => named.has(joint)).join(" ");
}

function jointValues(at: SymbolValues, { joints }: Space): SymbolValues {
  return Object.fromEntries(joints.map((joint) => [joint, at[joint] as number]));
}

/** Return whether a piece holds in a pose, within tolerances. */
function holdsAt(piece: Piece, at: SymbolValues, space: Space): boolean {
  return piece.every((atom) => {
    const difference = zeroOf(atom);
    const sum = vanishingModuloTurns(difference, space.angles);
    const isConstant = namesIn(atom.zero).size === 0;
    if (atom.joint !== null && (isConstant || sum === difference)) {
      const { re, im } = evaluate(atom.zero, at);
      const tolerance = isConstant ? VALUE_TOLERANCE : CONDITION_TOLERANCE;
      return Math.abs(im) < tolerance && distance(atom.joint, at[atom.joint] as number, re, space) < tolerance;
    }
    const { re, im, size } = evaluate(sum, at);
    if (!Number.isFinite(re)) return false;
    const slope = Math.hypot(...space.joints.map((joint) => slopeOf(sum, at, joint)));
    return Math.hypot(re, im) <= Math.max(CONDITION_TOLERANCE * slope, 1e-11 * size);
  });
}

function distance(joint: string, a: number, b: number, { angles }: Space): number {
  const difference = Math.abs(a - b);
  if (!angles.has(joint)) return difference;
  const remainder = difference % FULL_TURN;
  return Math.min(remainder, FULL_TURN - remainder);
}

function slopeOf(zero: Piece[number]["zero"], at: SymbolValues, joint: string): number {
  const above = evaluate(zero, { ...at, [joint]: (at[joint] as number) + DIFFERENCE_STEP }).re;
  const below = evaluate(zero, { ...at, [joint]: (at[joint] as number) - DIFFERENCE_STEP }).re;
  return (above - below) / (2 * DIFFERENCE_STEP);
}

/** Return a regular pose on a piece; null if all found poses are singular; "nowhere" or "close" if no pose is found. */
function counterexample(
  piece: Piece,
  space: Space,
  isSingular: IsSingular,
  seed: number,
  lengths: readonly SymbolValues[],
): SymbolValues | "nowhere" | "close" | null {
  const random = randomNumbers((seed + 1) * 0x9e3779b9);
  const fixedValues = (k: number): SymbolValues => lengths[k % Math.max(lengths.length, 1)] ?? {};
  const zeros = zerosOf(piece, space);
  const free = space.joints.filter((joint) => zeros.some((zero) => namesIn(zero).has(joint)));
  let foundCount = 0;
  for (let start = 0; start < START_COUNT; start += 1) {
    const at = solve(piece, zeros, free, randomPose(fixedValues(start), space, random));
    if (!at || !holdsAt(piece, at, space)) continue;
    foundCount += 1;
    if (!isSingular(at)) return at;
  }
  if (foundCount > 0) return null;
  const nearest = Math.min(
    ...Array.from({ length: CHECKED_POSES }, (_, k) => missOf(zeros, randomPose(fixedValues(k), space, random))),
  );
  return nearest < CLOSE_RESIDUAL ? "close" : "nowhere";
}

/** Return how far the conditions are from zero in a pose, relative to their terms. */
function missOf(zeros: readonly Node[], at: SymbolValues): number {
  const misses = zeros.map((zero) => {
    const { re, im, size } = evaluate(zero, at);
    return Math.abs(im) < CONDITION_TOLERANCE ? Math.abs(re) / Math.max(size, 1e-300) : Infinity;
  });
  return misses.some(Number.isNaN) ? Infinity : Math.max(...misses);
}

/** Return a claim on values with rounded values replaced by exact ones: pi for 3.14 or 355/113. */
function withExactValues(claim: Piece, poses: readonly (readonly SymbolValues[])[], space: Space): Piece {
  const atoms = claim.map((atom) => {
    if (atom.joint === null || namesIn(atom.zero).size > 0) return withExactSum(atom, poses, space);
    const exact = exactValueOf(atom, poses, space);
    return exact === null ? atom : { ...atom, zero: integer(exact) };
  });
  return atoms.every((atom, i) => atom === claim[i]) ? claim : atoms;
}

/** Return a condition on a sum of angles with its rounded value replaced by the exact one: theta1 + theta2 = 3.14. */
function withExactSum(atom: Atom, poses: readonly (readonly SymbolValues[])[], { angles }: Space): Atom {
  const difference = zeroOf(atom);
  if (vanishingModuloTurns(difference, angles) === difference) return atom;
  const exact = poses
    .map((piece) => piece.map((at) => Math.asin(Math.sin(evaluate(difference, at).re / 2)) * 2))
    .find(([first = NaN, ...others]) => {
      const isConstant = others.every((other) => Math.abs(other - first) < 1e-8); // poses have nine decimals
      return isConstant && Math.abs(first) < ROUNDED_WITHIN && Math.abs(first) > 1e-8;
    });
  return exact ? { joint: null, zero: node("-", difference, decimal(exact[0] as number)) } : atom;
}

/** Return the value of a joint on some piece of which the typed value is a rounded one; null if there is none. */
function exactValueOf({ joint, zero }: Atom, poses: readonly (readonly SymbolValues[])[], space: Space): number | null {
  if (joint === null || namesIn(zero).size > 0) return null;
  const value = evaluate(zero, {}).re;
  const nearest = poses
    .map((others) => others.map((other) => other[joint] as number))
    .filter((values) => values.every((exact) => distance(joint, exact, values[0] as number, space) < VALUE_TOLERANCE))
    .map(([exact]) => ({ exact: exact as number, error: distance(joint, value, exact as number, space) }))
    .filter(({ error }) => error < ROUNDED_WITHIN)
    .sort((a, b) => a.error - b.error)[0];
  if (!nearest) return null;
  // values found by a search are stored with nine decimals
  const isNumeric = nearest.exact !== 0 && Math.round(nearest.exact * 1e9) / 1e9 === nearest.exact;
  return nearest.error >= (isNumeric ? VALUE_TOLERANCE : TYPED_TOLERANCE * Math.max(1, Math.abs(nearest.exact)))
    ? nearest.exact
    : null;
}

function randomPose(fixedValues: SymbolValues, { joints, angles }: Space, random: () => number): SymbolValues {
  const values = joints.map((joint) => [joint, angles.has(joint) ? FULL_TURN * (random() - 0.5) : 0.2 + random()]);
  return { ...fixedValues, ...Object.fromEntries(values) };
}

/** Return the expressions that vanish if the conditions of a piece hold. */
const zerosOf = (piece: Piece, { angles }: Space): Node[] =>
  piece.map((atom) => {
    const isValue = atom.joint !== null && namesIn(atom.zero).size === 0;
    return isValue ? zeroOf(atom) : vanishingModuloTurns(zeroOf(atom), angles);
  });

const zeroOf = ({ joint, zero }: Atom): Node => (joint === null ? zero : node("-", name(joint), zero));

/** Return the pose moved by Gauss-Newton steps of least norm to where a piece holds; null if the steps fail. */
function solve(
  piece: Piece,
  zeros: readonly Node[],
  free: readonly string[],
  start: SymbolValues,
): SymbolValues | null {
  let at = start;
  for (const { joint, zero } of piece) if (joint !== null) at = { ...at, [joint]: evaluate(zero, at).re };
  for (let step = 0; step < MAX_STEPS; step += 1) {
    const here = at;
    const error = zeros.map((zero) => {
      const { re, size } = evaluate(zero, here);
      return Number.isFinite(size) && Math.abs(re) <= ROUNDING_ERROR * size ? 0 : re;
    });
    if (error.every((value) => value === 0)) break;
    const moves = leastNorm(
      zeros.map((zero) => free.map((joint) => slopeOf(zero, here, joint))),
      error,
    );
    if (!moves.every(Number.isFinite)) return null;
    const changes = free.map((joint, i) => [joint, here[joint]! - Math.max(-1, Math.min(1, moves[i]!))]);
    at = { ...here, ...Object.fromEntries(changes) };
    if (Math.max(0, ...moves.map(Math.abs)) < 1e-12) break;
  }
  return at;
}

/** Return the shortest x with A x = b. Rows are normalised because slopes vanish at a double zero, as of sin². */
function leastNorm(a: readonly (readonly number[])[], b: readonly number[]): number[] {
  const equations = a.flatMap((row, i) => {
    const length = Math.hypot(...row);
    return b[i] === 0 ? [] : [{ row: row.map((x) => x / length), value: (b[i] as number) / length }];
  });
  return solveDamped(
    equations.map(({ row }) => row),
    equations.map(({ value }) => value),
    DAMPING,
  );
}
