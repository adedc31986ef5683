// Slips in what was typed: the one change to an entry by which it becomes right says what went wrong there.
//
// For each piece of an entry it is worked out what it would have to be worth for the entry to be right; what it is worth
// says which change that might be. A change counts only if the entry with it is right at all configurations of the key.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { name, type Node, node } from "../read/tree.js";
import type { TextKey } from "../text/en.js";
import { message, type Message } from "../text/text.js";
import {
  type Known,
  known,
  type Library,
  libraryOf,
  type Terms,
  termsNear,
  termsOf,
  waves,
} from "./library.js";
import type { At } from "./verdict.js";

/** Nodes of an entry that is taken apart, and of all of them. */
const LONGEST = 400;
const LONGEST_ANSWER = 1200;
/** Share by which a value at one configuration may differ from what it is taken for. */
const NEAR = 1e-7;

/** The kinds of slips, those first that are told where several changes make an entry right. */
const KINDS = [
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
] as const satisfies readonly TextKey[];
type Kind = (typeof KINDS)[number];

export interface Answer {
  readonly entries: readonly Node[];
  /** Which of them are not right. */
  readonly wrong: readonly number[];
  readonly at: (k: number) => At;
  readonly isRight: (index: number, entry: Node) => boolean;
}

/** What went wrong in an answer, and where; null where no one change makes any of its entries right. */
export function slipIn(answer: Answer, key: ValuesKey): Message | null {
  const { entries, wrong } = answer;
  const left = leftOut(answer, key);
  if (left !== null) return message("slip.column-left-out", { column: left + 1 });
  if (wrong.reduce((sum, i) => sum + sizeOf(entries[i] as Node), 0) > LONGEST_ANSWER) return null;
  const means = meansOf(answer, key);
  const found = new Map(wrong.map((i) => [i, kindsOf(answer, i, key, means)]));
  const made = (kind: Kind) => wrong.filter((i) => found.get(i)?.has(kind));
  const most = Math.max(0, ...KINDS.map((kind) => made(kind).length));
  const kind = most > 0 ? KINDS.find((each) => made(each).length === most) : undefined;
  return kind === undefined ? null : message(kind, { where: whereOf(made(kind), key) });
}

/** The column that has nothing but zeros where something else is due; null without one. */
function leftOut({ entries, wrong }: Answer, { columns }: ValuesKey): number | null {
  if (columns < 2) return null;
  const inColumn = (c: number) => entries.map((_, i) => i).filter((i) => i % columns === c);
  const found = [...new Set(wrong.map((i) => i % columns))];
  return found.find((c) => inColumn(c).every((i) => isZero(entries[i] as Node))) ?? null;
}

const isZero = ({ kind, value }: Node): boolean => kind === "number" && value === 0;

/** Entries in words: one, those of a column, or all that there are. */
function whereOf(entries: readonly number[], { rows, columns }: ValuesKey): Message {
  const place = (i: number) => ({ row: Math.floor(i / columns) + 1, column: (i % columns) + 1 });
  const [first] = entries.map(place) as [ReturnType<typeof place>];
  if (rows * columns === 1) return message("slip.answer");
  if (entries.length === 1) return columns === 1 ? message("slip.row", first) : message("slip.entry", first);
  if (columns > 1 && entries.every((i) => place(i).column === first.column))
    return message("slip.column", first);
  const all = entries.map(place).map(({ row, column }) => (columns === 1 ? `${row}` : `(${row}, ${column})`));
  return message("slip.entries", { entries: all.join(", ") });
}

/** The kinds of changes of which one makes an entry right. */
function kindsOf(answer: Answer, index: number, key: ValuesKey, means: Means): Set<Kind> {
  const entry = answer.entries[index] as Node;
  const kinds = new Set<Kind>();
  const due = key.right[index]?.[0];
  if (sizeOf(entry) > LONGEST || typeof due !== "number") return kinds;
  if (isZero(entry)) return kinds.add("slip.zero"); // there is nothing to which a term could be added
  for (const { kind, entry: changed } of changes(entry, due, means))
    if (!kinds.has(kind) && answer.isRight(index, changed)) kinds.add(kind);
  return kinds;
}

interface Change {
  readonly kind: Kind;
  readonly entry: Node;
}

/** A piece of an entry: the entry with something else in its place. */
interface Piece {
  readonly tree: Node;
  readonly parent: Node | null;
  readonly put: (other: Node) => Node;
}

/** What an entry may be mended with, at the first configuration. */
interface Means {
  readonly library: Library;
  readonly at: At;
  readonly terms: Terms;
  readonly factors: readonly Known[];
}

function meansOf({ entries, at }: Answer, key: ValuesKey): Means {
  const library = libraryOf(key.symbols, entries);
  const first = at(0);
  const factors = [...waves(library, first), ...library.lengths.map((each) => known(each, first))];
  return { library, at: first, terms: termsOf(library, first), factors };
}

function* changes(entry: Node, due: number, means: Means): Generator<Change> {
  const { library, at } = means;
  const isDue = (other: Node) => near(evaluate(other, at).re, due);
  const kept = function* (kind: Kind, other: Node): Generator<Change> {
    if (isDue(other)) yield { kind, entry: other };
  };
  yield* kept("slip.whole-sign", node("neg", entry));
  yield* kept("slip.all-waves", everyWave(entry, otherWave));
  for (const [angle, angles] of anglesIn(entry, library))
    for (const other of angles)
      yield* kept(
        kindOfAngle(angle, other),
        everyWave(entry, (wave) => withAngle(wave, angle, other)),
      );
  for (const first of library.angles.filter(({ kind }) => kind === "name"))
    yield* kept(
      "slip.relative",
      everyWave(entry, (wave) => countedFrom(first, wave, library)),
    );
  yield* lengthened(entry, due, means);
  for (const piece of piecesOf(entry)) {
    yield* bracketed(piece);
    const wanted = wantedOf(piece, due, at);
    if (wanted !== null) yield* changesOf(piece, wanted, means);
  }
}

/** What a piece has to be worth for the entry to be right at a configuration; null where that is no number. */
function wantedOf({ tree, put }: Piece, due: number, at: At): number | null {
  // where a piece stands once, the entry is (p x + q) / (r x + s), which keeps cross-ratios
  const here = evaluate(tree, at).re;
  const step = 0.37 * Math.abs(here) + 0.05;
  const worth = (value: number) => evaluate(put(decimal(value)), at).re;
  const [a, b, c] = [worth(here), worth(here + step), worth(here - step)];
  const ratio = ((due - a) * (b - c)) / ((due - c) * (b - a)); // of x - here over x - (here - step), halved
  const moved = ((ratio / 2) * step) / (1 - ratio / 2);
  return Number.isFinite(moved) ? here + moved : null;
}

function* changesOf({ tree, parent, put }: Piece, wanted: number, means: Means): Generator<Change> {
  const { library, at } = means;
  const here = evaluate(tree, at).re;
  const changed = (kind: Kind, other: Node): Change => ({ kind, entry: put(other) });
  if (near(wanted, -here))
    yield changed(parent === null ? "slip.whole-sign" : "slip.sign", node("neg", tree));
  if (isWave(tree)) {
    if (near(wanted, evaluate(otherWave(tree), at).re)) yield changed("slip.wave", otherWave(tree));
    const [angle] = tree.args as [Node];
    for (const other of otherAngles(angle, library)) {
      const wave = { ...tree, args: [other] };
      if (near(wanted, evaluate(wave, at).re)) yield changed(kindOfAngle(angle, other), wave);
    }
  }
  if (tree.kind === "name")
    for (const other of [...library.lengths, ...library.multipliers])
      if (
        other.kind === "name" &&
        stem(other.text) === stem(tree.text) &&
        near(wanted, at[other.text] ?? NaN)
      )
        yield changed("slip.symbol", other);
  if (tree.kind === "decimal") yield changed("slip.constant", decimal(Number(wanted.toPrecision(6))));
  const isTerm = parent !== null && (parent.kind === "+" || parent.kind === "-");
  if (isTerm && Math.abs(wanted) <= NEAR * Math.abs(here))
    yield changed("slip.term-extra", { ...decimal(0), kind: "number" });
  if (tree.kind === "*" || tree.kind === "/")
    for (const kept of tree.kind === "*" ? tree.args : tree.args.slice(0, 1))
      if (near(wanted, evaluate(kept, at).re)) yield changed("slip.factor-extra", kept);
  for (const factor of [2, 0.5])
    if (near(wanted, factor * here)) yield changed("slip.number", node("*", decimal(factor), tree));
  for (const factor of means.factors) {
    const kind = factor.tree.kind !== "call" ? "slip.length-missing" : "slip.factor-missing";
    if (near(wanted, here * factor.value)) yield changed(kind, node("*", tree, factor.tree));
    if (near(wanted, here / factor.value)) yield changed(kind, node("/", tree, factor.tree));
  }
  const lacking = wanted - here;
  if (Math.abs(lacking) > NEAR * Math.abs(here))
    for (const term of termsNear(means.terms, lacking, NEAR))
      yield changed("slip.term-missing", node(term.value * lacking > 0 ? "+" : "-", tree, term.tree));
}

/** a*(b + c) for a*b + c: the bracket is missing. */
function* bracketed({ tree, put }: Piece): Generator<Change> {
  const [left, right] = tree.args;
  if ((tree.kind !== "+" && tree.kind !== "-") || !left || !right) return;
  const outer = (factor: Node, inner: Node, rest: Node) =>
    put(node("*", factor, node(tree.kind, inner, rest)));
  if (left.kind === "*")
    yield { kind: "slip.bracket", entry: outer(left.args[0] as Node, left.args[1] as Node, right) };
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
    for (const factor of factors)
      yield* ways(k + 1, left - term.sign * term.value * factor.value, [...chosen, factor]);
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
  const visit = (tree: Node, parent: Node | null, put: (other: Node) => Node): void => {
    found.push({ tree, parent, put });
    if (tree.kind === "call" && tree.text !== "sqrt") return;
    const inner = tree.kind === "^" ? tree.args.slice(0, 1) : tree.args;
    inner.forEach((arg, k) =>
      visit(arg, tree, (other) =>
        put({ ...tree, args: tree.args.map((each, i) => (i === k ? other : each)) }),
      ),
    );
  };
  visit(entry, null, (other) => other);
  return found;
}

function sizeOf(tree: Node): number {
  return tree.args.reduce((sum, arg) => sum + sizeOf(arg), 1);
}

const decimal = (value: number): Node => ({ ...name(""), kind: "decimal", value });
const stem = (text: string): string =>
  /^[vwfm][xyz]$/.test(text) ? (text[0] as string) : text.replace(/\d+$/, "");

function near(a: number, b: number): boolean {
  return Math.abs(a - b) <= NEAR * Math.max(Math.abs(a), Math.abs(b));
}

// --- sines and cosines ---

const isWave = ({ kind, text }: Node): boolean => kind === "call" && (text === "sin" || text === "cos");
const otherWave = (tree: Node): Node => ({ ...tree, text: tree.text === "sin" ? "cos" : "sin" });

function everyWave(tree: Node, change: (wave: Node) => Node): Node {
  if (isWave(tree)) return change(tree);
  return tree.args.length === 0 ? tree : { ...tree, args: tree.args.map((arg) => everyWave(arg, change)) };
}

/** How often each joint stands in an angle; null where there is anything else in it. */
function jointsIn(angle: Node): ReadonlyMap<string, number> | null {
  const found = new Map<string, number>();
  const visit = ({ kind, args, text }: Node, sign: number): boolean => {
    if (kind === "name" && /^theta\d+$/.test(text))
      return (found.set(text, (found.get(text) ?? 0) + sign), true);
    const [left, right] = args;
    if (kind === "neg" && left) return visit(left, -sign);
    if (kind !== "+" && kind !== "-") return false;
    return visit(left as Node, sign) && visit(right as Node, kind === "-" ? -sign : sign);
  };
  return visit(angle, 1) ? found : null;
}

const angleText = (angle: Node): string => {
  const joints = jointsIn(angle);
  return joints
    ? [...joints]
        .sort()
        .map(([joint, count]) => `${count} ${joint}`)
        .join()
    : "";
};

/** The angles of an entry's sines and cosines, each with those that may be due in its place. */
function anglesIn(entry: Node, library: Library): (readonly [Node, Node[]])[] {
  const found = new Map<string, Node>();
  everyWave(entry, (wave) => {
    const [angle] = wave.args as [Node];
    if (angleText(angle)) found.set(angleText(angle), angle);
    return wave;
  });
  return [...found.values()].map((angle) => [angle, otherAngles(angle, library)]);
}

function withAngle(wave: Node, old: Node, angle: Node): Node {
  return angleText(wave.args[0] as Node) === angleText(old) ? { ...wave, args: [angle] } : wave;
}

/** The sine or cosine of an angle that is counted from a joint on, which stands before all of its own. */
function countedFrom(first: Node, wave: Node, { angles }: Library): Node {
  const mine = jointsIn(wave.args[0] as Node);
  const due = angles.find((angle) => {
    const joints = [...(jointsIn(angle)?.keys() ?? [])];
    return joints[0] === first.text && mine && [...mine.keys()].sort().at(-1) === joints.at(-1);
  });
  return due && kindOfAngle(wave.args[0] as Node, due) === "slip.relative" ? { ...wave, args: [due] } : wave;
}

/** The sums of successive joints, and an angle with one joint more, one less, or one the other way. */
function otherAngles(angle: Node, { angles }: Library): Node[] {
  const joints = angles.filter(({ kind }) => kind === "name");
  const more = joints.flatMap((joint) => [node("+", angle, joint), node("-", angle, joint)]);
  const turned = joints.flatMap((joint) => {
    const count = jointsIn(angle)?.get(joint.text) ?? 0;
    if (count === 0) return [];
    const twice = node("*", decimal(2 * Math.abs(count)), joint);
    return [node(count > 0 ? "-" : "+", angle, twice)];
  });
  return [...angles, ...more, ...turned];
}

/** Whether the joints before it are missing in an angle that ends with the same joint. */
function kindOfAngle(typed: Node, due: Node): Kind {
  const [mine, theirs] = [jointsIn(typed), jointsIn(due)];
  if (!mine || !theirs) return "slip.angle";
  const isIn = [...mine].every(([joint, count]) => count === 1 && theirs.get(joint) === 1);
  const lasts = [mine, theirs].map((joints) => [...joints.keys()].sort().at(-1));
  return isIn && theirs.size > mine.size && lasts[0] === lasts[1] ? "slip.relative" : "slip.angle";
}
