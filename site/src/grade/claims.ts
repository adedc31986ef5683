// Conditions on the joints as a union of pieces, by the rules of ../../../exercises/formula/set_parser.py.

import { evaluate } from "../read/evaluate.js";
import { anyNode, call, decimal, integer, namesIn, type Node, node, ParseError, replaceName } from "../read/tree.js";
import { VOCABULARY } from "../read/vocabulary.js";

/** A condition: `joint` has the value `zero`; or, if `joint` is null, the expression `zero` vanishes. */
export type Atom = { readonly joint: string | null; readonly zero: Node };

/** Conditions that hold simultaneously. */
export type Piece = readonly Atom[];

const WHOLE_NUMBERS = VOCABULARY.whole_numbers;
/** Whole numbers from -6 to 6: for a multiple of pi/6, these give all values modulo full turns. */
const WHOLE = Array.from({ length: 13 }, (_, k) => (k < 6 ? node("neg", integer(6 - k)) : integer(k - 6)));
const MAX_PIECES = 500;
/** Limits: nodes in the cases of all whole numbers together, and nodes added for each case. */
const MAX_CASE_NODES = 100_000;
const NODES_PER_CASE = 10;

/** Return the pieces of an answer. Throws ParseError, also if there would be too many cases. */
export function parseClaims(tree: Node, joints: ReadonlySet<string>): Piece[] {
  if (countCaseNodes(tree) > MAX_CASE_NODES) throw new ParseError("read.many-cases");
  return piecesOf(tree, joints);
}

function countCaseNodes(tree: Node): number {
  const inner = (kind: string) => kind === "list" || kind === "set" || kind === "or";
  const divided = (kind: string) => inner(kind) || ["and", "dict", "pair", "in"].includes(kind);
  let count = 0;
  const stack = [tree];
  for (let top = stack.pop(); top; top = stack.pop()) {
    if (divided(top.kind) || top.args.some(({ kind }) => inner(kind))) {
      for (const arg of top.args) stack.push(arg);
    } else {
      let size = 0;
      anyNode(top, () => ((size += 1), false));
      const free = WHOLE_NUMBERS.filter((letter) => namesIn(top as Node).has(letter));
      count += (NODES_PER_CASE + size) * WHOLE.length ** free.length;
    }
  }
  return count;
}

/** Return the pieces that a tree describes. Throws ParseError. */
export function piecesOf(tree: Node, joints: ReadonlySet<string>): Piece[] {
  const [left, right] = tree.args;
  if (["or", "list", "set"].includes(tree.kind)) return piecesOfUnion(tree, joints);
  if (tree.kind === "and" && !tree.args.some((arg) => [...namesIn(arg)].some((symbol) => joints.has(symbol))))
    throw new ParseError("read.no-joint");
  if (tree.kind === "and") return refuseContradictions(intersect(tree.args.map((arg) => piecesOf(arg, joints))));
  if (tree.kind === "dict") {
    return intersect(tree.args.map((pair) => piecesOfValues(pair.args[0] as Node, pair.args[1] as Node, joints)));
  }
  if (tree.kind === "in" && left && right) return piecesOfValues(left, right, joints);
  if (tree.kind === "eq" && left && right) return piecesOfEquation(left, right, joints);
  if (tree.kind === "name" && joints.has(tree.text)) {
    throw new ParseError("read.alone", { joint: tree.text });
  }
  return vanishingPieces(tree);
}

function piecesOfEquation(left: Node, right: Node, joints: ReadonlySet<string>): Piece[] {
  if (right.kind === "list" || right.kind === "set") return piecesOfValues(left, right, joints);
  for (const [side, other] of [[left, right] as const, [right, left] as const]) {
    if (side.kind === "name" && joints.has(side.text) && !namesIn(other).has(side.text))
      return piecesOfValues(side, other, joints);
  }
  return vanishingPieces(node("-", left, right));
}

/** Return the union unchanged. Throws ParseError if each piece gives one joint two values. */
function refuseContradictions(union: Piece[]): Piece[] {
  const conflicts = union.map(jointWithTwoValues);
  const [joint] = conflicts;
  if (joint && conflicts.every((conflict) => conflict !== null)) throw new ParseError("read.two-values", { joint });
  return union;
}

/** Return a joint to which a piece gives two different values; null if there is none. */
function jointWithTwoValues(piece: Piece): string | null {
  const values = new Map<string, string>();
  for (const { joint, zero } of piece) {
    const value = joint === null ? null : textModuloTurns(zero);
    if (joint === null || value === null) continue;
    if ((values.get(joint) ?? value) !== value) return joint;
    values.set(joint, value);
  }
  return null;
}

/** Return the union of a list; a bare value belongs to the joint before it: theta3 = 0, pi, or (theta3, [0, pi]). */
function piecesOfUnion(tree: Node, joints: ReadonlySet<string>): Piece[] {
  const union: Piece[] = [];
  let joint: Node | null = null;
  for (const arg of tree.args) {
    const isStatement =
      [...namesIn(arg)].some((symbol) => joints.has(symbol)) || /^(eq|in|and|or|dict)$/.test(arg.kind);
    if (isStatement) {
      let last = arg;
      while (last.kind === "or") last = last.args.at(-1) as Node;
      const side = last.kind === "eq" || last.kind === "in" ? (last.args[0] as Node) : last;
      const isSum =
        side !== last && [...namesIn(side)].every((symbol) => joints.has(symbol)) && factorsOf(side, joints);
      joint = isSum || (side.kind === "name" && joints.has(side.text)) ? side : null;
      const [, other] = tree.args;
      const isLabel = joint && arg.kind === "name" && tree.args.length === 2 && arg === tree.args[0];
      const hasJointLater = other !== undefined && [...namesIn(other)].some((symbol) => joints.has(symbol));
      const [first = "", second = ""] = joints;
      if (isLabel && joints.size === 2 && arg.text === first && !["list", "set"].includes(other?.kind ?? ""))
        throw new ParseError("read.pair", { first, second });
      if (!isLabel || hasJointLater) union.push(...piecesOf(arg, joints));
    } else if (joint) {
      union.push(...piecesOfValues(joint, arg, joints));
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
export function vanishingModuloTurns(zero: Node, angles: ReadonlySet<string>): Node {
  const factors = [...(factorsOf(zero, angles) ?? [])]
    .map(([, factor]) => Math.abs(factor))
    .filter((size) => size > 1e-9);
  if (factors.length === 0) return zero;
  return call("sin", node("/", zero, decimal(2 * factors.reduce(commonDivisor))));
}

const commonDivisor = (a: number, b: number): number =>
  b < 1e-6 ? a : commonDivisor(b, a - b * Math.floor(a / b + 1e-9));

/** Return the factor of each angle in a sum; null if an angle is in another term than a multiple of it. */
function factorsOf(tree: Node, angles: ReadonlySet<string>): ReadonlyMap<string, number> | null {
  const factors = new Map<string, number>();
  const stack: (readonly [term: Node, factor: number])[] = [[tree, 1]];
  for (let top = stack.pop(); top; top = stack.pop()) {
    const [term, factor] = top;
    const [left, right] = term.args;
    if (term.kind === "name" && angles.has(term.text)) factors.set(term.text, (factors.get(term.text) ?? 0) + factor);
    else if (![...namesIn(term)].some((symbol) => angles.has(symbol))) continue;
    else if (term.kind === "neg" && left) stack.push([left, -factor]);
    else if (term.kind === "+" || term.kind === "-")
      stack.push([left as Node, factor], [right as Node, term.kind === "-" ? -factor : factor]);
    else if (term.kind === "*" && left && namesIn(left).size === 0)
      stack.push([right as Node, factor * evaluate(left, {}).re]);
    else if ((term.kind === "*" || term.kind === "/") && left && right && namesIn(right).size === 0) {
      const value = evaluate(right, {}).re;
      stack.push([left, term.kind === "*" ? factor * value : factor / value]);
    } else return null;
  }
  return [...factors.values()].every(Number.isFinite) ? factors : null;
}

/** Return the pieces of an intersection: every combination of one piece of each set. */
function intersect(sets: readonly (readonly Piece[])[]): Piece[] {
  const count = sets.reduce((product, set) => product * set.length, 1);
  if (count > MAX_PIECES) throw new ParseError("read.cases", { count, most: MAX_PIECES });
  return sets.reduce<Piece[]>((all, set) => all.flatMap((one) => set.map((other) => [...one, ...other])), [[]]);
}

function piecesOfValues(joint: Node, values: Node, joints: ReadonlySet<string>): Piece[] {
  const listed = valuesIn(values);
  if (joint.kind !== "name" || !joints.has(joint.text)) {
    return listed.flatMap((value) => vanishingPieces(node("-", joint, value)));
  }
  return listed.flatMap((value) => substituteWholeNumbers(value).map((zero) => [{ joint: joint.text, zero }]));
}

/** Return each of several values: three for [0, ±pi]. */
function valuesIn(values: Node): readonly Node[] {
  if (!["list", "set", "or"].includes(values.kind)) return [values];
  return values.args.flatMap((arg) => (arg.kind === "set" ? arg.args : [arg]));
}

const vanishingPieces = (tree: Node): Piece[] =>
  substituteWholeNumbers(simplifyZero(tree)).map((zero) => [{ joint: null, zero }]);

/** Return an expression with the same zeros and a slope there: X for sqrt(X) or X^4. The search needs a slope. */
function simplifyZero(tree: Node): Node {
  const [first, second] = tree.args;
  if (!first) return tree;
  const minusZero = tree.kind === "-" && second && ["number", "decimal"].includes(second.kind) && second.value === 0;
  const isRoot = tree.kind === "call" && ["sqrt", "abs"].includes(tree.text);
  const power = tree.kind === "^" && second && ["number", "decimal"].includes(second.kind) && second.value > 0;
  return minusZero || power || tree.kind === "neg" || isRoot ? simplifyZero(first) : tree;
}

/** Return an expression for each whole number k in it; values that differ by full turns appear once. */
function substituteWholeNumbers(tree: Node): Node[] {
  const free = WHOLE_NUMBERS.filter((letter) => namesIn(tree).has(letter));
  if (free.length === 0) return [tree];
  let expressions = [tree];
  for (const name of free)
    expressions = expressions.flatMap((expression) => WHOLE.map((k) => replaceName(expression, name, k)));
  return [
    ...new Map(
      expressions.map((expression, index) => [textModuloTurns(expression) ?? `case ${index}`, expression]),
    ).values(),
  ];
}

/** Return a rational multiple of pi as a text, modulo full turns; null for other expressions. */
function textModuloTurns(tree: Node): string | null {
  if (namesIn(tree).size > 0) return null;
  const { re, im } = evaluate(tree, {});
  const steps = (re / Math.PI) * 720;
  if (im !== 0 || !(Math.abs(steps - Math.round(steps)) < 1e-9 * Math.max(1, Math.abs(steps)))) return null;
  return String(((Math.round(steps) % 1440) + 1440) % 1440);
}
