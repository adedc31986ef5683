// Numbers with a unit each, and vectors that count up to a factor.

import { dot } from "../arm/vector.js";
import type { NumbersKey, ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { read } from "../read/reader.js";
import { kindOfUnit, unitsOfNumbers } from "../read/notation.js";
import { numbersText, tableText } from "../read/tables.js";
import { hasBlank, namesIn, type Node } from "../read/tree.js";
import { message } from "../text/text.js";
import { shareButForFactor, shareOfEntries } from "./credit.js";
import { EXACT, slipsInNumbers } from "./number-slips.js";
import { correct, graded, ifRead, missing, type Verdict, wrong } from "./verdict.js";
import { entriesOf, labelOf, readAs } from "./forms.js";
import { agreed, atText, configuration, unknownSymbols, weight } from "./values.js";

const NONE: ReadonlySet<string> = new Set();
const SAME = 1e-9;
/** A part below this share of a number is rounding. */
const ZERO = 1e-12;

/** Judge numbers, right within the key's tolerance. */
export function judgeNumbers(answer: string, key: NumbersKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const unit = otherUnit(answer, labels, key.units);
  if (unit) return unit;
  const count = key.right.length;
  const found = readAs(
    (text) => entriesOf(read(text, NONE), { rows: count, columns: 1 }, NONE, labels),
    count === 1 ? withPoints(answer) : answer,
    () => numbersText(answer, count),
  );
  return "outcome" in found ? found : ifRead(() => numbers(found.flat(), key, answer));
}

/** The verdict on a unit that can't be right where it stands: a length in place of an angle; null where all can. */
function otherUnit(text: string, labels: readonly string[], units: readonly string[]): Verdict | null {
  const inner = text.trim().replace(/^[[\](){}]+|[[\](){}]+$/g, "");
  const mark = [";", "\n"].find((each) => inner.includes(each)) ?? ",";
  const marksIn = (part: string): number => part.split(mark).length - 1;
  const called = labels.map(labelOf);
  for (const { name, unit, start } of unitsOfNumbers(inner)) {
    const inOrder = marksIn(inner) + 1 === units.length ? marksIn(inner.slice(0, start)) : -1;
    const place = called.includes(labelOf(name)) ? called.indexOf(labelOf(name)) : inOrder;
    const due = place < 0 ? units : units.slice(place, place + 1);
    const kinds = new Set(due.map(kindOfUnit));
    const kind = kindOfUnit(unit);
    if (due.length === 0 || kinds.has("") || kind === "" || kinds.has(kind)) continue;
    return place >= 0 && units.length > 1
      ? wrong("read.unit-of-entry", { unit, entry: place + 1, due: due[0] as string })
      : wrong("read.unit", { unit, due: due[0] as string });
  }
  return null;
}

function numbers(entries: readonly Node[], key: NumbersKey, text: string): Verdict {
  const symbols = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  if (symbols.size > 0) return wrong("read.numbers", { names: [...symbols].sort().slice(0, 5).join(", ") });
  const mine = entries.map((entry) => (hasBlank(entry) ? NaN : real(entry)));
  const near = (value: number, due: number) =>
    Math.abs(value - due) <= Math.max(key.tolerance * Math.abs(due), key.floor);
  const right = mine.map((value, i) => near(value, key.right[i] as number));
  if (right.every(Boolean))
    return correct(key.tolerance < EXACT ? undefined : message("verdict.numbers", { percent: 100 * key.tolerance }));
  const first = right.indexOf(false);
  const reason = message("verdict.number", {
    index: first + 1,
    yours: Number.isFinite(mine[first]) ? (mine[first] as number) : "—",
    expected: Number((key.right[first] as number).toPrecision(4)),
  });
  const zeros = key.right.map((due) => Math.abs(due) <= key.floor);
  const isButForSigns =
    right.length > 1 &&
    !zeros.every(Boolean) &&
    key.units.every(Boolean) &&
    mine.every((value, i) => near(value, key.right[i] as number) || near(-value, key.right[i] as number));
  const byEntries = shareOfEntries(right, zeros, entries.map(hasBlank));
  const share = isButForSigns ? Math.max(byEntries, shareButForFactor(1)) : byEntries;
  return graded(share, isButForSigns ? [message("verdict.but-signs"), reason] : [reason], {
    entries: right.map((ok) => [ok]),
    ...slipsInNumbers(mine, right, key, text),
  });
}

function real(entry: Node): number {
  const { re, im, size } = evaluate(entry, {});
  return Math.abs(im) <= SAME * size ? re : NaN;
}

/** Judge a vector that is right where it is the reference times any factor other than zero. */
export function judgeDirection(answer: string, key: ValuesKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  const known = new Set(key.symbols);
  const entriesIn = (text: string) => entriesOf(read(text, known), key, known, labels);
  const found = readAs(entriesIn, answer, () => tableText(answer, key.rows, 1));
  if ("outcome" in found) return found;
  return found.flat().some(hasBlank) ? missing() : ifRead(() => along(found.flat(), key));
}

function along(entries: readonly Node[], key: ValuesKey): Verdict {
  const names = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  if (typeof key.tolerance === "number") return alongNumbers(entries, names, key, key.tolerance);
  const found = key.points.map((_, k) => {
    const at = configuration(key, k, names);
    return entries.map((entry) => evaluate(entry, at));
  });
  if (found.every((values) => values.every(({ re, im, size }) => Math.hypot(re, im) <= ZERO * size)))
    return wrong("verdict.zero-vector");
  const off = found.findIndex((values, k) => {
    const due = key.right.map((each) => each[k] ?? NaN);
    const room = SAME * Math.max(...values.map(({ size }) => size));
    if (!Number.isFinite(room)) return true;
    const isAlong = (part: "re" | "im") =>
      aside(
        values.map((each) => each[part]),
        due,
      ) <= room;
    return !isAlong("re") || !isAlong("im");
  });
  if (off < 0) return agreed(entries, message("verdict.direction"), found);
  const unknown = unknownSymbols(names, key);
  if (unknown) return graded(0, [unknown]);
  const vectors = found.map((values) => values.map(({ re, im }) => (im === 0 ? re : NaN)));
  const mistake = key.mistakes.find(([, ...theirs]) =>
    theirs.every((their, k) => Math.abs(printOf(vectors[k] ?? []) - their) <= PRINT * Math.max(their, PRINT_FROM)),
  );
  return named(differs(names, configuration(key, off, new Set())), mistake);
}

/** Share by which the print of a direction, which is kept with six digits, may differ, of that or of this at least. */
const PRINT = 1e-5;
const PRINT_FROM = 0.1;

/** What tells a direction from others, whatever its length: as in ../../../exercises/site/keys.py. */
const printOf = (vector: readonly number[]): number =>
  Math.abs(vector.reduce((sum, each, i) => sum + weight(i) * each, 0)) / Math.hypot(...vector);

const named = (verdict: Verdict, mistake: readonly number[] | undefined): Verdict =>
  mistake ? { ...verdict, mistake: mistake[0] as number } : verdict;

/** Numbers, whose direction may be off by `tolerance`. */
function alongNumbers(
  entries: readonly Node[],
  names: ReadonlySet<string>,
  key: ValuesKey,
  tolerance: number,
): Verdict {
  if (names.size > 0) return wrong("read.numbers", { names: [...names].sort().slice(0, 5).join(", ") });
  const mine = entries.map((entry) => evaluate(entry, {}));
  const due = key.right.map((values) => values[0] ?? NaN);
  const isReal = mine.every(({ re, im }) => Number.isFinite(re) && Math.abs(im) <= ZERO * Math.hypot(re, im));
  const size = Math.hypot(...mine.map(({ re }) => re));
  if (isReal && size === 0) return wrong("verdict.zero-vector");
  const unit = mine.map(({ re }) => re / size);
  if (isReal && apart(unit, due) <= tolerance) return correct(message("verdict.direction"));
  // in a plane many directions are as near to some mistake's
  const mistakes = isReal && unit.length > 2 ? key.mistakes : [];
  const mistake = mistakes.find(([, ...theirs]) => apart(unit, theirs) <= tolerance);
  return named(differs(names, configuration(key, 0, new Set())), mistake);
}

function differs(names: ReadonlySet<string>, at: Readonly<Record<string, number>>): Verdict {
  const used = [...names].filter((symbol) => symbol in at).sort();
  const shown = Object.fromEntries(used.map((symbol) => [symbol, at[symbol] as number]));
  if (used.length === 0) return wrong("verdict.other-direction");
  return graded(0, [message("verdict.not-along", { at: atText(shown) })], { at: shown });
}

/** How far a vector leads off the line of another. */
function aside(v: readonly number[], line: readonly number[]): number {
  const share = dot(v, line) / dot(line, line);
  return Math.hypot(...v.map((x, i) => x - share * (line[i] as number)));
}

/** The length of the difference of two unit vectors, the sign of one chosen so that it is least. */
function apart(unit: readonly number[], due: readonly number[]): number {
  const length = Math.hypot(...due);
  const away = (sign: number) => Math.hypot(...unit.map((x, i) => x - (sign * (due[i] as number)) / length));
  return Math.min(away(1), away(-1));
}
