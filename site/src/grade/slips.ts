// Find slips in formulas: changes by which wrong entries become right.
//
// A slip counts only if the entry with the slip undone is right at all configurations of the key. A known mistake of
// the problem counts only if it gives the entries while all others are as expected. One of them explains each entry.

import type { ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { countNodes } from "../read/products.js";
import { findNames, type Node, locateEntry, type SymbolValues } from "../read/tree.js";
import { message, type Message } from "../text/text.js";
import type { Change, Kind, Repairs } from "./single-changes.js";
import { KINDS, buildRepairs, findSingleChanges, addTwoTerms } from "./single-changes.js";
import type { Slip } from "./verdict.js";

/** Maximum number of nodes of an entry that is examined, and of all entries. */
const MAX_ENTRY_SIZE = 400;
const MAX_ANSWER_SIZE = 1200;
/** At most this many slips are reported. */
const MAX_REPORTED = 3;
/** At most this many entries are listed, unless they are a column or all others. */
const MAX_LISTED = 4;
/** Kinds of slips that explain a column better than the problem's mistakes. */
const FIRST_KINDS: readonly Kind[] = ["slip.whole-sign", "slip.wave", "slip.all-waves", "slip.relative"];

export interface WrongAnswer {
  readonly entries: readonly Node[];
  /** Indices of entries that are not right. */
  readonly wrongIndices: readonly number[];
  /** Return configuration k of the key. */
  readonly configurationAt: (k: number) => SymbolValues;
  /** Return whether a tree is right as the entry with this index. */
  readonly isRight: (index: number, entry: Node) => boolean;
  /** Return the index of the mistake that gives the entries at some places while all others are as expected. */
  readonly findMistakeIn: (places: ReadonlySet<number>) => number | undefined;
}

/** An explanation of the wrong entries at `places` (indices); an indivisible one counts only if it explains all. */
type Finding = {
  readonly places: readonly number[];
  readonly report: (where: Message) => Slip;
  readonly isIndivisible: boolean;
};

/** The slips of an answer, and whether they explain all wrong entries. */
type Explanation = { readonly slips: readonly Slip[]; readonly explainsAll: boolean };

/** Return as few slips as explain most wrong entries, each entry by one slip, and where they are. */
export function findSlips(answer: WrongAnswer, key: ValuesKey): Explanation {
  const { missingTerms, otherFindings } = findSymbolSlips(answer, key);
  const findings = [
    ...findMissingColumns(answer, key),
    ...missingTerms,
    ...findSlipsAndMistakes(answer, key),
    ...otherFindings,
  ];
  const { chosenFindings, unexplainedPlaces } = coverPlaces(findings, answer.wrongIndices, MAX_REPORTED);
  const explainsAll = unexplainedPlaces.length === 0;
  const locations = chosenFindings.map(({ places }) => describePlaces(places, answer.wrongIndices, key));
  const longListFlags = locations.map(
    (location, k) => location.key === "slip.entries" && chosenFindings[k]!.places.length > MAX_LISTED,
  );
  // a long list is not needed if its places are all those of no other slip
  const longIndex = explainsAll && chosenFindings.length > 1 ? longListFlags.indexOf(true) : -1;
  if (longIndex >= 0) locations[longIndex] = message("slip.others");
  const firstColumnOf = (k: number) =>
    k === longIndex ? Infinity : (chosenFindings[k]!.places[0] as number) % key.columns;
  const order = chosenFindings.map((_, k) => k).sort((a, b) => firstColumnOf(a) - firstColumnOf(b));
  return { slips: order.map((k) => chosenFindings[k]!.report(locations[k]!)), explainsAll };
}

/** Repeatedly choose the finding that explains most of the places not yet explained, at most `maxCount` times. */
export function coverPlaces<F extends { readonly places: readonly number[]; readonly isIndivisible?: boolean }>(
  findings: readonly F[],
  places: readonly number[],
  maxCount = Infinity,
): { readonly chosenFindings: readonly F[]; readonly unexplainedPlaces: readonly number[] } {
  const chosenFindings: F[] = [];
  let unexplainedPlaces = places;
  while (unexplainedPlaces.length > 0 && chosenFindings.length < maxCount) {
    const remainingFindings = findings.map((finding) => {
      const newPlaces = finding.places.filter((i) => unexplainedPlaces.includes(i));
      return { ...finding, places: finding.isIndivisible && newPlaces.length < finding.places.length ? [] : newPlaces };
    });
    const maxPlaces = Math.max(0, ...remainingFindings.map((finding) => finding.places.length));
    const best = remainingFindings.find((finding) => finding.places.length === maxPlaces);
    if (maxPlaces === 0 || !best) break;
    chosenFindings.push(best);
    unexplainedPlaces = unexplainedPlaces.filter((i) => !best.places.includes(i));
  }
  return { chosenFindings, unexplainedPlaces };
}

/** Report columns that contain only zeros where something else is expected. */
function findMissingColumns({ entries, wrongIndices }: WrongAnswer, { columns }: ValuesKey): Finding[] {
  if (columns < 2) return [];
  const entriesInColumn = (c: number) => entries.filter((_, i) => i % columns === c);
  return [...new Set(wrongIndices.map((i) => i % columns))]
    .filter((c) => entriesInColumn(c).every(isZero))
    .map((c) => ({
      places: wrongIndices.filter((i) => i % columns === c),
      isIndivisible: true,
      report: () => message("slip.column-left-out", { column: c + 1 }),
    }));
}

const isZero = ({ kind, value }: Node): boolean => kind === "number" && value === 0;

/** Tolerance for coefficients with six digits, relative to the largest of the expected value and the missing terms. */
const SIX_DIGITS = 1e-5;
/** The absence of a symbol's terms is noticed only if they are this many times the tolerance. */
const MIN_CHANGE_IN_TOLERANCES = 100;

/**
 * Ways in which all terms with a rate, velocity or force may be wrong. With the slip, an entry differs from the
 * expected one as if the symbol's value x were smaller by `change(x)`. `isPresent`: whether the wrong entry contains
 * the symbol.
 */
const SYMBOL_SLIPS = [
  { kind: "slip.symbol-missing", change: (x: number) => x, isPresent: false },
  { kind: "slip.symbol-sign", change: (x: number) => 2 * x, isPresent: true },
  { kind: "slip.symbol-left-out", change: (x: number) => x - 1, isPresent: false },
] as const;

/** Report slips in all terms with one symbol, which is a factor of these terms. */
function findSymbolSlips(
  answer: WrongAnswer,
  key: ValuesKey,
): { readonly missingTerms: Finding[]; readonly otherFindings: Finding[] } {
  const linear = Object.entries(key.linear ?? {});
  const findings = SYMBOL_SLIPS.map(({ kind, change, isPresent }) => {
    const places = new Map<string, number[]>();
    for (const i of answer.wrongIndices) {
      const usedNames = findNames(answer.entries[i] as Node);
      const candidates = linear.filter(
        ([symbol, factors]) => usedNames.has(symbol) === isPresent && factors[i]?.some(Boolean),
      );
      // all of several symbols, or one of them
      const singleCandidates = candidates.length > 1 ? candidates.map((candidate) => [candidate]) : [];
      for (const symbols of [candidates, ...singleCandidates])
        if (symbols.length > 0 && lacksTermsWith(answer, i, key, symbols, change)) {
          const what = symbols.map(([symbol]) => symbol).join(", ");
          places.set(what, [...(places.get(what) ?? []), i]);
        }
    }
    return [...places].map(([what, symbolPlaces]) => ({
      places: symbolPlaces,
      isIndivisible: false,
      report: (where: Message) => message(kind, { where, what }),
    }));
  });
  const [missingTerms = [], ...otherFindings] = findings; // in the order of SYMBOL_SLIPS
  return { missingTerms, otherFindings: otherFindings.flat() };
}

/** A symbol, and its factor in each entry at the first configurations, as in `ValuesKey.linear`. */
type SymbolFactors = readonly [symbol: string, factors: readonly (readonly number[])[]];
/** A function as `change` in SYMBOL_SLIPS. */
type ChangeOfValue = (x: number) => number;

/** Return whether an entry differs from the expected one by exactly the change of its terms with some symbols. */
function lacksTermsWith(
  { entries, configurationAt }: WrongAnswer,
  index: number,
  key: ValuesKey,
  symbols: SymbolFactors[],
  changeOfValue: ChangeOfValue,
): boolean {
  const points = symbols[0]?.[1][index]?.length ?? 0;
  return Array.from({ length: points }, (_, k) => k).every((k) => {
    const expected = key.right[index]?.[k] ?? NaN;
    const contributions = symbols.map(
      ([symbol, factors]) => (factors[index]?.[k] ?? NaN) * changeOfValue(configurationAt(k)[symbol] ?? NaN),
    );
    const expectedDifference = contributions.reduce((sum, contribution) => sum + contribution, 0);
    const tolerance = SIX_DIGITS * Math.max(Math.abs(expected), ...contributions.map(Math.abs));
    const difference = expected - evaluate(entries[index] as Node, configurationAt(k)).re;
    return (
      Math.abs(expectedDifference) > MIN_CHANGE_IN_TOLERANCES * tolerance &&
      Math.abs(difference - expectedDifference) <= tolerance
    );
  });
}

function findSlipsAndMistakes(answer: WrongAnswer, key: ValuesKey): Finding[] {
  const { entries, wrongIndices, configurationAt } = answer;
  const mistakes = findMistakes(answer, key);
  if (wrongIndices.reduce((sum, i) => sum + countNodes(entries[i] as Node, MAX_ANSWER_SIZE + 1), 0) > MAX_ANSWER_SIZE)
    return mistakes;
  const repairs = buildRepairs(entries, configurationAt(0), key);
  const slipsByPlace = new Map(wrongIndices.map((i) => [i, findSlipsInEntry(answer, i, key, repairs)]));
  const slipByName = new Map([...slipsByPlace.values()].flatMap((slips) => [...slips]));
  const findingsOfKinds = (isIncluded: (kind: Kind) => boolean): Finding[] =>
    KINDS.filter(isIncluded).flatMap((kind) =>
      [...slipByName]
        .filter(([, slip]) => slip.kind === kind)
        .map(([name, { what }]) => ({
          places: wrongIndices.filter((i) => slipsByPlace.get(i)?.has(name)),
          isIndivisible: false,
          report: (where) => message(kind, what ? { where, what } : { where }),
        })),
    );
  return [
    ...findingsOfKinds((kind) => FIRST_KINDS.includes(kind)),
    ...mistakes,
    ...findingsOfKinds((kind) => !FIRST_KINDS.includes(kind)),
  ];
}

/** Report known mistakes that explain a column or row, all wrong entries outside one, or all wrong entries but one. */
function findMistakes({ wrongIndices, findMistakeIn }: WrongAnswer, { columns }: ValuesKey): Finding[] {
  const lineTests = [...wrongIndices.map((i) => (j: number) => i % columns === j % columns)];
  if (columns > 1)
    lineTests.push(...wrongIndices.map((i) => (j: number) => Math.floor(i / columns) === Math.floor(j / columns)));
  const groups = lineTests.flatMap((isInLine) => [
    wrongIndices.filter(isInLine),
    wrongIndices.filter((i) => !isInLine(i)),
  ]);
  const sets = [...groups, ...wrongIndices.map((i) => wrongIndices.filter((j) => j !== i))];
  const distinct = new Map(
    sets.filter(({ length }) => length > 0 && length < wrongIndices.length).map((places) => [places.join(), places]),
  );
  return [...distinct.values()].flatMap((places) => {
    const mistake = findMistakeIn(new Set(places));
    return mistake === undefined
      ? []
      : [{ places, isIndivisible: true, report: (where: Message) => ({ mistake, where }) }];
  });
}

/** Describe the places of entries: one entry, all wrong entries of a column, or a list. */
export function describePlaces(
  indices: readonly number[],
  wrongIndices: readonly number[],
  { rows, columns }: Pick<ValuesKey, "rows" | "columns">,
): Message {
  const places = indices.map((i) => locateEntry(i, columns));
  const firstPlace = places[0]!;
  const { row } = firstPlace;
  if (rows * columns === 1) return message("slip.answer");
  if (indices.length === 1) return columns === 1 ? message("slip.row", { row }) : message("slip.entry", firstPlace);
  const inColumn = wrongIndices.filter((i) => locateEntry(i, columns).column === firstPlace.column);
  if (columns > 1 && inColumn.join() === indices.join()) return message("slip.column", firstPlace);
  const placeTexts = places.map(({ row, column }) => (columns === 1 ? `${row}` : `(${row}, ${column})`));
  return message("slip.entries", { entries: placeTexts.join(", ") });
}

/** Return slips in an entry: the entry is right if any one of them is undone. The keys are kind and missing part. */
function findSlipsInEntry(
  answer: WrongAnswer,
  index: number,
  key: ValuesKey,
  repairs: Repairs,
): Map<string, EntrySlip> {
  const entry = answer.entries[index] as Node;
  const slips = new Map<string, EntrySlip>();
  const expected = key.right[index]?.[0];
  if (countNodes(entry, MAX_ENTRY_SIZE + 1) > MAX_ENTRY_SIZE || typeof expected !== "number") return slips;
  // a zero has no terms to which another could be added
  if (isZero(entry)) return slips.set("slip.zero", { kind: "slip.zero" });
  const collect = (changes: Iterable<Change>) => {
    for (const { kind, what = "", entry: changed } of changes) {
      const slip = `${kind} ${what}`;
      if (!slips.has(slip) && answer.isRight(index, changed)) slips.set(slip, { kind, what });
    }
  };
  collect(findSingleChanges(entry, expected, repairs));
  // if products add up to zero, two terms seem to be missing in the others
  if (slips.size === 0 && expected !== 0) collect(addTwoTerms(entry, expected, repairs));
  return slips;
}

/** The kind of a slip in an entry, and the missing part, if the kind reports it. */
type EntrySlip = { readonly kind: Kind; readonly what?: string };
