// Find changes that undo a slip: with them, an entry has the expected value at the first configuration of a key.
//
// For each piece (subexpression) of an entry, we compute the value that would make the entry right, and then the
// changes that give the piece this value. slips.ts checks each changed entry at all configurations.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { decimal, integer, namesIn, type Node, node } from "../read/tree.js";
import { inDigits, type TextKey } from "../text/text.js";
import {
  anglesIn,
  withJointsFrom,
  changeEveryWave,
  isRelative,
  isWave,
  otherAngles,
  otherConstants,
  otherWave,
  withAngle,
} from "./angles.js";
import {
  type ValuedTree,
  withValue,
  type Library,
  libraryOf,
  type Terms,
  termsNear,
  termsOf,
  times,
  wavesOf,
} from "./terms.js";
import type { SymbolValues } from "./verdict.js";

/** Relative tolerance for equal values at one configuration. */
const NEAR = 1e-7;

/** At most this many terms are tried in pairs. */
const MAX_PAIRED_TERMS = 600;

/** The kinds of slips, in the order in which they are reported if several changes make an entry right. */
export const KINDS = [
  "slip.whole-sign",
  "slip.wave",
  "slip.all-waves",
  "slip.relative",
  "slip.sign",
  "slip.angle",
  "slip.symbol",
  "slip.bracket",
  "slip.term-extra",
  "slip.factor-extra",
  "slip.length-missing",
  "slip.lengths-missing",
  "slip.constant",
  "slip.number",
  "slip.zero",
  "slip.term-missing",
  "slip.factor-missing",
  "slip.terms-missing",
] as const satisfies readonly TextKey[];
export type Kind = (typeof KINDS)[number];

/** The entry with a slip undone; `what` is the missing part in symbols, if it is reported. */
export type Change = { readonly kind: Kind; readonly what?: string; readonly entry: Node };

/** A subexpression of an entry; `replace` returns the entry with another one in its place. */
interface Piece {
  readonly tree: Node;
  readonly parent: Node | null;
  readonly replace: (other: Node) => Node;
  /** Whether it is the numerator of a fraction, up to a sign. */
  readonly isNumerator: boolean;
}

/** What may complete or replace parts of an entry, with values at the first configuration of the key. */
export interface Repairs {
  readonly library: Library;
  readonly at: SymbolValues;
  readonly terms: Terms;
  /** The terms of which pairs are tried. */
  readonly fewTerms: Terms;
  readonly factors: readonly ValuedTree[];
}

export function repairsFor(
  entries: readonly Node[],
  at: SymbolValues,
  { symbols }: Pick<ValuesKey, "symbols">,
): Repairs {
  const library = libraryOf(symbols, entries);
  const factors = [...wavesOf(library, at), ...library.lengths.map((length) => withValue(length, at))];
  return { library, at, terms: termsOf(library, at), fewTerms: termsOf(library, at, MAX_PAIRED_TERMS), factors };
}

/** Yield an entry with one change that gives it the expected value, in every way; likelier changes first. */
export function* singleChanges(entry: Node, expected: number, repairs: Repairs): Generator<Change> {
  const { library, at } = repairs;
  const isRight = (other: Node) => near(evaluate(other, at).re, expected);
  const ifRight = function* (kind: Kind, other: Node): Generator<Change> {
    if (isRight(other)) yield { kind, entry: other };
  };
  yield* ifRight("slip.whole-sign", node("neg", entry));
  yield* ifRight("slip.all-waves", changeEveryWave(entry, otherWave));
  for (const angle of anglesIn([entry]))
    for (const other of otherAngles(angle, library.angles))
      yield* ifRight(
        kindOfAngle(angle, other),
        changeEveryWave(entry, (wave) => withAngle(wave, angle, other)),
      );
  for (const first of library.angles.filter(({ kind }) => kind === "name"))
    yield* ifRight(
      "slip.relative",
      changeEveryWave(entry, (wave) => withJointsFrom(first, wave, library.angles) ?? wave),
    );
  yield* withMissingLengths(entry, expected, repairs);
  for (const piece of piecesOf(entry)) {
    yield* withMissingBrackets(piece);
    const target = targetOf(piece, expected, at);
    if (target !== null) yield* changesOf(piece, target, repairs);
  }
}

const kindOfAngle = (typed: Node, expected: Node): Kind =>
  isRelative(typed, expected) ? "slip.relative" : "slip.angle";

/** Yield an entry, or a numerator in it, with two missing terms; neither may cancel one of its own terms. */
export function* withTwoTerms(entry: Node, expected: number, repairs: Repairs): Generator<Change> {
  const isSum = ({ tree, parent, isNumerator }: Piece) => parent === null || (isNumerator && tree.kind !== "/");
  for (const { tree, replace } of piecesOf(entry).filter(isSum)) {
    const target = replace(tree) === tree ? expected : targetOf({ tree, replace }, expected, repairs.at);
    if (target !== null)
      for (const { sum, what } of sumsOfThree(tree, target, repairs))
        yield { kind: "slip.terms-missing", what, entry: replace(sum) };
  }
}

/** Yield a sum with two added terms that give it the target value, and the text of these terms. */
function* sumsOfThree(tree: Node, target: number, { at, fewTerms }: Repairs) {
  const here = evaluate(tree, at).re;
  const ownTerms = multipliedOut(tree, at) ?? [];
  const cancelsTerm = (value: number) => ownTerms.some((term) => near(term, -value));
  for (const multiplier of ownTerms.length > 0 ? fewTerms.multipliers : [])
    for (const product of fewTerms.products) {
      const term = times(product, multiplier);
      for (const value of [term.value, -term.value].filter((candidate) => !cancelsTerm(candidate))) {
        const missing = target - here - value;
        for (const other of cancelsTerm(missing) ? [] : termsNear(fewTerms, missing, NEAR))
          yield {
            sum: withTerm(withTerm(tree, term, value), other, missing),
            what: termsText([term.tree, other.tree]),
          };
      }
    }
}

/** At most this many terms of a multiplied-out entry are considered. */
const MAX_MULTIPLIED_TERMS = 64;

/** Return the values of an entry's terms when it is multiplied out; null if there are too many. */
function multipliedOut(tree: Node, at: SymbolValues): number[] | null {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return multipliedOut(left, at)?.map((value) => -value) ?? null;
  if (!left || !right || !["+", "-", "*"].includes(tree.kind)) return [evaluate(tree, at).re];
  const [some, others] = [multipliedOut(left, at), multipliedOut(right, at)];
  if (!some || !others) return null;
  const terms =
    tree.kind === "*"
      ? some.flatMap((value) => others.map((other) => value * other))
      : [...some, ...others.map((other) => (tree.kind === "-" ? -other : other))];
  return terms.length > MAX_MULTIPLIED_TERMS ? null : terms;
}

/** Return the text that names a term: its lengths and rates, or else its angles, with θ2 for theta2. */
function termText(tree: Node): string {
  const factors = new Set<string>();
  const angles = new Set<string>();
  const visit = (part: Node): void => {
    if (isWave(part)) return namesIn(part).forEach((joint) => angles.add(joint.replace("theta", "θ")));
    if (part.kind === "decimal") factors.add(inDigits(part.value));
    if (part.kind === "name") factors.add(part.text);
    part.args.forEach(visit);
  };
  visit(tree);
  return factors.size > 0 ? [...factors].sort().join("·") : [...angles].sort().join(", ");
}

const termsText = (trees: readonly Node[]): string => [...new Set(trees.map(termText))].sort().join(", ");

/** Return the value that a piece needs for the entry to be right at a configuration; null if there is none. */
function targetOf(
  { tree, replace }: Pick<Piece, "tree" | "replace">,
  expected: number,
  at: SymbolValues,
): number | null {
  // If the piece occurs once, the entry is (p x + q) / (r x + s) in its value x; such functions keep cross-ratios.
  const here = evaluate(tree, at).re;
  const step = 0.37 * Math.abs(here) + 0.05;
  const valueWith = (value: number) => evaluate(replace(decimal(value)), at).re;
  const [a, b, c] = [valueWith(here), valueWith(here + step), valueWith(here - step)];
  const ratio = ((expected - a) * (b - c)) / ((expected - c) * (b - a)); // cross-ratio of x, here and here ± step
  const change = ((ratio / 2) * step) / (1 - ratio / 2);
  return Number.isFinite(change) ? here + change : null;
}

/** Yield expressions that may be correct instead of a piece, with the kind of slip and the missing part. */
function* replacementsFor({ tree, parent }: Piece, { library, factors }: Repairs): Generator<[Kind, Node, string?]> {
  yield [parent === null ? "slip.whole-sign" : "slip.sign", node("neg", tree)];
  if (isWave(tree)) {
    const [angle] = tree.args as [Node];
    yield ["slip.wave", otherWave(tree)];
    for (const other of otherAngles(angle, library.angles))
      yield [kindOfAngle(angle, other), { ...tree, args: [other] }];
  }
  if (tree.kind === "name")
    for (const other of [...library.lengths, ...library.multipliers])
      if (other.kind === "name" && stem(other.text) === stem(tree.text)) yield ["slip.symbol", other];
  if (tree.kind === "*") yield ["slip.factor-extra", tree.args[1] as Node];
  if (tree.kind === "*" || tree.kind === "/") yield ["slip.factor-extra", tree.args[0] as Node];
  for (const factor of [2, 0.5]) yield ["slip.number", node("*", decimal(factor), tree)];
  for (const { tree: factor } of factors) {
    const kind = factor.kind === "call" ? "slip.factor-missing" : "slip.length-missing";
    for (const sign of ["*", "/"] as const) yield [kind, node(sign, tree, factor), termText(factor)];
  }
}

/** Yield the changes of a piece that give it the target value. */
function* changesOf(piece: Piece, target: number, repairs: Repairs): Generator<Change> {
  const { tree, parent, replace } = piece;
  const { at } = repairs;
  const here = evaluate(tree, at).re;
  const changed = (kind: Kind, other: Node, what = ""): Change => ({ kind, what, entry: replace(other) });
  for (const [kind, other, what] of replacementsFor(piece, repairs))
    if (near(target, evaluate(other, at).re)) yield changed(kind, other, what);
  if (isWave(tree))
    for (const other of otherConstants(tree, evaluate(tree.args[0] as Node, at).re, target))
      yield changed("slip.angle", { ...tree, args: [other] });
  if (tree.kind === "decimal") yield changed("slip.constant", decimal(Number(target.toPrecision(6))));
  const isTerm = parent?.kind === "+" || parent?.kind === "-";
  if (isTerm && Math.abs(target) <= NEAR * Math.abs(here)) yield changed("slip.term-extra", integer(0));
  const lacking = target - here;
  // a term that would cancel an existing one is not missing
  const cancelsTerm = () => multipliedOut(tree, at)?.some((term) => near(term, -lacking)) ?? true;
  if (Math.abs(lacking) > NEAR * Math.abs(here) && !cancelsTerm())
    for (const term of termsNear(repairs.terms, lacking, NEAR))
      yield changed("slip.term-missing", withTerm(tree, term, lacking), termText(term.tree));
}

/** Return a sum with one more term, with the sign that gives the term this value. */
const withTerm = (sum: Node, term: ValuedTree, value: number): Node =>
  node(value * term.value > 0 ? "+" : "-", sum, term.tree);

/** Yield a*(b + c) for a*b + c: the brackets are missing. */
function* withMissingBrackets({ tree, replace }: Piece): Generator<Change> {
  const [left, right] = tree.args;
  if ((tree.kind !== "+" && tree.kind !== "-") || left?.kind !== "*") return;
  const [factor, inner] = left.args as [Node, Node];
  yield { kind: "slip.bracket", entry: replace(node("*", factor, node(tree.kind, inner, right as Node))) };
}

/** At most this many ways in which lengths may be missing are tried. */
const MAX_WAYS = 3000;

/** Yield the entry with two or more missing lengths: one or two in each of its terms. */
function* withMissingLengths(entry: Node, expected: number, { library, at }: Repairs): Generator<Change> {
  const terms = summandsOf(entry).map(({ tree, sign }) => ({ tree, sign, value: evaluate(tree, at).re }));
  const lengths = library.lengths.map((length) => withValue(length, at));
  const pairs = lengths.flatMap((a, i) =>
    lengths.slice(i).map((b) => ({ count: 2, value: a.value * b.value, tree: node("*", a.tree, b.tree) })),
  );
  const factors = [{ count: 0, value: 1, tree: null }, ...lengths.map((a) => ({ count: 1, ...a })), ...pairs];
  if (factors.length ** terms.length > MAX_WAYS) return;
  const ways = function* (k: number, left: number, chosen: typeof factors): Generator<typeof factors> {
    const term = terms[k];
    if (!term) {
      const missing = chosen.reduce((sum, { count }) => sum + count, 0);
      if (missing > 1 && Math.abs(left) <= NEAR * Math.abs(expected)) yield chosen;
      return;
    }
    for (const factor of factors) yield* ways(k + 1, left - term.sign * term.value * factor.value, [...chosen, factor]);
  };
  for (const way of ways(0, expected, [])) {
    const fixed = terms.map(({ tree, sign }, k) => {
      const factor = way[k]!.tree;
      const product = factor ? node("*", factor, tree) : tree;
      return sign < 0 ? node("neg", product) : product;
    });
    yield { kind: "slip.lengths-missing", entry: fixed.reduce((sum, term) => node("+", sum, term)) };
  }
}

/** Return the terms of a sum with their signs. */
function summandsOf(tree: Node, sign = 1): { tree: Node; sign: number }[] {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return summandsOf(left, -sign);
  if ((tree.kind === "+" || tree.kind === "-") && left && right)
    return [...summandsOf(left, sign), ...summandsOf(right, tree.kind === "-" ? -sign : sign)];
  return [{ tree, sign }];
}

/** Return all pieces of an entry except those in angles and exponents, which are neither terms nor factors. */
function piecesOf(entry: Node): Piece[] {
  const pieces: Piece[] = [];
  const visit = (piece: Piece): void => {
    const { tree, replace } = piece;
    pieces.push(piece);
    if (tree.kind === "call" && tree.text !== "sqrt") return;
    const inner = tree.kind === "^" ? tree.args.slice(0, 1) : tree.args;
    inner.forEach((arg, k) =>
      visit({
        tree: arg,
        parent: tree,
        replace: (other) => replace({ ...tree, args: tree.args.with(k, other) }),
        isNumerator: (tree.kind === "/" && k === 0) || (piece.isNumerator && tree.kind === "neg"),
      }),
    );
  };
  visit({ tree: entry, parent: null, replace: (other) => other, isNumerator: false });
  return pieces;
}

const stem = (text: string): string => (/^[vwfm][xyz]$/.test(text) ? (text[0] as string) : text.replace(/\d+$/, ""));

const near = (a: number, b: number): boolean => Math.abs(a - b) <= NEAR * Math.max(Math.abs(a), Math.abs(b));
