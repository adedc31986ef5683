// Slips in what was typed: changes by which entries become right say what went wrong there.
//
// A slip counts only if the entry with it undone is right at all configurations of the key, a mistake of the problem's
// only if it gives the entries, all others being as expected. Each entry is explained by one of them.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { sizeOf } from "../read/products.js";
import { namesIn, type Node } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import { type Change, changes, KINDS, type Kind, meansOf, type Means, withTwoTerms } from "./changes.js";
import type { At, Slip } from "./verdict.js";

/** Nodes of an entry that is taken apart, and of all of them. */
const LONGEST = 400;
const LONGEST_ANSWER = 1200;
/** So many slips are told of an answer. */
const MOST_TOLD = 3;
/** So many entries are listed, where they are no column and not all the others. */
const MOST_LISTED = 4;
/** Kinds of slips that say more of a column than the problem's mistakes do. */
const FIRST: readonly Kind[] = ["slip.whole-sign", "slip.wave", "slip.all-waves", "slip.relative"];

export interface Answer {
  readonly entries: readonly Node[];
  /** Which of them are not right. */
  readonly wrong: readonly number[];
  readonly at: (k: number) => At;
  readonly isRight: (index: number, entry: Node) => boolean;
  /** The index of what is said of the mistake that gives some of the entries, with all others as expected. */
  readonly mistakeIn: (some: ReadonlySet<number>) => number | undefined;
}

/** What may have gone wrong in some entries; `whole`, if it is in all of them or is not what went wrong. */
type Finding = { readonly places: readonly number[]; readonly says: (where: Message) => Slip; readonly whole: boolean };

/** What went wrong in an answer, and whether that explains all of its wrong entries. */
export type Explained = { readonly slips: readonly Slip[]; readonly isAll: boolean };

/** What went wrong in an answer, and where: as few slips as explain most of its wrong entries, each entry by one. */
export function slipsIn(answer: Answer, key: ValuesKey): Explained {
  const [missing, others] = ofSymbols(answer, key);
  const findings = [...leftOut(answer, key), ...missing, ...slipsAndMistakes(answer, key), ...others];
  const { told, open } = fewest(findings, answer.wrong, MOST_TOLD);
  const isAll = open.length === 0 && told.length > 1;
  const wheres = told.map(({ places }) => whereOf(places, answer.wrong, key));
  const isLong = wheres.map(({ key }, k) => key === "slip.entries" && told[k]!.places.length > MOST_LISTED);
  const last = isAll ? isLong.indexOf(true) : -1; // which is all that the others are not
  if (last >= 0) wheres[last] = message("slip.others");
  const begins = (k: number) => (k === last ? Infinity : (told[k]!.places[0] as number) % key.columns);
  const order = told.map((_, k) => k).sort((a, b) => begins(a) - begins(b));
  return { slips: order.map((k) => told[k]!.says(wheres[k]!)), isAll: open.length === 0 };
}

/** Repeatedly take the finding that explains most open places; one that is `whole` explains all its places or none. */
export function fewest<F extends { readonly places: readonly number[]; readonly whole?: boolean }>(
  findings: readonly F[],
  places: readonly number[],
  most = Infinity,
): { readonly told: readonly F[]; readonly open: readonly number[] } {
  const told: F[] = [];
  let open = places;
  while (open.length > 0 && told.length < most) {
    const still = findings.map((found) => {
      const left = found.places.filter((i) => open.includes(i));
      return { ...found, places: found.whole && left.length < found.places.length ? [] : left };
    });
    const count = Math.max(0, ...still.map((found) => found.places.length));
    const best = still.find((found) => found.places.length === count);
    if (count === 0 || !best) break;
    told.push(best);
    open = open.filter((i) => !best.places.includes(i));
  }
  return { told, open };
}

/** Columns that have nothing but zeros where something else is expected. */
function leftOut({ entries, wrong }: Answer, { columns }: ValuesKey): Finding[] {
  if (columns < 2) return [];
  const inColumn = (c: number) => entries.filter((_, i) => i % columns === c);
  return [...new Set(wrong.map((i) => i % columns))]
    .filter((c) => inColumn(c).every(isZero))
    .map((c) => ({
      places: wrong.filter((i) => i % columns === c),
      whole: true,
      says: () => message("slip.column-left-out", { column: c + 1 }),
    }));
}

const isZero = ({ kind, value }: Node): boolean => kind === "number" && value === 0;

/** Share of what is expected, or of its terms with a symbol, by which values of six digits may differ. */
const SIX_DIGITS = 1e-5;
/** How many times as large as that the terms with a symbol are, for them to be missed. */
const TELLING = 100;

/** All terms with a rate, a velocity or a force that are missing, have the other sign, or lack it. */
const SYMBOL_SLIPS = [
  { kind: "slip.symbol-missing", off: (x: number) => x, isIn: false },
  { kind: "slip.symbol-sign", off: (x: number) => 2 * x, isIn: true },
  { kind: "slip.symbol-left-out", off: (x: number) => x - 1, isIn: false },
] as const;

/** What went wrong in all terms with one symbol, which an entry has as a factor alone: first that they are missing. */
function ofSymbols(answer: Answer, key: ValuesKey): [missing: Finding[], others: Finding[]] {
  const linear = Object.entries(key.linear ?? {});
  const found = SYMBOL_SLIPS.map(({ kind, off, isIn }) => {
    const places = new Map<string, number[]>();
    for (const i of answer.wrong) {
      const used = namesIn(answer.entries[i] as Node);
      const some = linear.filter(([symbol, factors]) => used.has(symbol) === isIn && factors[i]?.some(Boolean));
      // all of several, or one of them
      for (const symbols of some.length > 1 ? [some, ...some.map((one) => [one])] : [some])
        if (symbols.length > 0 && isOffBy(answer, i, key, symbols, off)) {
          const what = symbols.map(([symbol]) => symbol).join(", ");
          places.set(what, [...(places.get(what) ?? []), i]);
        }
    }
    return [...places].map(([what, all]) => ({
      places: all,
      whole: false,
      says: (where: Message) => message(kind, { where, what }),
    }));
  });
  return [found[0] ?? [], found.slice(1).flat()];
}

type Linear = readonly [symbol: string, factors: readonly (readonly number[])[]];
type Off = (x: number) => number;

/** Whether an entry lacks what its terms with symbols are worth when these have other values. */
function isOffBy({ entries, at }: Answer, index: number, key: ValuesKey, symbols: Linear[], off: Off): boolean {
  const points = symbols[0]?.[1][index]?.length ?? 0;
  return Array.from({ length: points }, (_, k) => k).every((k) => {
    const due = key.right[index]?.[k] ?? NaN;
    const each = symbols.map(([symbol, factors]) => (factors[index]?.[k] ?? NaN) * off(at(k)[symbol] ?? NaN));
    const change = each.reduce((sum, one) => sum + one, 0);
    const room = SIX_DIGITS * Math.max(Math.abs(due), ...each.map(Math.abs));
    const lacking = due - evaluate(entries[index] as Node, at(k)).re;
    return Math.abs(change) > TELLING * room && Math.abs(lacking - change) <= room;
  });
}

function slipsAndMistakes(answer: Answer, key: ValuesKey): Finding[] {
  const { entries, wrong, at } = answer;
  const mistakes = mistakesIn(answer, key);
  if (wrong.reduce((sum, i) => sum + sizeOf(entries[i] as Node, LONGEST_ANSWER + 1), 0) > LONGEST_ANSWER)
    return mistakes;
  const means = meansOf(entries, at(0), key);
  const found = new Map(wrong.map((i) => [i, slipsOf(answer, i, key, means)]));
  const named = new Map([...found.values()].flatMap((slips) => [...slips]));
  const slips = (isTold: (kind: Kind) => boolean): Finding[] =>
    KINDS.filter(isTold).flatMap((kind) =>
      [...named]
        .filter(([, slip]) => slip.kind === kind)
        .map(([name, { what }]) => ({
          places: wrong.filter((i) => found.get(i)?.has(name)),
          whole: false,
          says: (where) => message(kind, what ? { where, what } : { where }),
        })),
    );
  return [...slips((kind) => FIRST.includes(kind)), ...mistakes, ...slips((kind) => !FIRST.includes(kind))];
}

/** The problem's mistakes that give a column, or a row, or all wrong entries but those of one or but one. */
function mistakesIn({ wrong, mistakeIn }: Answer, { columns }: ValuesKey): Finding[] {
  const lines = [...wrong.map((i) => (j: number) => i % columns === j % columns)];
  if (columns > 1) lines.push(...wrong.map((i) => (j: number) => Math.floor(i / columns) === Math.floor(j / columns)));
  const some = lines.flatMap((isIn) => [wrong.filter(isIn), wrong.filter((i) => !isIn(i))]);
  const sets = [...some, ...wrong.map((i) => wrong.filter((j) => j !== i))];
  const apart = new Map(
    sets.filter(({ length }) => length > 0 && length < wrong.length).map((places) => [places.join(), places]),
  );
  return [...apart.values()].flatMap((places) => {
    const mistake = mistakeIn(new Set(places));
    return mistake === undefined ? [] : [{ places, whole: true, says: (where: Message) => ({ mistake, where }) }];
  });
}

/** Entries in words: one, those of a column that are `wrong`, or all that there are. */
function whereOf(entries: readonly number[], wrong: readonly number[], key: ValuesKey): Message {
  const { rows, columns } = key;
  const place = (i: number) => ({ row: Math.floor(i / columns) + 1, column: (i % columns) + 1 });
  const [first] = entries.map(place) as [ReturnType<typeof place>];
  if (rows * columns === 1) return message("slip.answer");
  if (entries.length === 1) return columns === 1 ? message("slip.row", first) : message("slip.entry", first);
  const inColumn = wrong.filter((i) => place(i).column === first.column);
  if (columns > 1 && inColumn.join() === entries.join()) return message("slip.column", first);
  const all = entries.map(place).map(({ row, column }) => (columns === 1 ? `${row}` : `(${row}, ${column})`));
  return message("slip.entries", { entries: all.join(", ") });
}

/** The slips of which one, undone, makes an entry right, by kind and by what is missing. */
function slipsOf(answer: Answer, index: number, key: ValuesKey, means: Means): Map<string, TypedSlip> {
  const entry = answer.entries[index] as Node;
  const found = new Map<string, TypedSlip>();
  const due = key.right[index]?.[0];
  if (sizeOf(entry, LONGEST + 1) > LONGEST || typeof due !== "number") return found;
  // there is nothing in a zero to which a term could be added
  if (isZero(entry)) return found.set("slip.zero", { kind: "slip.zero" });
  const look = (some: Iterable<Change>) => {
    for (const { kind, what = "", entry: changed } of some) {
      const slip = `${kind} ${what}`;
      if (!found.has(slip) && answer.isRight(index, changed)) found.set(slip, { kind, what });
    }
  };
  look(changes(entry, due, means));
  // of products that add up to nothing, two seem to be missing in the others
  if (found.size === 0 && due !== 0) look(withTwoTerms(entry, due, means));
  return found;
}

type TypedSlip = { readonly kind: Kind; readonly what?: string };
