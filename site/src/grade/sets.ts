// Judge sets of configurations: every pose of the reference must be covered, and every claimed pose must be singular.
//
// Gauss-Newton steps from random starts find poses on a claim, and the arm decides whether they are singular. As in
// ../../../grader/judging/formulas.py, only true claims earn points: a claim that always holds would cover everything.

import { solveDamped } from "../arm/svd.js";
import { clamp } from "../arm/vector.js";
import type { ConfigurationsKey } from "../bank.js";
import { makeRandomNumbers } from "../random.js";
import { evaluate } from "../read/evaluate.js";
import { usePointsInLengths } from "../read/notation.js";
import { readCommasAsPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { countNodes } from "../read/products.js";
import type { Node, SymbolValues } from "../read/tree.js";
import { anyNode, CHAIN, listSides, decimal, hasBlank, hasNameOf, integer, isConstant } from "../read/tree.js";
import { isListOrSet, name, findNames, node, ParseError, replaceName } from "../read/tree.js";
import { LIMITS, VOCABULARY } from "../read/vocabulary.js";
import { message, type Message } from "../text/text.js";
import { type Atom, parseClaims, type Claim, allowFullTurns } from "./claims.js";
import { countFalseConditions, computeShareOfSet } from "./credit.js";
import { findSlipsInSet } from "./set-slips.js";
import { correct, isVerdict, listNames, missing, parseOrVerdict, type Verdict, verdictOf, wrong } from "./verdict.js";
import { isBlank, requireScalars } from "./forms.js";
import { makeArbitraryNumber, writeConfiguration } from "./values.js";

/** Absolute tolerances of a condition and of a joint's value, in rad or m of the joints: keys have nine decimals. */
const CONDITION_TOLERANCE = 1e-6;
const VALUE_TOLERANCE = 1e-9;
/** Tolerance of a typed value, relative to the exact one; and its maximum distance from it (rad or m) if rounded. */
const TYPED_TOLERANCE = 1e-12;
const MAX_ROUNDING = 5e-3;
/** Number of random starts from which poses on a claim are searched, and the steps of each search. */
const START_COUNT = 12;
const MAX_STEPS = 40;
/** Step of numeric derivatives (rad or m). */
const DIFFERENCE_STEP = 1e-6;
/** Damping of least-squares steps, which keeps steps short if conditions depend on each other. */
const DAMPING = 1e-7;
/** In radians. */
const FULL_TURN = 2 * Math.PI;
/** A smaller value, relative to its terms, is a rounding error. */
const ROUNDING_ERROR = 4e-16;
/** If no pose is found, this many random poses are checked; below the second limit, a condition almost holds. */
const RANDOM_POSE_COUNT = 2000;
const CLOSE_RESIDUAL = 1e-3;

/** Return whether the arm is singular in a pose. */
export type IsSingular = (pose: SymbolValues) => boolean;

/** Return a predicate that decides whether formulas are zero in a pose. */
export function createZeroTest(formulas: readonly string[], symbols: readonly string[]): IsSingular {
  const trees = formulas.map((formula) => parse(formula, new Set(symbols)));
  return (pose) =>
    trees.every((tree) => {
      const { re, im, size } = evaluate(tree, pose);
      return Math.hypot(re, im) < CONDITION_TOLERANCE * Math.max(size, 1);
    });
}

/** Names of the joint variables, and of those that are angles. */
type JointSpace = { readonly joints: readonly string[]; readonly angles: ReadonlySet<string> };

/** For slips, too: all symbols of the problem, and the constants (rad) that the table adds to joint variables. */
type ArmSymbols = JointSpace & { readonly symbols: readonly string[]; readonly offsets: ReadonlyMap<string, number> };

/** Judge conditions. Values of joints in `angles` count modulo full turns; the table adds `offsets` (rad) to them. */
export function judgeSet(
  typed: string,
  key: ConfigurationsKey,
  angles: ReadonlySet<string>,
  isSingular: IsSingular,
  offsets: ReadonlyMap<string, number> = new Map(),
): Verdict {
  const armSymbols: ArmSymbols = { joints: key.joints, angles, offsets, symbols: key.symbols };
  return parseOrVerdict(() => {
    const conditions = readConditions(typed, key);
    if (isVerdict(conditions)) return conditions;
    return judgeClaims(conditions.claims, listPosesByCondition(key, conditions.tree), armSymbols, isSingular);
  });
}

/** Conditions as they were parsed, and the claims that they make. */
type Conditions = { readonly tree: Node; readonly claims: readonly Claim[] };

/** Return the conditions in an answer, or the verdict on one without conditions. Throws ParseError. */
export function readConditions(
  typed: string,
  form: Pick<ConfigurationsKey, "joints" | "symbols">,
): Conditions | Verdict {
  if (!typed.trim()) return missing();
  const answer = usePointsInLengths(typed);
  const typedTree = parse(answer, new Set(form.symbols));
  if (isBlank(typedTree)) return missing();
  const tree = removeBlanks(substituteIntegers(typedTree));
  const ambiguity = findAmbiguity(answer, tree, form);
  if (ambiguity) return ambiguity;
  const claims = parseClaims(assignJoint(tree, form), new Set(form.joints));
  requireScalars(claims.map((claim) => claim.map(({ expression }) => expression)));
  return { tree, claims };
}

/** Some poses on each piece of a set. */
type Pieces = readonly (readonly SymbolValues[])[];
/** The pieces of each condition of the reference. */
type PiecesByCondition = readonly Pieces[];

/** Return the poses of each nonempty piece; names that the problem does not have get arbitrary numbers. */
function listPosesByCondition(key: ConfigurationsKey, tree: Node): PiecesByCondition {
  const unknownNames = [...findNames(tree)].filter((name) => !key.symbols.includes(name));
  const poseOf = (values: readonly number[], k: number): SymbolValues => ({
    ...Object.fromEntries(unknownNames.map((name) => [name, makeArbitraryNumber(name, k)])),
    ...Object.fromEntries(key.symbols.map((symbol, i) => [symbol, values[i] as number])),
  });
  let firstPiece = 0;
  const piecesByCondition = (key.conditions ?? [key.pieces.length]).map((count) =>
    key.pieces.slice(firstPiece, (firstPiece += count)).filter((piece) => piece.length > 0),
  );
  return piecesByCondition
    .filter((pieces) => pieces.length > 0)
    .map((pieces) => pieces.map((piece) => piece.map(poseOf)));
}

/** Substitute the listed values of an integer, as in theta2 = k*pi, k = 0, 1; dots after them mean any integer. */
function substituteIntegers(tree: Node): Node {
  const equationIndex = tree.kind === "list" ? tree.args.findIndex(listsWholeNumbers) : 0;
  const laterArgs = tree.args.slice(equationIndex + 1);
  const isStatement = ({ kind }: Node): boolean => ["eq", "in", "and", "or", "dict", "list"].includes(kind);
  if (equationIndex <= 0 || laterArgs.some(isStatement)) return tree;
  const [integerName, firstValues] = (tree.args[equationIndex] as Node).args as readonly [Node, Node];
  const values = [...(isListOrSet(firstValues) ? firstValues.args : [firstValues]), ...laterArgs];
  const conditions = node("list", ...tree.args.slice(0, equationIndex));
  if (values.some(hasBlank)) return conditions;
  const allValues = values.flatMap((value) => (value.kind === "set" ? value.args : [value]));
  if (countNodes(conditions, Infinity) * allValues.length > LIMITS.nodes_of_results)
    throw new ParseError("read.many-cases");
  return node("list", ...allValues.flatMap((value) => replaceName(conditions, integerName.text, value).args));
}

/** Return whether the values of an integer are listed, as in k = 0, 1 or k in {0, 1}. */
function listsWholeNumbers({ kind, args: [left, right] }: Node): boolean {
  return (
    (kind === "eq" || kind === "in") && VOCABULARY.whole_numbers.includes(left?.text ?? "") && right?.kind !== "name"
  );
}

/** Return conditions without parts that state nothing: blanks, the dots in 0, pi, 2*pi, …, det J = 0, and k in Z. */
function removeBlanks(tree: Node): Node {
  const [left, right] = tree.args;
  if (["eq", "in", "pair"].includes(tree.kind) && left && right && isListOrSet(right))
    return node(tree.kind, left, removeBlanks(right));
  if (!["and", "or", "list", "set"].includes(tree.kind)) return tree;
  const statements = tree.args.filter((arg) => !isEmptyStatement(arg));
  const remainingArgs = statements.length > 0 ? statements : tree.args;
  if (!isListOrSet(tree) && remainingArgs.length === 1) return removeBlanks(remainingArgs[0] as Node);
  return { ...tree, args: tree.kind === "and" ? remainingArgs : remainingArgs.map(removeBlanks) };
}

/** Return whether an entry is blank, or only states that k is an integer, or that det J is zero. */
function isEmptyStatement(tree: Node): boolean {
  const [left, right] = tree.args;
  const names = tree.kind === "eq" && left ? [...findNames(left)] : [];
  if (names.length > 0 && names.every((symbol) => VOCABULARY.determinant.includes(symbol))) return true;
  if (tree.kind === "in" && VOCABULARY.number_sets.includes(right?.text ?? "")) return true;
  if (tree.kind === "in" && VOCABULARY.whole_numbers.includes(left?.text ?? ""))
    return VOCABULARY.whole_number_sets.includes(right?.text ?? "");
  const hasSeveralValues = ["eq", "in", "pair"].includes(tree.kind) && isListOrSet(right);
  return hasBlank(tree) && !hasSeveralValues;
}

/** Return the verdict if a condition is ambiguous or is not a condition; else null. */
function findAmbiguity(answer: string, tree: Node, key: Pick<ConfigurationsKey, "joints" | "symbols">): Verdict | null {
  const knownNames = [...key.symbols, ...VOCABULARY.whole_numbers];
  const unknownNames = [...findNames(tree)].filter((name) => !knownNames.includes(name));
  if (unknownNames.length > 0)
    return wrong("read.unknown", { names: listNames(unknownNames), known: key.symbols.join(", ") });
  if (readCommasAsPoints(answer) !== answer) return wrong("read.comma");
  if (hasProductInChain(tree, key.joints)) return wrong("read.chain");
  const conditions = ["list", "set", "or"].includes(tree.kind) ? tree.args : [tree];
  const isBare = (condition: Node) =>
    ["+", "-", "*", "/", "^", "neg", "call"].includes(condition.kind) && hasNameOf(condition, new Set(key.joints));
  return conditions.some(isBare) ? wrong("read.bare-condition", { joint: key.joints.at(-1) ?? "" }) : null;
}

/** Return whether a product with a joint is between two equals signs: the joint might begin another condition. */
function hasProductInChain(tree: Node, joints: readonly string[]): boolean {
  const endsInJoint = ({ kind, args: [, last] }: Node): boolean =>
    kind === "*" && last?.kind === "name" && joints.includes(last.text);
  return anyNode(
    tree,
    (statement) =>
      statement.kind === "and" && statement.text === CHAIN && listSides(statement).slice(1, -1).some(endsInJoint),
  );
}

/** Assign bare values, as in {0, pi}, to the only joint. Throws ParseError if there are several joints. */
function assignJoint(tree: Node, { joints }: Pick<JointSpace, "joints">): Node {
  const values = isListOrSet(tree) ? tree.args : [tree];
  const isStatement = (arg: Node) =>
    ["eq", "in", "dict", "and", "or", "list", "set"].includes(arg.kind) || hasNameOf(arg, new Set(joints));
  if (values.length === 0 || values.some(isStatement)) return tree;
  const [joint] = joints;
  if (joint === undefined || joints.length > 1) throw new ParseError("read.no-joint"); // it is unclear which one
  return node("in", name(joint), node("set", ...values));
}

/** Judge the claims of an answer by the poses of each condition of the reference. */
function judgeClaims(
  typedClaims: readonly Claim[],
  conditions: PiecesByCondition,
  armSymbols: ArmSymbols,
  isSingular: IsSingular,
): Verdict {
  const pieces = conditions.flat();
  const claims = typedClaims.map((claim) => replaceRoundedValues(claim, pieces, armSymbols));
  const counterexamples = claims.map((claim, i) => findCounterexample(claim, armSymbols, isSingular, i, pieces.flat()));
  const roundedClaim = typedClaims.find((claim, i) => claim !== claims[i] && counterexamples[i] === null);
  const soundClaims = claims.filter((_, i) => counterexamples[i] === null);
  const wrongClaims = claims.filter((_, i) => counterexamples[i] !== null && counterexamples[i] !== "nowhere");
  const findUncoveredPose = (coveringClaims: readonly Claim[], piece: readonly SymbolValues[]) =>
    piece.find((pose) => !coveringClaims.some((claim) => holdsAt(claim, pose, armSymbols)));
  const uncoveredPoses = pieces.flatMap((piece): SymbolValues[] => {
    const pose = findUncoveredPose([...soundClaims, ...wrongClaims], piece);
    return pose ? [pose] : [];
  });
  if (claims.length > 0 && uncoveredPoses.length === 0 && wrongClaims.length === 0 && !roundedClaim)
    return correct(message("verdict.set"), false);
  // A claim with regular poses must not earn points for the pieces that it happens to cover.
  const isCovered = (piece: readonly SymbolValues[]) => findUncoveredPose(soundClaims, piece) === undefined;
  const share = computeShareOfSet(
    conditions.map((condition) => ({ found: condition.filter(isCovered).length, expected: condition.length })),
    countFalseConditions(
      wrongClaims.map((claim) => nameJointsOfClaim(claim, armSymbols)),
      new Set(soundClaims.map((claim) => nameJointsOfClaim(claim, armSymbols))),
    ),
    roundedClaim !== undefined,
  );
  const slips = findSlipsInSet({
    claims,
    wrongClaims,
    pieces,
    uncoveredPieces: pieces.filter((piece) => findUncoveredPose(claims, piece) !== undefined),
    ...armSymbols,
    holds: (claim, pose) => holdsAt(claim, pose, armSymbols),
    isSound: (claim, substitute) =>
      findCounterexample(claim, armSymbols, (pose) => isSingular(substitute(pose)), 0, pieces.flat()) === null,
  });
  const [firstSlip] = slips;
  const makeVerdict = (reasons: readonly Message[], pose?: SymbolValues) =>
    verdictOf(share, [...(roundedClaim ? [message("verdict.rounded")] : []), ...reasons], {
      counterexample: pose,
      slips: firstSlip ? slips.map(({ slip }) => slip) : undefined,
    });
  // show the pose to which the first slip refers
  const counterexampleOfSlip = firstSlip?.claim && counterexamples[claims.indexOf(firstSlip.claim)];
  const regularPose = [counterexampleOfSlip, ...counterexamples].find(
    (result) => typeof result === "object" && result !== null,
  );
  if (regularPose)
    return makeVerdict(
      [message("verdict.unsound", { at: writeConfiguration(pickJointValues(regularPose, armSymbols)) })],
      regularPose,
    );
  const missedPose = (firstSlip?.piece && findUncoveredPose(claims, firstSlip.piece)) ?? uncoveredPoses[0];
  if (missedPose)
    return makeVerdict(
      [message("verdict.uncovered", { at: writeConfiguration(pickJointValues(missedPose, armSymbols)) })],
      missedPose,
    );
  if (roundedClaim) {
    const constants = roundedClaim.filter(({ joint, expression }) => joint !== null && isConstant(expression));
    const values = constants.map(({ joint, expression }) => [joint, evaluate(expression, {}).re]);
    return makeVerdict([], { ...pieces[0]?.[0], ...Object.fromEntries(values) });
  }
  // the number (from 1) of the first claim that holds in no pose
  const emptyClaimNumber = counterexamples.findIndex((result) => result === "nowhere" || result === "close") + 1;
  return makeVerdict([message("verdict.nowhere", { text: String(emptyClaimNumber) })]);
}

/** Return the names of the joints in a claim, separated by spaces. */
function nameJointsOfClaim(claim: Claim, { joints }: JointSpace): string {
  const jointsInClaim = new Set(claim.flatMap(({ joint, expression }) => [joint, ...findNames(expression)]));
  return joints.filter((joint) => jointsInClaim.has(joint)).join(" ");
}

/** Return the values of the joint variables in a pose, without those of other symbols. */
function pickJointValues(pose: SymbolValues, { joints }: JointSpace): SymbolValues {
  return Object.fromEntries(joints.map((joint) => [joint, pose[joint] as number]));
}

/** Return whether a claim holds in a pose, within tolerances. */
function holdsAt(claim: Claim, pose: SymbolValues, space: JointSpace): boolean {
  return claim.every((atom) => {
    const difference = makeVanishingExpression(atom);
    const moduloTurns = allowFullTurns(difference, space.angles);
    const isNumber = isConstant(atom.expression);
    if (atom.joint !== null && (isNumber || moduloTurns === difference)) {
      const { re, im } = evaluate(atom.expression, pose);
      const tolerance = isNumber ? VALUE_TOLERANCE : CONDITION_TOLERANCE;
      return (
        Math.abs(im) < tolerance && computeJointDistance(atom.joint, pose[atom.joint] as number, re, space) < tolerance
      );
    }
    const { re, im, size } = evaluate(moduloTurns, pose);
    if (!Number.isFinite(re)) return false;
    const slope = Math.hypot(...space.joints.map((joint) => computeSlope(moduloTurns, pose, joint)));
    return Math.hypot(re, im) <= Math.max(CONDITION_TOLERANCE * slope, 1e-11 * size);
  });
}

/** Return the distance between two values of a joint (rad or m), modulo full turns if it is an angle. */
function computeJointDistance(joint: string, a: number, b: number, { angles }: JointSpace): number {
  const difference = Math.abs(a - b);
  if (!angles.has(joint)) return difference;
  const remainder = difference % FULL_TURN;
  return Math.min(remainder, FULL_TURN - remainder);
}

/** Return the partial derivative of an expression by a joint variable, computed numerically. */
function computeSlope(expression: Node, pose: SymbolValues, joint: string): number {
  const valueAfter = (step: number): number => evaluate(expression, { ...pose, [joint]: pose[joint]! + step }).re;
  return (valueAfter(DIFFERENCE_STEP) - valueAfter(-DIFFERENCE_STEP)) / (2 * DIFFERENCE_STEP);
}

/** A regular pose on a claim, or what was found instead: see `findCounterexample`. */
type Counterexample = SymbolValues | "nowhere" | "close" | null;

/**
 * Return a regular pose on a claim; null if all poses found are singular. If no pose is found, return "close" if the
 * claim almost holds in some pose, else "nowhere". The poses found have the lengths of `knownPoses`, in turn.
 */
function findCounterexample(
  claim: Claim,
  space: JointSpace,
  isSingular: IsSingular,
  seed: number,
  knownPoses: readonly SymbolValues[],
): Counterexample {
  const random = makeRandomNumbers((seed + 1) * 0x9e3779b9);
  const lengthsFor = (k: number): SymbolValues => knownPoses[k % Math.max(knownPoses.length, 1)] ?? {};
  const expressions = listVanishingExpressions(claim, space);
  const constrainedJoints = space.joints.filter((joint) => findNames(...expressions).has(joint));
  let foundCount = 0;
  for (let start = 0; start < START_COUNT; start += 1) {
    const pose = moveOntoClaim(
      claim,
      expressions,
      constrainedJoints,
      sampleRandomPose(lengthsFor(start), space, random),
    );
    if (!pose || !holdsAt(claim, pose, space)) continue;
    foundCount += 1;
    if (!isSingular(pose)) return pose;
  }
  if (foundCount > 0) return null;
  const leastResidual = Math.min(
    ...Array.from({ length: RANDOM_POSE_COUNT }, (_, k) =>
      computeResidual(expressions, sampleRandomPose(lengthsFor(k), space, random)),
    ),
  );
  return leastResidual < CLOSE_RESIDUAL ? "close" : "nowhere";
}

/** Return the largest absolute value of the expressions in a pose, relative to their terms. */
function computeResidual(expressions: readonly Node[], pose: SymbolValues): number {
  const residuals = expressions.map((expression) => {
    const { re, im, size } = evaluate(expression, pose);
    return Math.abs(im) < CONDITION_TOLERANCE ? Math.abs(re) / Math.max(size, 1e-300) : Infinity;
  });
  return residuals.some(Number.isNaN) ? Infinity : Math.max(...residuals);
}

/** Return a claim with rounded values of joints replaced by exact ones: pi for 3.14 or 355/113. */
function replaceRoundedValues(claim: Claim, pieces: Pieces, space: JointSpace): Claim {
  const atoms = claim.map((atom) => {
    if (atom.joint === null || !isConstant(atom.expression)) return replaceRoundedSum(atom, pieces, space);
    const exact = findExactValue(atom.joint, atom.expression, pieces, space);
    return exact === null ? atom : { ...atom, expression: integer(exact) };
  });
  return atoms.every((atom, i) => atom === claim[i]) ? claim : atoms;
}

/** Return a condition on a sum of angles with its rounded value replaced by the exact one: theta1 + theta2 = 3.14. */
function replaceRoundedSum(atom: Atom, pieces: Pieces, { angles }: JointSpace): Atom {
  const difference = makeVanishingExpression(atom);
  if (allowFullTurns(difference, angles) === difference) return atom;
  const exact = pieces
    .map((piece) => piece.map((pose) => Math.asin(Math.sin(evaluate(difference, pose).re / 2)) * 2))
    .find(([firstDifference = NaN, ...otherDifferences]) => {
      const isEqual = otherDifferences.every((other) => Math.abs(other - firstDifference) < 1e-8); // poses have nine decimals
      return isEqual && Math.abs(firstDifference) < MAX_ROUNDING && Math.abs(firstDifference) > 1e-8;
    });
  return exact ? { joint: null, expression: node("-", difference, decimal(exact[0] as number)) } : atom;
}

/** Return the exact value of a joint on a piece if the condition states it rounded; else null. */
function findExactValue(joint: string, expression: Node, pieces: Pieces, space: JointSpace): number | null {
  const value = evaluate(expression, {}).re;
  const nearest = pieces
    .map((piece) => piece.map((pose) => pose[joint] as number))
    .filter((values) =>
      values.every((exact) => computeJointDistance(joint, exact, values[0] as number, space) < VALUE_TOLERANCE),
    )
    .map(([exact]) => ({ exact: exact as number, error: computeJointDistance(joint, value, exact as number, space) }))
    .filter(({ error }) => error < MAX_ROUNDING)
    .sort((a, b) => a.error - b.error)[0];
  if (!nearest) return null;
  // values found by a search are stored with nine decimals
  const isNumeric = nearest.exact !== 0 && Math.round(nearest.exact * 1e9) / 1e9 === nearest.exact;
  return nearest.error >= (isNumeric ? VALUE_TOLERANCE : TYPED_TOLERANCE * Math.max(1, Math.abs(nearest.exact)))
    ? nearest.exact
    : null;
}

/** Return a pose with these values and random ones of the joints: angles in a full turn, and 0.2 to 1.2 m. */
function sampleRandomPose(
  fixedValues: SymbolValues,
  { joints, angles }: JointSpace,
  random: () => number,
): SymbolValues {
  const values = joints.map((joint) => [joint, angles.has(joint) ? FULL_TURN * (random() - 0.5) : 0.2 + random()]);
  return { ...fixedValues, ...Object.fromEntries(values) };
}

/** Return the expressions that vanish if the conditions of a claim hold. */
const listVanishingExpressions = (claim: Claim, { angles }: JointSpace): Node[] =>
  claim.map((atom) => {
    const isValue = atom.joint !== null && isConstant(atom.expression);
    return isValue ? makeVanishingExpression(atom) : allowFullTurns(makeVanishingExpression(atom), angles);
  });

/** Return the expression that vanishes if a condition holds. */
const makeVanishingExpression = ({ joint, expression }: Atom): Node =>
  joint === null ? expression : node("-", name(joint), expression);

/** Return the pose moved by Gauss-Newton steps of least norm to where a claim holds; null if the steps fail. */
function moveOntoClaim(
  claim: Claim,
  expressions: readonly Node[],
  joints: readonly string[],
  start: SymbolValues,
): SymbolValues | null {
  let pose = start;
  for (const { joint, expression } of claim)
    if (joint !== null) pose = { ...pose, [joint]: evaluate(expression, pose).re };
  for (let step = 0; step < MAX_STEPS; step += 1) {
    const currentPose = pose;
    const errors = expressions.map((expression) => {
      const { re, size } = evaluate(expression, currentPose);
      return Number.isFinite(size) && Math.abs(re) <= ROUNDING_ERROR * size ? 0 : re;
    });
    if (errors.every((value) => value === 0)) break;
    const moves = solveLeastNorm(
      expressions.map((expression) => joints.map((joint) => computeSlope(expression, currentPose, joint))),
      errors,
    );
    if (!moves.every(Number.isFinite)) return null;
    const changes = joints.map((joint, i) => [joint, currentPose[joint]! - clamp(moves[i]!, -1, 1)]);
    pose = { ...currentPose, ...Object.fromEntries(changes) };
    if (Math.max(0, ...moves.map(Math.abs)) < 1e-12) break;
  }
  return pose;
}

/** Return the shortest x with A x = b. Rows are normalised because slopes vanish at a double zero, as of sin². */
function solveLeastNorm(a: readonly (readonly number[])[], b: readonly number[]): number[] {
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
