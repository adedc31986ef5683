// Numbers with a unit each, and vectors that count up to a factor.

import type { NumbersKey, ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { read } from "../read/reader.js";
import { asMatrix, hasBlank, namesIn, type Node, ReadError } from "../read/tree.js";
import { message } from "../text/text.js";
import { correct, graded, missing, unreadable, type Verdict, wrong } from "./verdict.js";
import { atText, isBlank, rightSide, unlabelled } from "./values.js";

/** Share by which a mistake's number, which is kept with six digits, may differ beside what the answer may. */
const KEPT = 1e-5;
const SAME = 1e-9;

/** Judge numbers, right within the key's tolerance. */
export function judgeNumbers(answer: string, key: NumbersKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  try {
    const entries = column(
      key.right.length === 1 ? withPoints(answer) : answer,
      key.right.length,
      new Set(),
      labels,
    );
    return "outcome" in entries ? entries : numbers(entries, key);
  } catch (error) {
    if (error instanceof ReadError) return unreadable(error.why);
    throw error;
  }
}

function column(
  answer: string,
  count: number,
  known: ReadonlySet<string>,
  labels: readonly string[],
): readonly Node[] | Verdict {
  const tree = unlabelled(rightSide(read(answer, known), known), labels);
  if (isBlank(tree)) return missing();
  const rows = asMatrix(tree);
  const row = rows[0] as Node[];
  const entries = rows.length === 1 ? row : rows.map((each) => each[0] as Node);
  if (entries.length === count && (rows.length === 1 || row.length === 1)) return entries;
  return wrong("read.shape", { found: `${rows.length} × ${row.length}`, due: `${count} × 1` });
}

function numbers(entries: readonly Node[], key: NumbersKey): Verdict {
  const symbols = new Set(entries.flatMap((entry) => [...namesIn(entry)]));
  if (symbols.size > 0) return wrong("read.numbers", { names: [...symbols].sort().slice(0, 5).join(", ") });
  const mine = entries.map((entry) => (hasBlank(entry) ? NaN : real(entry)));
  const near = (value: number, due: number, more = 0) =>
    Math.abs(value - due) <= Math.max((key.tolerance + more) * Math.abs(due), key.floor);
  const right = mine.map((value, i) => near(value, key.right[i] as number));
  if (right.every(Boolean)) return correct(message("verdict.numbers", { percent: 100 * key.tolerance }));
  const first = right.indexOf(false);
  const reason = message("verdict.number", {
    index: first + 1,
    yours: Number.isFinite(mine[first]) ? (mine[first] as number) : "—",
    expected: Number((key.right[first] as number).toPrecision(4)),
  });
  const found = key.mistakes.find(([, ...theirs]) =>
    theirs.every((value, i) => near(mine[i] as number, value, KEPT)),
  );
  return graded(right.filter(Boolean).length / right.length, [reason], {
    entries: right.map((ok) => [ok]),
    ...(found ? { mistake: found[0] as number } : {}),
  });
}

function real(entry: Node): number {
  const { re, im, size } = evaluate(entry, {});
  return Math.abs(im) <= SAME * size ? re : NaN;
}

/** Judge a vector that is right where it is the reference times any factor other than zero. */
export function judgeDirection(answer: string, key: ValuesKey, labels: readonly string[] = []): Verdict {
  if (!answer.trim()) return missing();
  try {
    const entries = column(answer, key.rows, new Set(key.symbols), labels);
    if ("outcome" in entries) return entries;
    if (entries.some(hasBlank)) return missing();
    return along(entries, key);
  } catch (error) {
    if (error instanceof ReadError) return unreadable(error.why);
    throw error;
  }
}

function along(entries: readonly Node[], key: ValuesKey): Verdict {
  const room = key.tolerance ?? 1e-8;
  let isZero = true;
  for (const point of key.points) {
    const k = key.points.indexOf(point);
    const at = Object.fromEntries(key.symbols.map((symbol, i) => [symbol, point[i] as number]));
    const mine = entries.map((entry) => evaluate(entry, at).re);
    const due = key.right.map((values) => values[k] ?? NaN);
    const size = Math.hypot(...mine);
    if (size > 1e-12) isZero = false;
    if (!(apart(mine, due) <= room)) {
      return isZero && size <= 1e-12 ? wrong("verdict.zero-vector") : differs(entries, at);
    }
  }
  return correct(message("verdict.direction"));
}

function differs(entries: readonly Node[], at: Readonly<Record<string, number>>): Verdict {
  const used = [...new Set(entries.flatMap((entry) => [...namesIn(entry)]))]
    .filter((symbol) => symbol in at)
    .sort();
  const shown = Object.fromEntries(used.map((symbol) => [symbol, at[symbol] as number]));
  return graded(0, [message("verdict.not-along", { at: atText(shown) })], { at: shown });
}

/** The length of the difference of two unit vectors, the sign of one chosen so that it is least. */
function apart(a: readonly number[], b: readonly number[]): number {
  const unit = (v: readonly number[]) => v.map((x) => x / Math.hypot(...v));
  const [u, v] = [unit(a), unit(b)];
  const minus = Math.hypot(...u.map((x, i) => x - (v[i] as number)));
  return Math.min(minus, Math.hypot(...u.map((x, i) => x + (v[i] as number))));
}
