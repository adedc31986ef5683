// Read a text as the answer to a part, in the form that the notebook's metadata describe, without the correct answer.
// As ../../../grader/grading/check.py does; ../../tests/check.test.ts compares both.

import { readWithCommas } from "../grade/judge.js";
import { readLetters } from "../grade/letters.js";
import { readFormulas, findUnknownSymbols } from "../grade/values.js";
import { isBlank } from "../grade/forms.js";
import { readNumbers } from "../grade/numbers.js";
import { readConditions } from "../grade/sets.js";
import { isVerdict, missing, parseOrVerdict, type Verdict, wrong } from "../grade/verdict.js";
import { parse } from "../read/reader.js";
import { findNames, hasBlank, listOf, name, type Node, node, type Rows } from "../read/tree.js";
import { typesetTree } from "../read/typeset.js";
import { parseUnit } from "../read/units.js";
import { compile } from "../read/vocabulary.js";
import type { Message } from "../text/text.js";

/** The form of the expected answer, and the names that it may contain. */
export interface Form {
  readonly type:
    "expression" | "matrix" | "direction" | "number" | "singular" | "choice" | "selection" | "matching" | "text";
  readonly symbols: readonly string[];
  readonly joints: readonly string[];
  readonly rows: number;
  readonly columns: number;
  /** The unit of each number, "" if it has none. */
  readonly units: readonly string[];
  /** Names of entries, and of a matrix's columns. */
  readonly labels: readonly string[];
  readonly columnNames: readonly string[];
  /** The power of metres that is the unit of a determinant; null for other answers. */
  readonly metres: number | null;
  /** The texts of the options, "" for those in a figure; and what is matched with them. */
  readonly options: readonly string[];
  readonly items: readonly string[];
}

/** How a text is read. */
export type Reading =
  | { readonly kind: "formula"; readonly latex: string; readonly isPartlyBlank: boolean }
  /** The indices of the chosen options, from 0. */
  | { readonly kind: "letters"; readonly chosen: readonly number[] }
  /** A text that a person marks. */
  | { readonly kind: "words" }
  | { readonly kind: "blank" }
  | { readonly kind: "refused"; readonly why: Message };

/** Return how a text is read as an answer; `form` is null if it is unknown. */
export function readAnswer(text: string, form: Form | null): Reading {
  if (!text.trim()) return { kind: "blank" };
  if (form?.type === "text") return isEmptyText(text) ? { kind: "blank" } : { kind: "words" };
  if (form && ["choice", "selection", "matching"].includes(form.type)) return readChoice(text, form);
  const tree = parseOrVerdict(() => readTree(text, form));
  if (!isVerdict(tree))
    return { kind: "formula", latex: typeset(tree, form), isPartlyBlank: form?.type !== "singular" && hasBlank(tree) };
  return tree.outcome === "missing" ? { kind: "blank" } : { kind: "refused", why: tree.reasons[0]! };
}

const isEmptyText = (text: string): boolean =>
  ["", "blank", "ellipsis", "none"].includes(
    text
      .trim()
      .replace(/^["']+|["']+$/g, "")
      .trim(),
  );

function readChoice(text: string, { type, options, items }: Form): Reading {
  const letters = readLetters(
    text,
    { type: type as "choice", options: options.length, items: items.length },
    type === "choice" ? options : [],
  );
  if (!isVerdict(letters)) return { kind: "letters", chosen: letters };
  return letters.outcome === "missing" ? { kind: "blank" } : { kind: "refused", why: letters.reasons[0]! };
}

/** Cubic metres at the end of a formula, which the reader would remove as metres. */
const CUBIC_METRES = compile(
  "(?<![\\w])(?:m|\\\\mathrm\\{m\\}|\\\\text\\{m\\})(?:\\^\\(?3\\)?|\\^\\{3\\}|³|\\*\\*3)[\\])]?[ .$]{0,9}$",
);

/** Return the tree of an answer of formulas, numbers or conditions. Throws ParseError. */
function readTree(text: string, form: Form | null): Node | Verdict {
  if (form === null) {
    const tree = parse(text, new Set());
    return isBlank(tree) ? missing() : tree;
  }
  if (form.type === "singular") {
    const conditions = readConditions(text, form);
    return isVerdict(conditions) ? conditions : conditions.tree;
  }
  if (form.type === "number") {
    const numbers = readNumbers(text, form.units, form.labels);
    return isVerdict(numbers) ? numbers : joinRows(numbers.map(([entry], i) => [addUnit(entry!, form.units[i]!)]));
  }
  if (form.metres !== null && form.metres !== 3 && CUBIC_METRES.test(text))
    return wrong("read.unit-left", { unit: "m^3" });
  const rows = readWithCommas<Rows>(text, form.type !== "direction", (typed) =>
    readFormulas(typed, form, form.labels, form.columnNames),
  );
  if (isVerdict(rows)) return rows;
  const why = findUnknownSymbols(findNames(...rows.flat()), form);
  return why ? wrong(why.key, why.values) : joinRows(rows);
}

/** Return the only entry, or the list of rows. */
const joinRows = (rows: Rows): Node => (rows.length === 1 && rows[0]?.length === 1 ? rows[0][0]! : listOf(rows));

/** Return a number with its unit as a factor. */
function addUnit(entry: Node, unit: string): Node {
  if (!unit || hasBlank(entry)) return entry;
  return entry.kind === "neg" ? node("neg", node("*", entry.args[0]!, name(unit))) : node("*", entry, name(unit));
}

function typeset(tree: Node, form: Form | null): string {
  const symbols = (form?.symbols ?? []).map((symbol) => [symbol, writeSymbol(symbol, form!.joints)]);
  const units = (form?.units ?? [])
    .filter((unit) => parseUnit(unit) !== null)
    .map((unit) => [unit, `\\mathrm{${unit.replace(/\^(-?\d+)/g, "^{$1}")}}`]);
  const entries = [...symbols, ...units].map(([key, latex]) => [key, { role: "length", unit: "", latex }]);
  return typesetTree(tree, Object.fromEntries(entries));
}

/** Return the LaTeX of a symbol: \dot{d}_{2} for qd2 if joint 2 is prismatic. */
function writeSymbol(symbol: string, joints: readonly string[]): string {
  const [, letter = "", index = ""] = /^(theta|alpha|beta|qdd?|[a-zA-Z])(\d*|[xyz])$/.exec(symbol) ?? [];
  if (!letter) return `\\mathrm{${symbol}}`;
  const isRate = letter.startsWith("qd");
  const joint = joints.includes(`d${index}`) ? "d" : "\\theta";
  const shownLetter = isRate
    ? `\\${letter === "qd" ? "dot" : "ddot"}{${joint}}`
    : letter === "w" && /[xyz]/.test(index)
      ? "\\omega"
      : letter.length > 1
        ? `\\${letter}`
        : letter;
  return index ? `${shownLetter}_{${index}}` : shownLetter;
}
