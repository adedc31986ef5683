// Find slips in formulas: changes by which wrong entries become right.
//
// A slip counts only if the entry with the slip undone is right at all configurations of the key. A known mistake of
// the problem counts only if it gives the entries while all others are as expected. One of them explains each entry.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { sizeOf } from "../read/products.js";
import { namesIn, type Node } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import {
  type Change,
  type Kind,
  KINDS,
  type Repairs,
  repairsFor,
  singleChanges,
  withTwoTerms,
} from "./single-changes.js";
import type { SymbolValues, Slip } from "./verdict.js";

/** Maximum number of nodes of an entry that is examined, and of all entries. */
const MAX_ENTRY_SIZE = 400;
const MAX_ANSWER_SIZE = 1200;
/** At most this many slips are reported. */
const MAX_REPORTED = 3;
/** At most this many entries are listed, unless they are a column or all others. */
const MAX_LISTED = 4;
/** Kinds of slips that explain a column better than the problem's mistakes. */
const FIRST_KINDS: readonly Kind[] = ["slip.whole-sign", "slip.wave", "slip.all-waves", "slip.relative"];

export interface Answer {
  readonly entries: readonly Node[];
  /** Indices of entries that are not right. */
  readonly wrong: readonly number[];
  readonly at: (k: number) => SymbolValues;
  readonly isRight: (index: number, entry: Node) => boolean;
  /** Return the index of the mistake that gives `some` entries while all others are as expected. */
  readonly mistakeIn: (some: ReadonlySet<number>) => number | undefined;
}

/** A possible explanation of some entries; an indivisible one counts only if it explains all of them. */
type Finding = {
  readonly places: readonly number[];
  readonly report: (where: Message) => Slip;
  readonly isIndivisible: boolean;
};

/** The slips of an answer, and whether they explain all wrong entries. */
export type Explained = { readonly slips: readonly Slip[]; readonly isAll: boolean };

/** Return as few slips as explain most wrong entries, each entry by one slip, and where they are. */
export function slipsIn(answer: Answer, key: ValuesKey): Explained {
  const [missing, otherFindings] = findSymbolSlips(answer, key);
  const findings = [...findMissingColumns(answer, key), ...missing, ...slipsAndMistakes(answer, key), ...otherFindings];
  const { chosen, open } = coverPlaces(findings, answer.wrong, MAX_REPORTED);
  const isAll = open.length === 0 && chosen.length > 1;
  const wheres = chosen.map(({ places }) => whereOf(places, answer.wrong, key));
  const isLong = wheres.map(({ key }, k) => key === "slip.entries" && chosen[k]!.places.length > MAX_LISTED);
  const last = isAll ? isLong.indexOf(true) : -1; // its places are all those of no other slip
  if (last >= 0) wheres[last] = message("slip.others");
  const firstColumnOf = (k: number) => (k === last ? Infinity : (chosen[k]!.places[0] as number) % key.columns);
  const order = chosen.map((_, k) => k).sort((a, b) => firstColumnOf(a) - firstColumnOf(b));
  return { slips: order.map((k) => chosen[k]!.report(wheres[k]!)), isAll: open.length === 0 };
}

/** Repeatedly choose the finding that explains most open places; an indivisible one explains all its places or none. */
export function coverPlaces<F extends { readonly places: readonly number[]; readonly isIndivisible?: boolean }>(
  findings: readonly F[],
  places: readonly number[],
  most = Infinity,
): { readonly chosen: readonly F[]; readonly open: readonly number[] } {
  const chosen: F[] = [];
  let open = places;
  while (open.length > 0 && chosen.length < most) {
    const openFindings = findings.map((finding) => {
      const places = finding.places.filter((i) => open.includes(i));
      return { ...finding, places: finding.isIndivisible && places.length < finding.places.length ? [] : places };
    });
    const count = Math.max(0, ...openFindings.map((finding) => finding.places.length));
    const best = openFindings.find((finding) => finding.places.length === count);
    if (count === 0 || !best) break;
    chosen.push(best);
    open = open.filter((i) => !best.places.includes(i));
  }
  return { chosen, open };
}

/** Report columns that contain only zeros where something else is expected. */
function findMissingColumns({ entries, wrong }: Answer, { columns }: ValuesKey): Finding[] {
  if (columns < 2) return [];
  const inColumn = (c: number) => entries.filter((_, i) => i % columns === c);
  return [...new Set(wrong.map((i) => i % columns))]
    .filter((c) => inColumn(c).every(isZero))
    .map((c) => ({
      places: wrong.filter((i) => i % columns === c),
      isIndivisible: true,
      report: () => message("slip.column-left-out", { column: c + 1 }),
    }));
}

const isZero = ({ kind, value }: Node): boolean => kind === "number" && value === 0;

/** Relative tolerance for values with six digits. */
const SIX_DIGITS = 1e-5;
/** How many times this tolerance a symbol's terms must be, for their absence to be noticed. */
const NOTICEABLE = 100;

/** Ways in which all terms with a rate, velocity or force may be wrong; `off` is the change of the symbol's value. */
const SYMBOL_SLIPS = [
  { kind: "slip.symbol-missing", off: (x: number) => x, isIn: false },
  { kind: "slip.symbol-sign", off: (x: number) => 2 * x, isIn: true },
  { kind: "slip.symbol-left-out", off: (x: number) => x - 1, isIn: false },
] as const;

/** Report slips in all terms with one symbol, which is a factor of these terms; missing terms come first. */
function findSymbolSlips(answer: Answer, key: ValuesKey): [missing: Finding[], otherFindings: Finding[]] {
  const linear = Object.entries(key.linear ?? {});
  const findings = SYMBOL_SLIPS.map(({ kind, off, isIn }) => {
    const places = new Map<string, number[]>();
    for (const i of answer.wrong) {
      const used = namesIn(answer.entries[i] as Node);
      const factorsHere = linear.filter(([symbol, factors]) => used.has(symbol) === isIn && factors[i]?.some(Boolean));
      // all of several symbols, or one of them
      for (const symbols of factorsHere.length > 1
        ? [factorsHere, ...factorsHere.map((factors) => [factors])]
        : [factorsHere])
        if (symbols.length > 0 && lacksTermsWith(answer, i, key, symbols, off)) {
          const what = symbols.map(([symbol]) => symbol).join(", ");
          places.set(what, [...(places.get(what) ?? []), i]);
        }
    }
    return [...places].map(([what, all]) => ({
      places: all,
      isIndivisible: false,
      report: (where: Message) => message(kind, { where, what }),
    }));
  });
  return [findings[0] ?? [], findings.slice(1).flat()];
}

type SymbolFactors = readonly [symbol: string, factors: readonly (readonly number[])[]];
type OffBy = (x: number) => number;

/** Return whether an entry lacks exactly what its terms with some symbols change by. */
function lacksTermsWith(
  { entries, at }: Answer,
  index: number,
  key: ValuesKey,
  symbols: SymbolFactors[],
  off: OffBy,
): boolean {
  const points = symbols[0]?.[1][index]?.length ?? 0;
  return Array.from({ length: points }, (_, k) => k).every((k) => {
    const expected = key.right[index]?.[k] ?? NaN;
    const contributions = symbols.map(([symbol, factors]) => (factors[index]?.[k] ?? NaN) * off(at(k)[symbol] ?? NaN));
    const change = contributions.reduce((sum, contribution) => sum + contribution, 0);
    const tolerance = SIX_DIGITS * Math.max(Math.abs(expected), ...contributions.map(Math.abs));
    const lacking = expected - evaluate(entries[index] as Node, at(k)).re;
    return Math.abs(change) > NOTICEABLE * tolerance && Math.abs(lacking - change) <= tolerance;
  });
}

function slipsAndMistakes(answer: Answer, key: ValuesKey): Finding[] {
  const { entries, wrong, at } = answer;
  const mistakes = mistakesIn(answer, key);
  if (wrong.reduce((sum, i) => sum + sizeOf(entries[i] as Node, MAX_ANSWER_SIZE + 1), 0) > MAX_ANSWER_SIZE)
    return mistakes;
  const repairs = repairsFor(entries, at(0), key);
  const slipsAt = new Map(wrong.map((i) => [i, slipsByName(answer, i, key, repairs)]));
  const named = new Map([...slipsAt.values()].flatMap((slips) => [...slips]));
  const slips = (isIncluded: (kind: Kind) => boolean): Finding[] =>
    KINDS.filter(isIncluded).flatMap((kind) =>
      [...named]
        .filter(([, slip]) => slip.kind === kind)
        .map(([name, { what }]) => ({
          places: wrong.filter((i) => slipsAt.get(i)?.has(name)),
          isIndivisible: false,
          report: (where) => message(kind, what ? { where, what } : { where }),
        })),
    );
  return [...slips((kind) => FIRST_KINDS.includes(kind)), ...mistakes, ...slips((kind) => !FIRST_KINDS.includes(kind))];
}

/** Report known mistakes that explain a column, a row, all wrong entries outside of one, or all but one entry. */
function mistakesIn({ wrong, mistakeIn }: Answer, { columns }: ValuesKey): Finding[] {
  const lines = [...wrong.map((i) => (j: number) => i % columns === j % columns)];
  if (columns > 1) lines.push(...wrong.map((i) => (j: number) => Math.floor(i / columns) === Math.floor(j / columns)));
  const groups = lines.flatMap((isIn) => [wrong.filter(isIn), wrong.filter((i) => !isIn(i))]);
  const sets = [...groups, ...wrong.map((i) => wrong.filter((j) => j !== i))];
  const distinct = new Map(
    sets.filter(({ length }) => length > 0 && length < wrong.length).map((places) => [places.join(), places]),
  );
  return [...distinct.values()].flatMap((places) => {
    const mistake = mistakeIn(new Set(places));
    return mistake === undefined
      ? []
      : [{ places, isIndivisible: true, report: (where: Message) => ({ mistake, where }) }];
  });
}

/** Describe the place of entries: one entry, a column's `wrong` entries, or a list. */
function whereOf(entries: readonly number[], wrong: readonly number[], key: ValuesKey): Message {
  const { rows, columns } = key;
  const place = (i: number) => ({ row: Math.floor(i / columns) + 1, column: (i % columns) + 1 });
  const [first] = entries.map(place) as [ReturnType<typeof place>];
  if (rows * columns === 1) return message("slip.answer");
  if (entries.length === 1) return columns === 1 ? message("slip.row", first) : message("slip.entry", first);
  const inColumn = wrong.filter((i) => place(i).column === first.column);
  if (columns > 1 && inColumn.join() === entries.join()) return message("slip.column", first);
  const places = entries.map(place).map(({ row, column }) => (columns === 1 ? `${row}` : `(${row}, ${column})`));
  return message("slip.entries", { entries: places.join(", ") });
}

/** Return the slips each of which, undone, makes an entry right; by kind and missing part. */
function slipsByName(answer: Answer, index: number, key: ValuesKey, repairs: Repairs): Map<string, TypedSlip> {
  const entry = answer.entries[index] as Node;
  const slips = new Map<string, TypedSlip>();
  const expected = key.right[index]?.[0];
  if (sizeOf(entry, MAX_ENTRY_SIZE + 1) > MAX_ENTRY_SIZE || typeof expected !== "number") return slips;
  // a zero has no terms to which another could be added
  if (isZero(entry)) return slips.set("slip.zero", { kind: "slip.zero" });
  const collect = (some: Iterable<Change>) => {
    for (const { kind, what = "", entry: changed } of some) {
      const slip = `${kind} ${what}`;
      if (!slips.has(slip) && answer.isRight(index, changed)) slips.set(slip, { kind, what });
    }
  };
  collect(singleChanges(entry, expected, repairs));
  // if products add up to zero, two terms seem to be missing in the others
  if (slips.size === 0 && expected !== 0) collect(withTwoTerms(entry, expected, repairs));
  return slips;
}

type TypedSlip = { readonly kind: Kind; readonly what?: string };
