// Parse conditions on the joints as a union of claims, by the rules of ../../../exercises/formula/set_parser.py.

import { evaluate } from "../read/evaluate.js";
import { countNodes } from "../read/products.js";
import type { Node } from "../read/tree.js";
import { anyNode, call, decimal, hasNameOf, integer, isConstant, isListOrSet, findNames } from "../read/tree.js";
import { node, ParseError, replaceName } from "../read/tree.js";
import { VOCABULARY } from "../read/vocabulary.js";

/** A condition: `joint` has the value of `expression`; or, if `joint` is null, `expression` is zero. */
export type Atom = { readonly joint: string | null; readonly expression: Node };

/** Conditions that hold simultaneously: a part of the answer's set. */
export type Claim = readonly Atom[];

/** Whole numbers from -6 to 6: for a multiple of pi/6, these give all values modulo full turns. */
const WHOLE_NUMBER_VALUES = Array.from({ length: 13 }, (_, k) =>
  k < 6 ? node("neg", integer(6 - k)) : integer(k - 6),
);
/** Maximum number of claims of an answer. */
const MAX_CLAIMS = 500;
/** Maximum number of nodes in the cases for all whole numbers together, and the nodes that each case adds. */
const MAX_CASE_NODES = 100_000;
const NODES_PER_CASE = 10;

/** Return the claims of an answer. Throws ParseError, also if there would be too many cases. */
export function parseClaims(tree: Node, joints: ReadonlySet<string>): Claim[] {
  if (countCaseNodes(tree) > MAX_CASE_NODES) throw new ParseError("read.many-cases");
  return buildClaims(tree, joints);
}

/** Return the letters in a tree that stand for any whole number, such as k. */
const findWholeNumbers = (tree: Node): string[] =>
  VOCABULARY.whole_numbers.filter((letter) => findNames(tree).has(letter));

/** Return the number of nodes in the cases for all whole numbers together. */
function countCaseNodes(tree: Node): number {
  const isUnion = (kind: string) => ["list", "set", "or"].includes(kind);
  const isCombination = (kind: string) => isUnion(kind) || ["and", "dict", "pair", "in"].includes(kind);
  let count = 0;
  const stack = [tree];
  for (let top = stack.pop(); top; top = stack.pop()) {
    if (isCombination(top.kind) || top.args.some(({ kind }) => isUnion(kind))) {
      for (const arg of top.args) stack.push(arg);
    } else {
      const nodeCount = NODES_PER_CASE + countNodes(top, Infinity);
      count += nodeCount * WHOLE_NUMBER_VALUES.length ** findWholeNumbers(top).length;
    }
  }
  return count;
}

/** Return the claims that a tree describes. Throws ParseError. */
function buildClaims(tree: Node, joints: ReadonlySet<string>): Claim[] {
  const [left, right] = tree.args;
  if (["or", "list", "set"].includes(tree.kind)) return buildClaimsOfUnion(tree, joints);
  if (tree.kind === "and" && !tree.args.some((arg) => hasNameOf(arg, joints))) throw new ParseError("read.no-joint");
  if (tree.kind === "and") return refuseContradictions(intersect(tree.args.map((arg) => buildClaims(arg, joints))));
  if (tree.kind === "dict")
    return intersect(tree.args.map((pair) => buildClaimsOfValues(pair.args[0] as Node, pair.args[1] as Node, joints)));
  if (tree.kind === "in" && left && right) return buildClaimsOfValues(left, right, joints);
  if (tree.kind === "eq" && left && right) return buildClaimsOfEquation(left, right, joints);
  if (tree.kind === "name" && joints.has(tree.text)) throw new ParseError("read.alone", { joint: tree.text });
  return buildVanishingClaims(tree, joints);
}

/** Return the claims of left = right. If one side is a joint that the other side lacks, the other gives its values. */
function buildClaimsOfEquation(left: Node, right: Node, joints: ReadonlySet<string>): Claim[] {
  if (isListOrSet(right)) return buildClaimsOfValues(left, right, joints);
  for (const [side, other] of [[left, right] as const, [right, left] as const]) {
    if (side.kind === "name" && joints.has(side.text) && !findNames(other).has(side.text))
      return buildClaimsOfValues(side, other, joints);
  }
  return buildVanishingClaims(node("-", left, right), joints);
}

/** Return the union unchanged. Throws ParseError if each claim gives some joint two values. */
function refuseContradictions(union: Claim[]): Claim[] {
  const conflicts = union.map(findJointWithTwoValues);
  const [joint] = conflicts;
  if (joint && conflicts.every((conflict) => conflict !== null)) throw new ParseError("read.two-values", { joint });
  return union;
}

/** Return a joint to which a claim gives two different values; null if there is none. */
function findJointWithTwoValues(claim: Claim): string | null {
  const values = new Map<string, string>();
  for (const { joint, expression } of claim) {
    const value = joint === null ? null : writeModuloTurns(expression);
    if (joint === null || value === null) continue;
    if ((values.get(joint) ?? value) !== value) return joint;
    values.set(joint, value);
  }
  return null;
}

/** Return the claims of a list; a bare value belongs to the joint before it: theta3 = 0, pi, or (theta3, [0, pi]). */
function buildClaimsOfUnion(tree: Node, joints: ReadonlySet<string>): Claim[] {
  const union: Claim[] = [];
  let currentJoint: Node | null = null; // the joint, or sum of joints, to which bare values belong
  for (const arg of tree.args) {
    const isStatement = hasNameOf(arg, joints) || /^(eq|in|and|or|dict)$/.test(arg.kind);
    if (isStatement) {
      let lastStatement = arg; // B in "A or B"
      while (lastStatement.kind === "or") lastStatement = lastStatement.args.at(-1) as Node;
      const side =
        lastStatement.kind === "eq" || lastStatement.kind === "in" ? (lastStatement.args[0] as Node) : lastStatement;
      const isSumOfJoints =
        side !== lastStatement &&
        [...findNames(side)].every((symbol) => joints.has(symbol)) &&
        findCoefficients(side, joints) !== null;
      currentJoint = isSumOfJoints || (side.kind === "name" && joints.has(side.text)) ? side : null;
      const [, secondArg] = tree.args;
      const isLabel = currentJoint && arg.kind === "name" && tree.args.length === 2 && arg === tree.args[0];
      const hasJointLater = secondArg !== undefined && hasNameOf(secondArg, joints);
      const [firstJoint = "", secondJoint = ""] = joints;
      if (isLabel && joints.size === 2 && arg.text === firstJoint && !isListOrSet(secondArg))
        throw new ParseError("read.pair", { first: firstJoint, second: secondJoint });
      if (!isLabel || hasJointLater) union.push(...buildClaims(arg, joints));
    } else if (currentJoint) {
      union.push(...buildClaimsOfValues(currentJoint, arg, joints));
    } else {
      throw new ParseError("read.no-joint");
    }
  }
  return union;
}

/**
 * Return an expression that vanishes if a sum of angles vanishes modulo full turns: sin((theta1 + theta2)/2).
 *
 * Each angle may change by a full turn, so 2 theta1 = pi means pi/2 only. Other expressions are returned unchanged.
 */
export function allowFullTurns(expression: Node, angles: ReadonlySet<string>): Node {
  const magnitudes = [...(findCoefficients(expression, angles) ?? [])]
    .map(([, factor]) => Math.abs(factor))
    .filter((magnitude) => magnitude > 1e-9);
  if (magnitudes.length === 0) return expression;
  return call("sin", node("/", expression, decimal(2 * magnitudes.reduce(findCommonDivisor))));
}

/** Return the greatest common divisor of two positive numbers, up to rounding errors (Euclid's algorithm). */
const findCommonDivisor = (a: number, b: number): number =>
  b < 1e-6 ? a : findCommonDivisor(b, a - b * Math.floor(a / b + 1e-9));

/** Return the coefficient of each angle in a sum; null if an angle occurs in any other term, such as a product. */
function findCoefficients(tree: Node, angles: ReadonlySet<string>): ReadonlyMap<string, number> | null {
  const coefficients = new Map<string, number>();
  const pending: { readonly term: Node; readonly factor: number }[] = [{ term: tree, factor: 1 }];
  for (let product = pending.pop(); product; product = pending.pop()) {
    const { term, factor } = product;
    const [left, right] = term.args;
    if (term.kind === "name" && angles.has(term.text))
      coefficients.set(term.text, (coefficients.get(term.text) ?? 0) + factor);
    else if (!hasNameOf(term, angles)) continue;
    else if (term.kind === "neg" && left) pending.push({ term: left, factor: -factor });
    else if (term.kind === "+" || term.kind === "-")
      pending.push(
        { term: left as Node, factor },
        { term: right as Node, factor: term.kind === "-" ? -factor : factor },
      );
    else if (term.kind === "*" && left && isConstant(left))
      pending.push({ term: right as Node, factor: factor * evaluate(left, {}).re });
    else if ((term.kind === "*" || term.kind === "/") && left && right && isConstant(right)) {
      const value = evaluate(right, {}).re;
      pending.push({ term: left, factor: term.kind === "*" ? factor * value : factor / value });
    } else return null;
  }
  return [...coefficients.values()].every(Number.isFinite) ? coefficients : null;
}

/** Return the claims of the intersection of some sets: every combination of one claim from each set. */
function intersect(sets: readonly (readonly Claim[])[]): Claim[] {
  const count = sets.reduce((product, set) => product * set.length, 1);
  if (count > MAX_CLAIMS) throw new ParseError("read.cases", { count, limit: MAX_CLAIMS });
  return sets.reduce<Claim[]>(
    (claims, set) => claims.flatMap((claim) => set.map((atoms) => [...claim, ...atoms])),
    [[]],
  );
}

/** Return the claims that a joint, or another expression, has one of several values. */
function buildClaimsOfValues(joint: Node, values: Node, joints: ReadonlySet<string>): Claim[] {
  const valueNodes = listSingleValues(values);
  if (joint.kind !== "name" || !joints.has(joint.text)) {
    return valueNodes.flatMap((value) => buildVanishingClaims(node("-", joint, value), joints));
  }
  return valueNodes.flatMap((value) =>
    substituteWholeNumbers(value).map((expression) => [{ joint: joint.text, expression }]),
  );
}

/** Return the single values: 0, pi and -pi for [0, ±pi]. */
function listSingleValues(values: Node): readonly Node[] {
  if (!["list", "set", "or"].includes(values.kind)) return [values];
  return values.args.flatMap((arg) => (arg.kind === "set" ? arg.args : [arg]));
}

/** Return the claims that an expression is zero, one for each of its factors and for each whole number in it. */
function buildVanishingClaims(tree: Node, joints: ReadonlySet<string>): Claim[] {
  const zero = simplifyZero(tree);
  const { factors, divisors } = splitProduct(zero, joints);
  const isSplit = factors.length > 1 && vanishesWithEachFactor(factors, divisors, joints);
  return (isSplit ? factors : [zero]).flatMap((factor) =>
    substituteWholeNumbers(factor).map((expression) => [
      isSplit && factor.kind === "name" && joints.has(factor.text)
        ? { joint: factor.text, expression: integer(0) }
        : { joint: null, expression },
    ]),
  );
}

/** Functions that are quotients: the function in the numerator, "" for 1, and the function in the denominator. */
const QUOTIENTS: Readonly<Record<string, readonly [string, string]>> = {
  tan: ["sin", "cos"],
  cot: ["cos", "sin"],
  sec: ["", "cos"],
  csc: ["", "sin"],
};

type Product = { readonly factors: readonly Node[]; readonly divisors: readonly Node[] };

/** Return the different factors and divisors of a product that may vanish, without their powers. */
function splitProduct(tree: Node, joints: ReadonlySet<string>): Product {
  const [first, second] = tree.args;
  const exponent = tree.kind === "^" ? numberOf(second) || 0 : 0;
  if (first && (exponent !== 0 || tree.kind === "neg" || (tree.kind === "call" && tree.text === "abs"))) {
    const { factors, divisors } = splitProduct(first, joints);
    return exponent < 0 ? { factors: divisors, divisors: factors } : { factors, divisors };
  }
  if (first && second && (tree.kind === "*" || tree.kind === "/")) {
    const [left, right] = [splitProduct(first, joints), splitProduct(second, joints)];
    const [rightFactors, rightDivisors] =
      tree.kind === "*" ? [right.factors, right.divisors] : [right.divisors, right.factors];
    return {
      factors: omitRepeated([...left.factors, ...rightFactors]),
      divisors: omitRepeated([...left.divisors, ...rightDivisors]),
    };
  }
  if (isNonzeroConstant(tree, joints)) return { factors: [], divisors: [] };
  const [numerator, denominator] = (tree.kind === "call" && QUOTIENTS[tree.text]) || [];
  if (denominator === undefined) return { factors: [tree], divisors: [] };
  return { factors: numerator ? [call(numerator, ...tree.args)] : [], divisors: [call(denominator, ...tree.args)] };
}

/** Return whether a constant surely differs from zero, unlike 0, a1 - a2, cos(alpha1), and the whole number k. */
function isNonzeroConstant(tree: Node, joints: ReadonlySet<string>): boolean {
  if (isConstant(tree)) {
    const { re, im } = evaluate(tree, {});
    return Math.abs(im) < 1e-9 && Math.abs(re) > 1e-9;
  }
  const has = (...kinds: string[]) => anyNode(tree, ({ kind }) => kinds.includes(kind));
  const mayVanish = (part: Node) =>
    part.kind === "call" ? !["sqrt", "abs"].includes(part.text) : part.text === "I" || numberOf(part) === 0;
  const mayCancel = has("-") || (has("+") && has("neg"));
  return !mayCancel && !anyNode(tree, mayVanish) && !hasNameOf(tree, joints) && findWholeNumbers(tree).length === 0;
}

/** Return a text that is the same for equal trees only. */
const identify = ({ kind, text, args }: Node): string => `${kind} ${text}(${args.map(identify).join()})`;

const omitRepeated = (trees: readonly Node[]): Node[] => [
  ...new Map(trees.map((tree) => [identify(tree), tree])).values(),
];

/**
 * Return whether a quotient surely vanishes at almost all zeros of each factor, and only there.
 *
 * For example, tan(theta1)*cos(theta1), 0*sin(theta1) and (theta1 - theta1)*sin(theta2) do not.
 * A divisor must be a joint variable, or the sine or cosine of a sum of these, and not vanish wherever a factor does.
 */
const vanishesWithEachFactor = (
  factors: readonly Node[],
  divisors: readonly Node[],
  joints: ReadonlySet<string>,
): boolean =>
  factors.every(
    (factor) => hasNameOf(factor, joints) && isDefinedEverywhere(factor, joints) && isNonzeroSomewhere(factor),
  ) && divisors.every((divisor) => factors.every((factor) => isNonzeroAtZeros(divisor, factor, joints)));

/** Return whether an expression differs from zero at an arbitrary configuration, so it is not zero everywhere. */
function isNonzeroSomewhere(tree: Node): boolean {
  const names = [...findNames(tree)].sort();
  const values = Object.fromEntries(names.map((symbol, k) => [symbol, 0.618033988 * (k + 1)]));
  const { re, im, size } = evaluate(tree, values);
  return Math.hypot(re, im) > 1e-12 * size;
}

const isWave = (tree: Node): boolean => tree.kind === "call" && (tree.text === "sin" || tree.text === "cos");

/** Return whether a divisor surely differs from zero at almost all zeros of a factor. */
function isNonzeroAtZeros(divisor: Node, factor: Node, joints: ReadonlySet<string>): boolean {
  const angles = listSummedNames(isWave(divisor) ? divisor.args[0] : divisor);
  if (angles.length === 0 || !angles.every((name) => joints.has(name))) return false;
  if (isWave(factor) && divisor.args.map(identify).join() === factor.args.map(identify).join())
    return divisor.text !== factor.text; // a sine and a cosine of the same angle
  const otherAngles = isWave(factor) ? listSummedNames(factor.args[0]) : [];
  return (
    angles.some((name) => !hasNameOf(factor, new Set([name]))) || otherAngles.some((name) => !angles.includes(name))
  );
}

/** Return the names in a sum or difference of different names, such as theta1 + theta2; [] for anything else. */
function listSummedNames(tree: Node | undefined): string[] {
  const names: string[] = [];
  const isSum = (part: Node): boolean => {
    if (part.kind === "name") names.push(part.text);
    return ["name", "+", "-", "neg"].includes(part.kind) && part.args.every(isSum);
  };
  return tree && isSum(tree) && new Set(names).size === names.length ? names : [];
}

/** Return whether an expression surely has a value in all configurations, unlike tan(theta1) and 1/d2. */
function isDefinedEverywhere(tree: Node, joints: ReadonlySet<string>): boolean {
  const second = tree.args[1];
  const mayDivideByZero = tree.kind === "/" && second !== undefined && hasNameOf(second, joints);
  const isNumber = second !== undefined && ["number", "decimal"].includes(second.kind);
  const mayBeNegativePower = tree.kind === "^" && !(isNumber && second.value > 0);
  const isOtherFunction = tree.kind === "call" && !["sin", "cos", "abs"].includes(tree.text);
  if (mayDivideByZero || mayBeNegativePower || isOtherFunction) return false;
  return tree.args.every((arg) => isDefinedEverywhere(arg, joints));
}

/** Return the value of a number; NaN for anything else. */
const numberOf = (tree?: Node): number => (tree && ["number", "decimal"].includes(tree.kind) ? tree.value : NaN);

/** Return an expression with the same zeros: X for sqrt(X) or X^4. The search for zeros needs a nonzero slope there. */
function simplifyZero(tree: Node): Node {
  const [first, second] = tree.args;
  if (!first) return tree;
  if (second && tree.kind === "-" && numberOf(first) === 0) return simplifyZero(second); // the answer was 0 = X
  const number = numberOf(second);
  const subtractsZero = tree.kind === "-" && number === 0;
  const isRoot = tree.kind === "call" && ["sqrt", "abs"].includes(tree.text);
  const isPower = tree.kind === "^" && number > 0;
  return subtractsZero || isPower || tree.kind === "neg" || isRoot ? simplifyZero(first) : tree;
}

/** Return an expression for each whole number k in it; values that differ by full turns appear once. */
function substituteWholeNumbers(tree: Node): Node[] {
  const letters = findWholeNumbers(tree);
  if (letters.length === 0) return [tree];
  let expressions = [tree];
  for (const name of letters)
    expressions = expressions.flatMap((expression) => WHOLE_NUMBER_VALUES.map((k) => replaceName(expression, name, k)));
  return [
    ...new Map(
      expressions.map((expression, index) => [writeModuloTurns(expression) ?? `case ${index}`, expression]),
    ).values(),
  ];
}

/** Angles are compared as whole numbers of steps, quarters of a degree. */
const STEPS_PER_TURN = 4 * 360;

/** Return an angle that is a whole number of steps as a text, modulo full turns; null for other expressions. */
function writeModuloTurns(tree: Node): string | null {
  if (!isConstant(tree)) return null;
  const { re, im } = evaluate(tree, {});
  const steps = (re / Math.PI) * (STEPS_PER_TURN / 2);
  if (im !== 0 || !(Math.abs(steps - Math.round(steps)) < 1e-9 * Math.max(1, Math.abs(steps)))) return null;
  return String(((Math.round(steps) % STEPS_PER_TURN) + STEPS_PER_TURN) % STEPS_PER_TURN);
}
