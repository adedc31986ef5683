// The forms that an answer may have: entries in a shape, with names before them or without, or a formula.

import type { Part, ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { read } from "../read/reader.js";
import { numbersText, tableText } from "../read/tables.js";
import {
  anyNode,
  asMatrix,
  CHAIN,
  chainOf,
  columnsOf,
  hasBlank,
  inRows,
  listOf,
  namesIn,
  type Node,
  node,
  ReadError,
  type Rows,
} from "../read/tree.js";
import { table, VOCABULARY, whole } from "../read/vocabulary.js";
import { ifRead, missing, type Verdict, wrong } from "./verdict.js";

type Names = readonly string[];
type Known = ReadonlySet<string>;
/** The rows and columns that are expected. */
export type Shape = Pick<ValuesKey, "rows" | "columns">;

/** What is read, or the verdict on what can't be; what is of another shape may be a table without commas. */
export function readAs(
  read: (text: string) => Rows | Verdict,
  text: string,
  tableIn: () => string | null,
): Rows | Verdict {
  const found = ifRead(() => read(text));
  if (!("outcome" in found) || found.outcome === "missing") return found;
  const table = tableIn();
  return table === null ? found : ifRead(() => read(table));
}

/** The entries of a vector or matrix that was read, or the verdict on what is none of this shape. Throws ReadError. */
export function entriesOf(tree: Node, shape: Shape, known: Known, labels: Names, vectors: Names = []): Rows | Verdict {
  if (isBlank(tree)) return missing();
  const rows = shaped(matrixOf(tree, known, labels, shape, vectors), shape);
  return "outcome" in rows ? rows : ofScalars(rows);
}

/** Rows without lists or statements among their entries, but for those that were left blank. Throws ReadError. */
export function ofScalars(rows: Rows): Rows {
  for (const entry of rows.flat()) if (!hasBlank(entry)) anyNode(entry, isStatement);
  return rows;
}

const SCALARS = new Set(["number", "decimal", "name", "call", "neg", "+", "-", "*", "/", "^"]);

function isStatement(tree: Node): boolean {
  if (!SCALARS.has(tree.kind)) evaluate(tree, {}); // which throws, and says what it is
  return false;
}

/** The entries of a matrix; `labels` name entries, `vectors` columns. Throws ReadError for an unordered set. */
export function matrixOf(typed: Node, known: Known, labels: Names, shape: Shape, vectors: Names = []): Node[][] {
  const { rows, columns } = shape;
  const tree = rightSide(spread(typed, [...labels, ...vectors]), known);
  const isOrdered = ({ kind }: Node) => ["eq", "pair", "set", "list"].includes(kind);
  if (tree.kind === "set" && tree.args.length > 1 && !tree.args.some(isOrdered)) throw new ReadError("read.no-order");
  return asMatrix(ofVectors(tree, labels, vectors, { rows, columns }) ?? unlabelled(tree, labels, { rows, columns }));
}

/** The matrix of v = […], ω = […] or of z0 = […], z1 = […], which may come in any order; null for anything else. */
function ofVectors(
  { kind, args }: Node,
  labels: Names,
  vectors: Names,
  { rows: count, columns: across }: Shape,
): Node | null {
  if (!["dict", "list", "set", "and"].includes(kind) || !args.every(nameBefore)) return null;
  const first = args[0] ? labelOf(nameBefore(args[0])).slice(0, 1) : "";
  const isCounted = vectors.length === 0 && across > 1 && (first === "j" || first === "s"); // J1, J2 or S1, S2
  const columns = isCounted ? Array.from({ length: across }, (_, i) => `${first}${i + 1}`) : vectors;
  const called = labels.map(labelOf);
  const halves = [COMPONENTS, [...COMPONENTS.slice(3), ...COMPONENTS.slice(0, 3)]];
  const isTwist = halves.some((each) => each.join() === called.join());
  const due = isTwist ? [0, 3].map((i) => (called[i] as string)[0] as string) : columns.map(labelOf);
  const said = new Map(args.map((arg) => [labelOf(nameBefore(arg)), vectorOf(arg.args[1] as Node)]));
  const found = due.map((name) => said.get(name) ?? []);
  const isAll = due.length > 0 && args.length === due.length && said.size === due.length;
  if (!isAll || found.some(({ length }) => length * (isTwist ? 2 : 1) !== count)) return null;
  if (isTwist) return node("list", ...found.flat());
  return listOf(columnsOf(found));
}

/** z0 = z1 = a, of names that are `due`, as z0 = a, z1 = a, also in a list. */
function spread(tree: Node, due: readonly string[]): Node {
  if (!["and", "list", "set"].includes(tree.kind)) return tree;
  const called = due.map(labelOf);
  const isChain = tree.kind === "and" && tree.text === CHAIN;
  const found = (isChain ? [tree] : tree.args).flatMap((each) => {
    const sides = chainOf(each);
    const left = sides.slice(0, -1);
    const isDue = ({ kind, text }: Node): boolean => kind === "name" && called.includes(labelOf(text));
    return left.length > 0 && left.every(isDue) ? left.map((one) => node("eq", one, sides.at(-1) as Node)) : [each];
  });
  return isChain && found.length === 1 ? tree : node(tree.kind, ...found);
}

/** The name before an entry; S1 before one is no sine. Nothing where there is none. */
function nameBefore(tree: Node): string {
  if (tree.kind !== "pair" && tree.kind !== "eq") return "";
  const [{ kind, text, args }] = tree.args as readonly [Node];
  const [angle] = args;
  if (kind === "call" && text === "sin" && angle?.kind === "name") return angle.text.replaceAll("theta", "s");
  return isNamed(tree) ? text : "";
}

/** The entries of a row or column; nothing of what is none. */
function vectorOf({ kind, args }: Node): readonly Node[] {
  const rows = kind === "list" ? args : [];
  const entries = rows.map((row) => (row.kind === "list" && row.args.length === 1 ? (row.args[0] as Node) : row));
  return entries.some((entry) => entry.kind === "list") ? [] : entries;
}

/** How an answer of a shape is typed: [a, b], or [[a, b], [c, d]]. */
function typedAs(rows: number, columns: number): string {
  const letters = [..."abcdefghi"];
  if (Math.max(rows, columns) > 3) return columns === 1 ? "[a, …, b]" : "[[a, …, b], …, [c, …, d]]";
  const listed = Array.from({ length: rows }, () => letters.splice(0, columns).join(", "));
  return `[${(columns === 1 ? listed : listed.map((row) => `[${row}]`)).join(", ")}]`;
}

export function shaped(rows: Node[][], key: Shape): Rows | Verdict {
  const row = rows[0] as Node[];
  if (key.columns === 1 && rows.length === 1 && row.length === key.rows) return row.map((entry) => [entry]);
  if (rows.length === key.rows && row.length === key.columns) return rows;
  return wrong("read.shape", {
    found: `${rows.length} × ${row.length}`,
    due: `${key.rows} × ${key.columns}`,
    typed: typedAs(key.rows, key.columns),
  });
}

/** The tree of an answer to a part as it is judged: of a table where the text is of another shape. Throws ReadError. */
export function readDue(text: string, known: ReadonlySet<string>, { key, shape }: Part): Node {
  const [rows, columns] = shape ?? [1, 1];
  if (rows * columns === 1 || !["values", "numbers", "direction"].includes(key.type)) return read(text, known);
  const table = key.type === "numbers" ? numbersText(text, rows) : tableText(text, rows, columns);
  const found = ifRead(() => shaped(asMatrix(rightSide(read(text, known), known)), { rows, columns }));
  return read("outcome" in found ? (table ?? text) : text, known);
}

/** What J is from "J = …", "… = J" or "det: …": of a name of the student's own, or the only one of `labels`. */
export function rightSide(typed: Node, known: ReadonlySet<string>, labels: readonly string[] = []): Node {
  const tree = typed.kind === "dict" && typed.args.length === 1 ? (typed.args[0] as Node) : typed;
  const sides = tree.kind === "pair" ? tree.args : chainOf(tree); // det J = J11*J22 - J12*J21 = …
  const [left, right] = [sides[0], sides.at(-1)];
  const isOfSymbols = (side: Node) => [...namesIn(side)].some((each) => known.has(each));
  // det J = a1*a2*sin(theta2) = 0
  if (!left || !right || (namesIn(right).size === 0 && sides.slice(1, -1).some(isOfSymbols))) return typed;
  const isOwn = (name: Node) =>
    (isCalled(name) || isOfEntries(name)) && ![...namesIn(name)].some((each) => known.has(each));
  const isAsked = (name: Node) =>
    name.kind === "name" && labels.length === 1 && labelOf(name.text) === labelOf(labels[0] as string);
  if (isOwn(left) || isAsked(left)) return right;
  return isOwn(right) || isAsked(right) ? left : typed;
}

/** The components of a velocity, and of an angular one. */
const LINEAR = ["vx", "vy", "vz"];
const COMPONENTS = [...LINEAR, "wx", "wy", "wz"];

/** The name before a formula, where it is that of another component of a velocity than the one asked. */
export function otherComponent(typed: Node, labels: readonly string[]): string {
  const [label] = labels;
  if (label === undefined || labels.length !== 1 || !LINEAR.includes(labelOf(label))) return "";
  let tree = typed;
  while (["list", "set", "dict"].includes(tree.kind) && tree.args.length === 1) tree = tree.args[0] as Node;
  const [left] = tree.args;
  if ((tree.kind !== "eq" && tree.kind !== "pair") || left?.kind !== "name") return "";
  const name = labelOf(left.text);
  return COMPONENTS.includes(name) && name !== labelOf(label) ? left.text : "";
}

/** Whether a formula is one of entries of the Jacobian, J11*J22 - J12*J21. */
function isOfEntries(tree: Node): boolean {
  const called = [...namesIn(tree)];
  return called.length > 0 && called.every((each) => /^[jJ]_?[1-6]{2}$/.test(each));
}

/** Whether words stand there, dx/dq, |J|, or the power of a name: The determinant, J^-1. */
function isCalled(tree: Node): boolean {
  let top = tree.kind === "call" && tree.text === "abs" ? (tree.args[0] as Node) : tree;
  while ((top.kind === "*" || top.kind === "/") && top.args[1]?.kind === "name") top = top.args[0] as Node;
  return top.kind === "name" || (top.kind === "^" && top.args[0]?.kind === "name");
}

const isNamed = ({ kind, args }: Node): boolean => (kind === "pair" || kind === "eq") && args[0]?.kind === "name";
const isLabelled = (tree: Node): boolean =>
  isNamed(tree) || (tree.kind === "list" && tree.args.length === 2 && tree.args[0]?.kind === "name");

/** The entries of {qd1: …}, [qd1 = …] or [(qd1, …)] in the order of the labels. Names may also be row1 or J12. */
function unlabelled(tree: Node, labels: readonly string[], { rows, columns }: Shape): Node {
  const inner = tree.args[0];
  if (tree.args.length === 1 && inner && (tree.kind === "list" || tree.kind === "set")) {
    const isInner = tree.kind === "set" || inner.args.every(isNamed);
    if (inner.kind === "dict" || (inner.kind === "list" && isInner))
      return unlabelled(inner, labels, { rows, columns });
  }
  if (!["dict", "list", "set", "and"].includes(tree.kind) || !tree.args.every(isLabelled)) return tree;
  const said = tree.args.map((arg) => labelOf(arg.args[0]?.text ?? ""));
  const twice = said.findIndex((label, i) => said.lastIndexOf(label) !== i);
  const areNamed = tree.args.every(isNamed);
  if (twice >= 0 && areNamed) throw new ReadError("read.twice", { name: tree.args[twice]?.args[0]?.text ?? "" });
  if (twice >= 0) return tree; // rows of a matrix may begin alike
  const called = (due: readonly string[]): readonly Node[] | null =>
    due.length > 0 && said.length === new Set(due).size && due.every((each) => said.includes(each))
      ? due.map((each) => tree.args[said.indexOf(each)]?.args[1] as Node)
      : null;
  const asRows = Array.from({ length: rows }, (_, i) => `row${i + 1}`);
  const ordered = called(labels.map(labelOf)) ?? called(asRows);
  if (ordered) return node("list", ...ordered);
  const byEntry = called(
    Array.from({ length: rows * columns }, (_, k) => `j${Math.floor(k / columns) + 1}${(k % columns) + 1}`),
  );
  if (byEntry) return listOf(inRows(byEntry, columns));
  if (said.length > 0 && areNamed) throw new ReadError("read.names", { names: said.slice(0, 5).join(", ") });
  return tree;
}

const VELOCITIES = table(VOCABULARY.velocities);
const POINT_OF_ENTRY = whole("point_of_entry");

/** The name of an entry as it is compared: of P_x, p_x, px and x the last; v_x and x_dot are vx, ω_x is wx. */
export function labelOf(name: string): string {
  const joined = name.replaceAll("_", "").toLowerCase();
  let plain = VELOCITIES.get(joined) ?? joined;
  for (const [spelled, letter] of Object.entries(VOCABULARY.spelled)) plain = plain.replaceAll(spelled, letter);
  const entry = POINT_OF_ENTRY.exec(plain)?.[1];
  return entry ?? (plain.length > 1 && plain.startsWith("p") ? plain.slice(1) : plain);
}

export function isBlank(tree: Node): boolean {
  if (tree.kind === "list" || tree.kind === "set") return tree.args.length > 0 && tree.args.every(isBlank);
  return tree.kind === "blank";
}
