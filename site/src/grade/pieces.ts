// Conditions on the joints as a union of pieces, by the rules of ../../../exercises/formula/set_parser.py.

import { evaluate } from "../read/evaluate.js";
import { anyNode, integer, namesIn, type Node, node, ReadError, replaced } from "../read/tree.js";
import { VOCABULARY } from "../read/vocabulary.js";

/** A condition: `joint` has the value `zero`, or `zero` vanishes. */
export type Atom = { readonly joint: string | null; readonly zero: Node };

/** Conditions that hold together. */
export type Piece = readonly Atom[];

const WHOLE_NUMBERS = VOCABULARY.whole_numbers;
/** A value k*pi/6, or coarser, has all its values modulo whole turns for these k, from -6 to 6. */
const WHOLE = Array.from({ length: 13 }, (_, k) => (k < 6 ? node("neg", integer(6 - k)) : integer(k - 6)));
const MOST_PIECES = 500;
/** Most nodes in the cases of all whole numbers together, and what each case counts beside its own nodes. */
const MOST_CASES = 100_000;
const CASE = 10;

/** The pieces of an answer. Throws ReadError also where it would take too long to look at all of them. */
export function claimedPieces(tree: Node, joints: ReadonlySet<string>): Piece[] {
  if (nodesOfCases(tree) > MOST_CASES) throw new ReadError("read.many-cases");
  return pieces(tree, joints);
}

function nodesOfCases(tree: Node): number {
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
      const free = WHOLE_NUMBERS.filter((each) => namesIn(top as Node).has(each));
      count += (CASE + size) * WHOLE.length ** free.length;
    }
  }
  return count;
}

/** The pieces that a tree stands for. Throws ReadError. */
export function pieces(tree: Node, joints: ReadonlySet<string>): Piece[] {
  const [left, right] = tree.args;
  if (["or", "list", "set"].includes(tree.kind)) return alternatives(tree, joints);
  if (tree.kind === "and" && !tree.args.some((arg) => [...namesIn(arg)].some((each) => joints.has(each))))
    throw new ReadError("read.no-joint");
  if (tree.kind === "and") return atOnce(together(tree.args.map((arg) => pieces(arg, joints))));
  if (tree.kind === "dict") {
    return together(tree.args.map((pair) => assigned(pair.args[0] as Node, pair.args[1] as Node, joints)));
  }
  if (tree.kind === "in" && left && right) return assigned(left, right, joints);
  if (tree.kind === "eq" && left && right) return equation(left, right, joints);
  if (tree.kind === "name" && joints.has(tree.text)) {
    throw new ReadError("read.alone", { joint: tree.text });
  }
  return vanishing(tree);
}

function equation(left: Node, right: Node, joints: ReadonlySet<string>): Piece[] {
  if (right.kind === "list" || right.kind === "set") return assigned(left, right, joints);
  for (const [own, other] of [[left, right] as const, [right, left] as const]) {
    if (own.kind === "name" && joints.has(own.text) && !namesIn(other).has(own.text))
      return assigned(own, other, joints);
  }
  return vanishing(node("-", left, right));
}

/** Pieces that can hold. Throws ReadError where each gives one joint two values at once. */
function atOnce(union: Piece[]): Piece[] {
  const twice = union.map(givenTwice);
  const [joint] = twice;
  if (joint && twice.every((each) => each !== null)) throw new ReadError("read.two-values", { joint });
  return union;
}

/** The joint that a piece gives two values that are not the same. */
function givenTwice(piece: Piece): string | null {
  const values = new Map<string, string>();
  for (const { joint, zero } of piece) {
    const value = joint === null ? null : turns(zero);
    if (joint === null || value === null) continue;
    if ((values.get(joint) ?? value) !== value) return joint;
    values.set(joint, value);
  }
  return null;
}

/** The union of a list; a bare value belongs to the joint before it: theta3 = 0, pi, or (theta3, [0, pi]). */
function alternatives(tree: Node, joints: ReadonlySet<string>): Piece[] {
  const found: Piece[] = [];
  let joint: Node | null = null;
  for (const arg of tree.args) {
    const saysMore = [...namesIn(arg)].some((each) => joints.has(each)) || /^(eq|in|and|or|dict)$/.test(arg.kind);
    if (saysMore) {
      let last = arg;
      while (last.kind === "or") last = last.args.at(-1) as Node;
      const own = last.kind === "eq" || last.kind === "in" ? (last.args[0] as Node) : last;
      joint = own.kind === "name" && joints.has(own.text) ? own : null;
      const [, other] = tree.args;
      const isLabel = joint && arg.kind === "name" && tree.args.length === 2 && arg === tree.args[0];
      const goesOn = other !== undefined && [...namesIn(other)].some((each) => joints.has(each));
      const [first = "", second = ""] = joints;
      if (isLabel && joints.size === 2 && arg.text === first && !["list", "set"].includes(other?.kind ?? ""))
        throw new ReadError("read.pair", { first, second });
      if (!isLabel || goesOn) found.push(...pieces(arg, joints));
    } else if (joint) {
      found.push(...assigned(joint, arg, joints));
    } else {
      throw new ReadError("read.no-joint");
    }
  }
  return found;
}

/** The pieces of an intersection: every combination of one piece of each set. */
function together(sets: readonly (readonly Piece[])[]): Piece[] {
  const count = sets.reduce((product, each) => product * each.length, 1);
  if (count > MOST_PIECES) throw new ReadError("read.cases", { count, most: MOST_PIECES });
  return sets.reduce<Piece[]>((all, each) => all.flatMap((one) => each.map((other) => [...one, ...other])), [[]]);
}

function assigned(joint: Node, values: Node, joints: ReadonlySet<string>): Piece[] {
  const listed = listedIn(values);
  if (joint.kind !== "name" || !joints.has(joint.text)) {
    return listed.flatMap((value) => vanishing(node("-", joint, value)));
  }
  return listed.flatMap((value) => cases(value).map((zero) => [{ joint: joint.text, zero }]));
}

/** Each of the values: of [0, ±pi], three. */
function listedIn(values: Node): readonly Node[] {
  if (!["list", "set", "or"].includes(values.kind)) return [values];
  return values.args.flatMap((arg) => (arg.kind === "set" ? arg.args : [arg]));
}

const vanishing = (tree: Node): Piece[] => cases(bare(tree)).map((zero) => [{ joint: null, zero }]);

/** What vanishes where an expression does, X of sqrt(X) or of X^4: the search needs a slope, which these lack. */
function bare(tree: Node): Node {
  const [first, second] = tree.args;
  if (!first) return tree;
  const lessNothing = tree.kind === "-" && second && ["number", "decimal"].includes(second.kind) && second.value === 0;
  const rooted = tree.kind === "call" && ["sqrt", "abs"].includes(tree.text);
  const power = tree.kind === "^" && second && ["number", "decimal"].includes(second.kind) && second.value > 0;
  return lessNothing || power || tree.kind === "neg" || rooted ? bare(first) : tree;
}

/** The cases of a whole number k in an expression; values whole turns apart are one. */
function cases(tree: Node): Node[] {
  const free = WHOLE_NUMBERS.filter((each) => namesIn(tree).has(each));
  if (free.length === 0) return [tree];
  const all = free.reduce<Node[]>(
    (found, each) => found.flatMap((one) => WHOLE.map((k) => replaced(one, each, k))),
    [tree],
  );
  return [...new Map(all.map((one, index) => [turns(one) ?? `case ${index}`, one])).values()];
}

/** A rational multiple of pi as a text, whole turns left out; null for anything else. */
function turns(tree: Node): string | null {
  if (namesIn(tree).size > 0) return null;
  const { re, im } = evaluate(tree, {});
  const sixths = (re / Math.PI) * 720;
  if (im !== 0 || !(Math.abs(sixths - Math.round(sixths)) < 1e-9 * Math.max(1, Math.abs(sixths)))) return null;
  return String(((Math.round(sixths) % 1440) + 1440) % 1440);
}
