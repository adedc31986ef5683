// Find changes that undo a slip, so that an entry has the expected value at the first configuration of a key.
//
// For each subexpression of an entry, we compute the value that would make the entry right, and then the changes that
// give the subexpression this value. slips.ts checks each changed entry at all configurations.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { decimal, integer, findNames, type Node, node, type SymbolValues } from "../read/tree.js";
import { formatNumber, type TextKey, withGreek } from "../text/text.js";
import {
  findAngles,
  addJointsFrom,
  changeEveryWave,
  isRelative,
  isWave,
  listOtherAngles,
  findAnglesWithValue,
  exchangeWave,
  replaceAngle,
} from "./angles.js";
import type { ValuedTree, Library, Terms } from "./terms.js";
import { evaluateTree, buildLibrary, findTermsNear, buildTerms, multiplyTerms, listWaves } from "./terms.js";

/** Tolerance for equal values at one configuration, relative to the larger value. */
const RELATIVE_TOLERANCE = 1e-7;

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

/** The entry with a slip undone; `what` names the missing part, as in "a1·qd2", for kinds of slips that report it. */
export type Change = { readonly kind: Kind; readonly what?: string; readonly entry: Node };

/** A subexpression of an entry; `replace` returns the entry with another subexpression in its place. */
interface Subexpression {
  readonly tree: Node;
  readonly parent: Node | null;
  readonly replace: (other: Node) => Node;
  /** Whether the subexpression is the numerator of a fraction, up to a sign. */
  readonly isNumerator: boolean;
}

/** Expressions that may complete or replace parts of an entry, with their values at a configuration. */
export interface Repairs {
  readonly library: Library;
  readonly configuration: SymbolValues;
  /** Terms that may be missing in a sum. */
  readonly terms: Terms;
  /** The terms that are also tried in pairs. */
  readonly fewTerms: Terms;
  /** Lengths, sines and cosines that may be missing in a product. */
  readonly factors: readonly ValuedTree[];
}

export function buildRepairs(
  entries: readonly Node[],
  configuration: SymbolValues,
  { symbols }: Pick<ValuesKey, "symbols">,
): Repairs {
  const library = buildLibrary(symbols, entries);
  const factors = [
    ...listWaves(library, configuration),
    ...library.lengths.map((length) => evaluateTree(length, configuration)),
  ];
  return {
    library,
    configuration,
    terms: buildTerms(library, configuration),
    fewTerms: buildTerms(library, configuration, MAX_PAIRED_TERMS),
    factors,
  };
}

/** Yield an entry with one change that gives it the expected value, in every way; likelier changes first. */
export function* findSingleChanges(entry: Node, expected: number, repairs: Repairs): Generator<Change> {
  const { library, configuration } = repairs;
  const isRight = (changedEntry: Node) => isNear(evaluate(changedEntry, configuration).re, expected);
  const yieldIfRight = function* (kind: Kind, changedEntry: Node): Generator<Change> {
    if (isRight(changedEntry)) yield { kind, entry: changedEntry };
  };
  yield* yieldIfRight("slip.whole-sign", node("neg", entry));
  yield* yieldIfRight("slip.all-waves", changeEveryWave(entry, exchangeWave));
  for (const angle of findAngles([entry]))
    for (const otherAngle of listOtherAngles(angle, library.angles))
      yield* yieldIfRight(
        classifyAngleSlip(angle, otherAngle),
        changeEveryWave(entry, (wave) => replaceAngle(wave, angle, otherAngle)),
      );
  for (const first of library.angles.filter(({ kind }) => kind === "name"))
    yield* yieldIfRight(
      "slip.relative",
      changeEveryWave(entry, (wave) => addJointsFrom(first, wave, library.angles) ?? wave),
    );
  yield* addMissingLengths(entry, expected, repairs);
  for (const subexpression of listSubexpressions(entry)) {
    yield* addMissingBrackets(subexpression);
    const target = computeTarget(subexpression, expected, configuration);
    if (target !== null) yield* findChanges(subexpression, target, repairs);
  }
}

const classifyAngleSlip = (typed: Node, expected: Node): Kind =>
  isRelative(typed, expected) ? "slip.relative" : "slip.angle";

/** Yield an entry in which it or a numerator has two more terms; neither term may cancel one of the existing terms. */
export function* addTwoTerms(entry: Node, expected: number, repairs: Repairs): Generator<Change> {
  const isSum = ({ tree, parent, isNumerator }: Subexpression) => parent === null || (isNumerator && tree.kind !== "/");
  for (const { tree, replace } of listSubexpressions(entry).filter(isSum)) {
    const target =
      replace(tree) === tree ? expected : computeTarget({ tree, replace }, expected, repairs.configuration);
    if (target !== null)
      for (const { sum, what } of findSumsOfThree(tree, target, repairs))
        yield { kind: "slip.terms-missing", what, entry: replace(sum) };
  }
}

/** Yield a sum with two added terms that give it the target value, and the text of these terms. */
function* findSumsOfThree(tree: Node, target: number, { configuration, fewTerms }: Repairs) {
  const currentValue = evaluate(tree, configuration).re;
  const ownTerms = listExpandedTermValues(tree, configuration) ?? [];
  const cancelsTerm = (value: number) => ownTerms.some((term) => isNear(term, -value));
  for (const multiplier of ownTerms.length > 0 ? fewTerms.multipliers : [])
    for (const product of fewTerms.products) {
      const firstTerm = multiplyTerms(product, multiplier);
      for (const value of [firstTerm.value, -firstTerm.value].filter((candidate) => !cancelsTerm(candidate))) {
        const missingValue = target - currentValue - value;
        for (const secondTerm of cancelsTerm(missingValue)
          ? []
          : findTermsNear(fewTerms, missingValue, RELATIVE_TOLERANCE))
          yield {
            sum: addTerm(addTerm(tree, firstTerm, value), secondTerm, missingValue),
            what: nameTerms([firstTerm.tree, secondTerm.tree]),
          };
      }
    }
}

/** At most this many terms of an expanded entry are considered. */
const MAX_EXPANDED_TERMS = 64;

/** Return the values of the terms of an expanded expression; null if there are too many. */
function listExpandedTermValues(tree: Node, configuration: SymbolValues): number[] | null {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return listExpandedTermValues(left, configuration)?.map((value) => -value) ?? null;
  if (!left || !right || !["+", "-", "*"].includes(tree.kind)) return [evaluate(tree, configuration).re];
  const [leftValues, rightValues] = [
    listExpandedTermValues(left, configuration),
    listExpandedTermValues(right, configuration),
  ];
  if (!leftValues || !rightValues) return null;
  const values =
    tree.kind === "*"
      ? leftValues.flatMap((leftValue) => rightValues.map((rightValue) => leftValue * rightValue))
      : [...leftValues, ...rightValues.map((rightValue) => (tree.kind === "-" ? -rightValue : rightValue))];
  return values.length > MAX_EXPANDED_TERMS ? null : values;
}

/** Return the text that names a term: its lengths and rates, or else its angles, with θ2 for theta2. */
function nameTerm(tree: Node): string {
  const factors = new Set<string>();
  const angles = new Set<string>();
  const visit = (part: Node): void => {
    if (isWave(part)) return findNames(part).forEach((joint) => angles.add(withGreek(joint)));
    if (part.kind === "decimal") factors.add(formatNumber(part.value));
    if (part.kind === "name") factors.add(part.text);
    part.args.forEach(visit);
  };
  visit(tree);
  return factors.size > 0 ? [...factors].sort().join("·") : [...angles].sort().join(", ");
}

const nameTerms = (trees: readonly Node[]): string => [...new Set(trees.map(nameTerm))].sort().join(", ");

/** Return the value of a subexpression with which the entry is right at a configuration; null if there is none. */
function computeTarget(
  { tree, replace }: Pick<Subexpression, "tree" | "replace">,
  expected: number,
  configuration: SymbolValues,
): number | null {
  // Usually, the entry is (p x + q) / (r x + s) in the subexpression's value x; such functions keep cross-ratios.
  const currentValue = evaluate(tree, configuration).re;
  const step = 0.37 * Math.abs(currentValue) + 0.05;
  const entryValueWith = (value: number) => evaluate(replace(decimal(value)), configuration).re;
  const [a, b, c] = [
    entryValueWith(currentValue),
    entryValueWith(currentValue + step),
    entryValueWith(currentValue - step),
  ];
  const ratio = ((expected - a) * (b - c)) / ((expected - c) * (b - a)); // cross-ratio of x, here and here ± step
  const change = ((ratio / 2) * step) / (1 - ratio / 2);
  return Number.isFinite(change) ? currentValue + change : null;
}

/** An expression that may be correct instead of a subexpression; `what` names the missing part, as in `Change`. */
type Replacement = { readonly kind: Kind; readonly tree: Node; readonly what?: string };

/** Yield expressions that may be correct instead of a subexpression. */
function* listReplacements({ tree, parent }: Subexpression, { library, factors }: Repairs): Generator<Replacement> {
  yield { kind: parent === null ? "slip.whole-sign" : "slip.sign", tree: node("neg", tree) };
  if (isWave(tree)) {
    const [angle] = tree.args as [Node];
    yield { kind: "slip.wave", tree: exchangeWave(tree) };
    for (const other of listOtherAngles(angle, library.angles))
      yield { kind: classifyAngleSlip(angle, other), tree: { ...tree, args: [other] } };
  }
  if (tree.kind === "name")
    for (const other of [...library.lengths, ...library.multipliers])
      if (other.kind === "name" && classifySymbol(other.text) === classifySymbol(tree.text))
        yield { kind: "slip.symbol", tree: other };
  if (tree.kind === "*") yield { kind: "slip.factor-extra", tree: tree.args[1] as Node };
  if (tree.kind === "*" || tree.kind === "/") yield { kind: "slip.factor-extra", tree: tree.args[0] as Node };
  for (const factor of [2, 0.5]) yield { kind: "slip.number", tree: node("*", decimal(factor), tree) };
  for (const { tree: factor } of factors) {
    const kind = factor.kind === "call" ? "slip.factor-missing" : "slip.length-missing";
    for (const sign of ["*", "/"] as const) yield { kind, tree: node(sign, tree, factor), what: nameTerm(factor) };
  }
}

/** Yield the changes of a subexpression that give it the target value. */
function* findChanges(subexpression: Subexpression, target: number, repairs: Repairs): Generator<Change> {
  const { tree, parent, replace } = subexpression;
  const { configuration } = repairs;
  const currentValue = evaluate(tree, configuration).re;
  const change = (kind: Kind, other: Node, what = ""): Change => ({ kind, what, entry: replace(other) });
  for (const { kind, tree: other, what } of listReplacements(subexpression, repairs))
    if (isNear(target, evaluate(other, configuration).re)) yield change(kind, other, what);
  if (isWave(tree))
    for (const other of findAnglesWithValue(tree, evaluate(tree.args[0] as Node, configuration).re, target))
      yield change("slip.angle", { ...tree, args: [other] });
  if (tree.kind === "decimal") yield change("slip.constant", decimal(Number(target.toPrecision(6))));
  const isTerm = parent?.kind === "+" || parent?.kind === "-";
  if (isTerm && Math.abs(target) <= RELATIVE_TOLERANCE * Math.abs(currentValue))
    yield change("slip.term-extra", integer(0));
  const missingValue = target - currentValue;
  // a term that would cancel an existing one is not missing
  const cancelsTerm = () =>
    listExpandedTermValues(tree, configuration)?.some((term) => isNear(term, -missingValue)) ?? true;
  if (Math.abs(missingValue) > RELATIVE_TOLERANCE * Math.abs(currentValue) && !cancelsTerm())
    for (const term of findTermsNear(repairs.terms, missingValue, RELATIVE_TOLERANCE))
      yield change("slip.term-missing", addTerm(tree, term, missingValue), nameTerm(term.tree));
}

/** Return a sum with one more term, with the sign that gives the term this value. */
const addTerm = (sum: Node, term: ValuedTree, value: number): Node =>
  node(value * term.value > 0 ? "+" : "-", sum, term.tree);

/** Yield a*(b + c) for a*b + c: the brackets are missing. */
function* addMissingBrackets({ tree, replace }: Subexpression): Generator<Change> {
  const [left, right] = tree.args;
  if ((tree.kind !== "+" && tree.kind !== "-") || left?.kind !== "*") return;
  const [factor, inner] = left.args as [Node, Node];
  yield { kind: "slip.bracket", entry: replace(node("*", factor, node(tree.kind, inner, right as Node))) };
}

/** Missing lengths are searched only if there are at most this many combinations of them. */
const MAX_COMBINATIONS = 3000;

/** Yield the entry with two or more missing lengths: one or two in each of its terms. */
function* addMissingLengths(entry: Node, expected: number, { library, configuration }: Repairs): Generator<Change> {
  const terms = listSummands(entry).map(({ tree, sign }) => ({ tree, sign, value: evaluate(tree, configuration).re }));
  const lengths = library.lengths.map((length) => evaluateTree(length, configuration));
  const pairs = lengths.flatMap((a, i) =>
    lengths.slice(i).map((b) => ({ count: 2, value: a.value * b.value, tree: node("*", a.tree, b.tree) })),
  );
  const factors = [{ count: 0, value: 1, tree: null }, ...lengths.map((a) => ({ count: 1, ...a })), ...pairs];
  if (factors.length ** terms.length > MAX_COMBINATIONS) return;
  const combinations = function* (
    k: number,
    remainder: number,
    chosenFactors: typeof factors,
  ): Generator<typeof factors> {
    const term = terms[k];
    if (!term) {
      const missing = chosenFactors.reduce((sum, { count }) => sum + count, 0);
      if (missing > 1 && Math.abs(remainder) <= RELATIVE_TOLERANCE * Math.abs(expected)) yield chosenFactors;
      return;
    }
    for (const factor of factors)
      yield* combinations(k + 1, remainder - term.sign * term.value * factor.value, [...chosenFactors, factor]);
  };
  for (const combination of combinations(0, expected, [])) {
    const correctedTerms = terms.map(({ tree, sign }, k) => {
      const factor = combination[k]!.tree;
      const product = factor ? node("*", factor, tree) : tree;
      return sign < 0 ? node("neg", product) : product;
    });
    yield { kind: "slip.lengths-missing", entry: correctedTerms.reduce((sum, term) => node("+", sum, term)) };
  }
}

/** Return the terms of a sum with their signs. */
function listSummands(tree: Node, sign = 1): { tree: Node; sign: number }[] {
  const [left, right] = tree.args;
  if (tree.kind === "neg" && left) return listSummands(left, -sign);
  if ((tree.kind === "+" || tree.kind === "-") && left && right)
    return [...listSummands(left, sign), ...listSummands(right, tree.kind === "-" ? -sign : sign)];
  return [{ tree, sign }];
}

/** Return all subexpressions of an entry except those in angles and exponents, which are neither terms nor factors. */
function listSubexpressions(entry: Node): Subexpression[] {
  const subexpressions: Subexpression[] = [];
  const visit = (subexpression: Subexpression): void => {
    const { tree, replace } = subexpression;
    subexpressions.push(subexpression);
    if (tree.kind === "call" && tree.text !== "sqrt") return;
    const inner = tree.kind === "^" ? tree.args.slice(0, 1) : tree.args;
    inner.forEach((arg, k) =>
      visit({
        tree: arg,
        parent: tree,
        replace: (other) => replace({ ...tree, args: tree.args.with(k, other) }),
        isNumerator: (tree.kind === "/" && k === 0) || (subexpression.isNumerator && tree.kind === "neg"),
      }),
    );
  };
  visit({ tree: entry, parent: null, replace: (other) => other, isNumerator: false });
  return subexpressions;
}

const classifySymbol = (text: string): string =>
  /^[vwfm][xyz]$/.test(text) ? (text[0] as string) : text.replace(/\d+$/, "");

const isNear = (a: number, b: number): boolean =>
  Math.abs(a - b) <= RELATIVE_TOLERANCE * Math.max(Math.abs(a), Math.abs(b));
