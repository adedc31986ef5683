// Changes of an entry by which it becomes worth what is expected at the first configuration of a key: slips undone.
//
// For each piece of an entry, we find the value that would make the entry right, and then the changes that give the
// piece that value. slips.ts checks each changed entry at all configurations.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { decimal, integer, namesIn, type Node, node } from "../read/tree.js";
import { inDigits, type TextKey } from "../text/text.js";
import {
  anglesIn,
  countedFrom,
  everyWave,
  isRelative,
  isWave,
  otherAngles,
  otherConstants,
  otherWave,
  withAngle,
} from "./angles.js";
import { type Known, known, type Library, libraryOf, type Terms, termsNear, termsOf, times, waves } from "./library.js";
import type { At } from "./verdict.js";

/** Share by which a value at one configuration may differ from what it is taken for. */
const NEAR = 1e-7;

/** So many terms are tried in pairs. */
const MOST_PAIRED = 600;

/** The kinds of slips, those first that are told where several changes make an entry right. */
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

/** The entry with a slip undone; `what` is what was missing, in letters and digits, where that is said. */
export type Change = { readonly kind: Kind; readonly what?: string; readonly entry: Node };

/** A piece of an entry: the entry with something else in its place. */
interface Piece {
  readonly tree: Node;
  readonly parent: Node | null;
  readonly put: (other: Node) => Node;
  /** Whether it is divided by something, but for a sign. */
  readonly divided: boolean;
}

/** What an entry may be fixed with, at the first configuration. */
export interface Means {
  readonly library: Library;
  readonly at: At;
  readonly terms: Terms;
  /** Those of which pairs are tried. */
  readonly fewTerms: Terms;
  readonly factors: readonly Known[];
}

export function meansOf(entries: readonly Node[], at: At, { symbols }: Pick<ValuesKey, "symbols">): Means {
  const library = libraryOf(symbols, entries);
  const factors = [...waves(library, at), ...library.lengths.map((each) => known(each, at))];
  return { library, at, terms: termsOf(library, at), fewTerms: termsOf(library, at, MOST_PAIRED), factors };
}

/** An entry with one thing changed, in every way in which it is worth what is expected; the likelier ways first. */
export function* changes(entry: Node, due: number, means: Means): Generator<Change> {
  const { library, at } = means;
  const isDue = (other: Node) => near(evaluate(other, at).re, due);
  const kept = function* (kind: Kind, other: Node): Generator<Change> {
    if (isDue(other)) yield { kind, entry: other };
  };
  yield* kept("slip.whole-sign", node("neg", entry));
  yield* kept("slip.all-waves", everyWave(entry, otherWave));
  for (const angle of anglesIn([entry]))
    for (const other of otherAngles(angle, library.angles))
      yield* kept(
        kindOfAngle(angle, other),
        everyWave(entry, (wave) => withAngle(wave, angle, other)),
      );
  for (const first of library.angles.filter(({ kind }) => kind === "name"))
    yield* kept(
      "slip.relative",
      everyWave(entry, (wave) => countedFrom(first, wave, library.angles) ?? wave),
    );
  yield* lengthened(entry, due, means);
  for (const piece of piecesOf(entry)) {
    yield* bracketed(piece);
    const wanted = wantedOf(piece, due, at);
    if (wanted !== null) yield* changesOf(piece, wanted, means);
  }
}

const kindOfAngle = (typed: Node, due: Node): Kind => (isRelative(typed, due) ? "slip.relative" : "slip.angle");

/** An entry, or a numerator in it, with two missing terms; neither cancels one of its own terms. */
export function* withTwoTerms(entry: Node, due: number, means: Means): Generator<Change> {
  const isSum = ({ tree, parent, divided }: Piece) => parent === null || (divided && tree.kind !== "/");
  for (const { tree, put } of piecesOf(entry).filter(isSum)) {
    const wanted = put(tree) === tree ? due : wantedOf({ tree, put }, due, means.at);
    if (wanted !== null)
      for (const { sum, what } of sumsOfThree(tree, wanted, means))
        yield { kind: "slip.terms-missing", what, entry: put(sum) };
  }
}

function* sumsOfThree(tree: Node, wanted: number, { at, fewTerms }: Means) {
  const here = evaluate(tree, at).re;
  const mine = multipliedOut(tree, at) ?? [];
  const isTaken = (value: number) => mine.some((each) => near(each, -value));
  for (const multiplier of mine.length > 0 ? fewTerms.multipliers : [])
    for (const product of fewTerms.products) {
      const one = times(product, multiplier);
      for (const value of [one.value, -one.value].filter((each) => !isTaken(each))) {
        const rest = wanted - here - value;
        for (const other of isTaken(rest) ? [] : termsNear(fewTerms, rest, NEAR))
          yield { sum: withTerm(withTerm(tree, one, value), other, rest), what: termsText([one.tree, other.tree]) };
      }
    }
}

/** So many terms an entry may have that is multiplied out. */
const MOST_MULTIPLIED = 64;

/** What the terms of an entry are worth when it is multiplied out; null where there are too many. */
function multipliedOut(tree: Node, at: At): number[] | null {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return multipliedOut(left, at)?.map((each) => -each) ?? null;
  if (!left || !right || !["+", "-", "*"].includes(tree.kind)) return [evaluate(tree, at).re];
  const [some, others] = [multipliedOut(left, at), multipliedOut(right, at)];
  if (!some || !others) return null;
  const all =
    tree.kind === "*"
      ? some.flatMap((each) => others.map((other) => each * other))
      : [...some, ...others.map((other) => (tree.kind === "-" ? -other : other))];
  return all.length > MOST_MULTIPLIED ? null : all;
}

/** By what a term can be told: the lengths and rates in it, else its angles; θ2 for theta2. */
function termText(tree: Node): string {
  const factors = new Set<string>();
  const angles = new Set<string>();
  const visit = (each: Node): void => {
    if (isWave(each)) return namesIn(each).forEach((joint) => angles.add(joint.replace("theta", "θ")));
    if (each.kind === "decimal") factors.add(inDigits(each.value));
    if (each.kind === "name") factors.add(each.text);
    each.args.forEach(visit);
  };
  visit(tree);
  return factors.size > 0 ? [...factors].sort().join("·") : [...angles].sort().join(", ");
}

const termsText = (trees: readonly Node[]): string => [...new Set(trees.map(termText))].sort().join(", ");

/** What a piece has to be worth for the entry to be right at a configuration; null where that is no number. */
function wantedOf({ tree, put }: Pick<Piece, "tree" | "put">, due: number, at: At): number | null {
  // where a piece stands once, the entry is (p x + q) / (r x + s), which keeps cross-ratios
  const here = evaluate(tree, at).re;
  const step = 0.37 * Math.abs(here) + 0.05;
  const worth = (value: number) => evaluate(put(decimal(value)), at).re;
  const [a, b, c] = [worth(here), worth(here + step), worth(here - step)];
  const ratio = ((due - a) * (b - c)) / ((due - c) * (b - a)); // of x - here over x - (here - step), halved
  const moved = ((ratio / 2) * step) / (1 - ratio / 2);
  return Number.isFinite(moved) ? here + moved : null;
}

/** What may be due in place of a piece, where it is worth what is wanted. */
function* othersFor({ tree, parent }: Piece, { library, factors }: Means): Generator<[Kind, Node, string?]> {
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

function* changesOf(piece: Piece, wanted: number, means: Means): Generator<Change> {
  const { tree, parent, put } = piece;
  const { at } = means;
  const here = evaluate(tree, at).re;
  const changed = (kind: Kind, other: Node, what = ""): Change => ({ kind, what, entry: put(other) });
  for (const [kind, other, what] of othersFor(piece, means))
    if (near(wanted, evaluate(other, at).re)) yield changed(kind, other, what);
  if (isWave(tree))
    for (const other of otherConstants(tree, evaluate(tree.args[0] as Node, at).re, wanted))
      yield changed("slip.angle", { ...tree, args: [other] });
  if (tree.kind === "decimal") yield changed("slip.constant", decimal(Number(wanted.toPrecision(6))));
  const isTerm = parent?.kind === "+" || parent?.kind === "-";
  if (isTerm && Math.abs(wanted) <= NEAR * Math.abs(here)) yield changed("slip.term-extra", integer(0));
  const lacking = wanted - here;
  // what a term would take away again is no term that is missing
  const takesAway = () => multipliedOut(tree, at)?.some((each) => near(each, -lacking)) ?? true;
  if (Math.abs(lacking) > NEAR * Math.abs(here) && !takesAway())
    for (const term of termsNear(means.terms, lacking, NEAR))
      yield changed("slip.term-missing", withTerm(tree, term, lacking), termText(term.tree));
}

/** A sum with a term more, of the sign that it takes to be worth `value`. */
const withTerm = (sum: Node, term: Known, value: number): Node =>
  node(value * term.value > 0 ? "+" : "-", sum, term.tree);

/** a*(b + c) for a*b + c: the bracket is missing. */
function* bracketed({ tree, put }: Piece): Generator<Change> {
  const [left, right] = tree.args;
  if ((tree.kind !== "+" && tree.kind !== "-") || left?.kind !== "*") return;
  const [factor, inner] = left.args as [Node, Node];
  yield { kind: "slip.bracket", entry: put(node("*", factor, node(tree.kind, inner, right as Node))) };
}

/** So many ways are tried in which lengths may have been left out. */
const MOST_WAYS = 3000;

/** The entry with two lengths or more that were left out: one or two in each of its terms. */
function* lengthened(entry: Node, due: number, { library, at }: Means): Generator<Change> {
  const terms = summandsOf(entry).map(({ tree, sign }) => ({ tree, sign, value: evaluate(tree, at).re }));
  const lengths = library.lengths.map((each) => known(each, at));
  const pairs = lengths.flatMap((a, i) =>
    lengths.slice(i).map((b) => ({ count: 2, value: a.value * b.value, tree: node("*", a.tree, b.tree) })),
  );
  const factors = [{ count: 0, value: 1, tree: null }, ...lengths.map((a) => ({ count: 1, ...a })), ...pairs];
  if (factors.length ** terms.length > MOST_WAYS) return;
  const ways = function* (k: number, left: number, chosen: typeof factors): Generator<typeof factors> {
    const term = terms[k];
    if (!term) {
      const missing = chosen.reduce((sum, { count }) => sum + count, 0);
      if (missing > 1 && Math.abs(left) <= NEAR * Math.abs(due)) yield chosen;
      return;
    }
    for (const factor of factors) yield* ways(k + 1, left - term.sign * term.value * factor.value, [...chosen, factor]);
  };
  for (const way of ways(0, due, [])) {
    const mended = terms.map(({ tree, sign }, k) => {
      const factor = way[k]!.tree;
      const whole = factor ? node("*", factor, tree) : tree;
      return sign < 0 ? node("neg", whole) : whole;
    });
    yield { kind: "slip.lengths-missing", entry: mended.reduce((sum, each) => node("+", sum, each)) };
  }
}

/** The terms of a sum with their signs. */
function summandsOf(tree: Node, sign = 1): { tree: Node; sign: number }[] {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return summandsOf(left, -sign);
  if ((tree.kind === "+" || tree.kind === "-") && left && right)
    return [...summandsOf(left, sign), ...summandsOf(right, tree.kind === "-" ? -sign : sign)];
  return [{ tree, sign }];
}

// --- pieces ---

/** All pieces of an entry but those in angles and exponents, which are no terms and no factors. */
function piecesOf(entry: Node): Piece[] {
  const found: Piece[] = [];
  const visit = (piece: Piece): void => {
    const { tree, put } = piece;
    found.push(piece);
    if (tree.kind === "call" && tree.text !== "sqrt") return;
    const inner = tree.kind === "^" ? tree.args.slice(0, 1) : tree.args;
    inner.forEach((arg, k) =>
      visit({
        tree: arg,
        parent: tree,
        put: (other) => put({ ...tree, args: tree.args.with(k, other) }),
        divided: (tree.kind === "/" && k === 0) || (piece.divided && tree.kind === "neg"),
      }),
    );
  };
  visit({ tree: entry, parent: null, put: (other) => other, divided: false });
  return found;
}

const stem = (text: string): string => (/^[vwfm][xyz]$/.test(text) ? (text[0] as string) : text.replace(/\d+$/, ""));

const near = (a: number, b: number): boolean => Math.abs(a - b) <= NEAR * Math.max(Math.abs(a), Math.abs(b));
