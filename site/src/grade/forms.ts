// The forms of an answer: entries in a shape, with or without names, or a formula.

import { type AskedPart, ROWS, type ValuesKey } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { parse } from "../read/reader.js";
import { convertNumbers, convertTable } from "../read/tables.js";
import type { Node, Rows } from "../read/tree.js";
import {
  asMatrix,
  CHAIN,
  listSides,
  transposeRows,
  hasBlank,
  hasNameOf,
  splitIntoRows,
  isConstant,
} from "../read/tree.js";
import { isListOrSet, listOf, findNames, node, ParseError, visitNodes } from "../read/tree.js";
import { respell, VOCABULARY, wholePattern } from "../read/vocabulary.js";
import { isVerdict, missing, parseOrVerdict, type Verdict, wrong } from "./verdict.js";

/** The parsed entries, or the verdict on an answer that has no such entries. */
type RowsOrVerdict = Rows | Verdict;
type Names = readonly string[];
type Symbols = ReadonlySet<string>;
/** The expected rows and columns. */
type Shape = Pick<ValuesKey, "rows" | "columns">;

/** Return the parsed rows or a verdict; if the shape is wrong, parse the text that `convert` makes of a table, if any. */
export function parseRowsOrTable(
  parse: (text: string) => RowsOrVerdict,
  text: string,
  convert: () => string | null,
): RowsOrVerdict {
  const rowsOrVerdict = parseOrVerdict(() => parse(text));
  if (!isVerdict(rowsOrVerdict) || rowsOrVerdict.outcome === "missing") return rowsOrVerdict;
  const convertedText = convert();
  return convertedText === null ? rowsOrVerdict : parseOrVerdict(() => parse(convertedText));
}

/** Return the entries of a vector or matrix, or a verdict if it has another shape. Throws ParseError. */
export function extractEntries(
  tree: Node,
  shape: Shape,
  symbols: Symbols,
  labels: Names,
  columnNames: Names = [],
): RowsOrVerdict {
  if (isBlank(tree)) return missing();
  const rowsOrVerdict = checkShape(buildMatrix(tree, symbols, labels, shape, columnNames), shape);
  return isVerdict(rowsOrVerdict) ? rowsOrVerdict : requireScalars(rowsOrVerdict);
}

/** Return the rows if no entry is a list or statement; blank entries are allowed. Throws ParseError. */
export function requireScalars(rows: Rows): Rows {
  for (const entry of rows.flat()) if (!hasBlank(entry)) visitNodes(entry, refuseNonScalar);
  return rows;
}

const SCALAR_KINDS = new Set(["number", "decimal", "name", "call", "neg", "+", "-", "*", "/", "^"]);

/** Throw a ParseError if a node is a list or statement. */
function refuseNonScalar(tree: Node): void {
  if (!SCALAR_KINDS.has(tree.kind)) evaluate(tree, {}); // throws an error that names the kind
}

/** Return the entries of a matrix; `labels` name entries. Throws ParseError for an unordered set. */
export function buildMatrix(
  typed: Node,
  symbols: Symbols,
  labels: Names,
  shape: Shape,
  columnNames: Names = [],
): Node[][] {
  const { rows, columns } = shape;
  const tree = takeRightSide(splitChains(typed, [...labels, ...columnNames]), symbols);
  const hasOrder = ({ kind }: Node) => ["eq", "pair", "set", "list"].includes(kind);
  if (tree.kind === "set" && tree.args.length > 1 && !tree.args.some(hasOrder)) throw new ParseError("read.no-order");
  return asMatrix(
    buildMatrixOfNamedVectors(tree, labels, columnNames, { rows, columns }) ??
      orderByLabels(tree, labels, { rows, columns }),
  );
}

/** Return the matrix given as v = […], ω = […] or as z0 = […], z1 = […], in any order; null for other forms. */
function buildMatrixOfNamedVectors(
  { kind, args }: Node,
  labels: Names,
  columnNames: Names,
  { rows: rowCount, columns: columnCount }: Shape,
): Node | null {
  if (!["dict", "list", "set", "and"].includes(kind) || !args.every(findNameBefore)) return null;
  const firstLetter = args[0] ? labelOf(findNameBefore(args[0])).slice(0, 1) : "";
  const isNumberedLetter = firstLetter === "j" || firstLetter === "s"; // J1, J2 or S1, S2
  const isNumbered = columnNames.length === 0 && columnCount > 1 && isNumberedLetter;
  const expectedColumns = isNumbered
    ? Array.from({ length: columnCount }, (_, i) => `${firstLetter}${i + 1}`)
    : columnNames;
  const names = labels.map(labelOf);
  const componentOrders = [COMPONENTS, [...COMPONENTS.slice(3), ...COMPONENTS.slice(0, 3)]];
  const isTwist = componentOrders.some((components) => components.join() === names.join());
  const expectedNames = isTwist ? [0, 3].map((i) => (names[i] as string)[0] as string) : expectedColumns.map(labelOf);
  const vectorOfName = new Map(
    args.map((arg) => [labelOf(findNameBefore(arg)), listVectorEntries(arg.args[1] as Node)]),
  );
  const columnVectors = expectedNames.map((name) => vectorOfName.get(name) ?? []);
  const areAllNamed =
    expectedNames.length > 0 && args.length === expectedNames.length && vectorOfName.size === expectedNames.length;
  if (!areAllNamed || columnVectors.some(({ length }) => length * (isTwist ? 2 : 1) !== rowCount)) return null;
  if (isTwist) return node("list", ...columnVectors.flat());
  return listOf(transposeRows(columnVectors));
}

/** Rewrite z0 = z1 = a as z0 = a, z1 = a if these names are expected, also in a list. */
function splitChains(tree: Node, expectedNames: readonly string[]): Node {
  if (!["and", "list", "set"].includes(tree.kind)) return tree;
  const expectedLabels = expectedNames.map(labelOf);
  const isChain = tree.kind === "and" && tree.text === CHAIN;
  const parts = (isChain ? [tree] : tree.args).flatMap((statement) => {
    const sides = listSides(statement);
    const leftSides = sides.slice(0, -1);
    const isExpected = ({ kind, text }: Node): boolean => kind === "name" && expectedLabels.includes(labelOf(text));
    return leftSides.length > 0 && leftSides.every(isExpected)
      ? leftSides.map((name) => node("eq", name, sides.at(-1) as Node))
      : [statement];
  });
  return isChain && parts.length === 1 ? tree : node(tree.kind, ...parts);
}

/** Return the name before an entry, or ""; S1 before an entry is a name and no sine. */
function findNameBefore(tree: Node): string {
  if (tree.kind !== "pair" && tree.kind !== "eq") return "";
  const [{ kind, text, args }] = tree.args as readonly [Node];
  const [angle] = args;
  if (kind === "call" && text === "sin" && angle?.kind === "name") return angle.text.replaceAll("theta", "s");
  return hasName(tree) ? text : "";
}

/** Return the entries of a row or column; an empty list for other nodes. */
function listVectorEntries({ kind, args }: Node): readonly Node[] {
  const rows = kind === "list" ? args : [];
  const entries = rows.map((row) => (row.kind === "list" && row.args.length === 1 ? (row.args[0] as Node) : row));
  return entries.some((entry) => entry.kind === "list") ? [] : entries;
}

/** Return an example of how a shape is typed: [a, b], or [[a, b], [c, d]]. */
function writeExampleOfShape(rows: number, columns: number): string {
  const letters = [..."abcdefghi"];
  if (Math.max(rows, columns) > 3) return columns === 1 ? "[a, …, b]" : "[[a, …, b], …, [c, …, d]]";
  const rowTexts = Array.from({ length: rows }, () => letters.splice(0, columns).join(", "));
  return `[${(columns === 1 ? rowTexts : rowTexts.map((row) => `[${row}]`)).join(", ")}]`;
}

/** Return rows if they have the expected shape (a row may stand for a column); else a verdict. */
export function checkShape(rows: Node[][], shape: Shape): RowsOrVerdict {
  const row = rows[0] as Node[];
  if (shape.columns === 1 && rows.length === 1 && row.length === shape.rows) return row.map((entry) => [entry]);
  if (rows.length === shape.rows && row.length === shape.columns) return rows;
  return wrong("read.shape", {
    found: `${rows.length} × ${row.length}`,
    expected: `${shape.rows} × ${shape.columns}`,
    typed: writeExampleOfShape(shape.rows, shape.columns),
  });
}

/** Parse an answer as for judging: as a table if the text itself lacks the part's shape. Throws ParseError. */
export function parseAnswer(
  text: string,
  symbols: ReadonlySet<string>,
  { key, shape }: Pick<AskedPart, "key" | "shape">,
): Node {
  const [rows, columns] = shape ?? [1, 1];
  if (rows * columns === 1 || !["values", "numbers", "direction"].includes(key.type)) return parse(text, symbols);
  const listText = key.type === "numbers" ? convertNumbers(text, rows) : convertTable(text, rows, columns);
  const rowsOrVerdict = parseOrVerdict(() =>
    checkShape(asMatrix(takeRightSide(parse(text, symbols), symbols)), { rows, columns }),
  );
  return parse(isVerdict(rowsOrVerdict) ? (listText ?? text) : text, symbols);
}

/** Return the formula in "J = …", "… = J" or "det: …" if the other side is the student's own name or the only label. */
export function takeRightSide(typed: Node, symbols: ReadonlySet<string>, labels: readonly string[] = []): Node {
  const tree = typed.kind === "dict" && typed.args.length === 1 ? (typed.args[0] as Node) : typed;
  const sides = tree.kind === "pair" ? tree.args : listSides(tree); // det J = J11*J22 - J12*J21 = …
  const [left, right] = [sides[0], sides.at(-1)];
  const isOfSymbols = (side: Node) => hasNameOf(side, symbols);
  // det J = a1*a2*sin(theta2) = 0
  if (!left || !right || (isConstant(right) && sides.slice(1, -1).some(isOfSymbols))) return typed;
  const isOwnName = (name: Node) => (isName(name) || isOfEntries(name)) && !hasNameOf(name, symbols);
  const isLabel = (name: Node) =>
    name.kind === "name" && labels.length === 1 && labelOf(name.text) === labelOf(labels[0] as string);
  // A symbol is a number, so before a matrix it is a name: M is parsed as the mass m.
  const isNameOf = (name: Node, value: Node) =>
    isOwnName(name) || isLabel(name) || (value.kind === "list" && isSymbolOrFunction(name));
  if (isNameOf(left, right)) return right;
  return isNameOf(right, left) ? left : typed;
}

/** Return whether a node is a single name, or a function of all joint variables such as M(q). */
function isSymbolOrFunction(tree: Node): boolean {
  const [symbol, argument] = tree.kind === "*" ? tree.args : [tree];
  return symbol?.kind === "name" && (argument === undefined || Object.hasOwn(VOCABULARY.joints, argument.text));
}

/** The components of linear and angular velocities, and of linear ones. */
const COMPONENTS: readonly string[] = ROWS;
const LINEAR_COMPONENTS = COMPONENTS.slice(0, 3);

/** Return the name before a formula if the name is a velocity component other than the expected one; else "". */
export function findOtherComponent(typed: Node, labels: readonly string[]): string {
  const [label] = labels;
  if (label === undefined || labels.length !== 1 || !LINEAR_COMPONENTS.includes(labelOf(label))) return "";
  let tree = typed;
  while (["list", "set", "dict"].includes(tree.kind) && tree.args.length === 1) tree = tree.args[0] as Node;
  const [left] = tree.args;
  if ((tree.kind !== "eq" && tree.kind !== "pair") || left?.kind !== "name") return "";
  const name = labelOf(left.text);
  return COMPONENTS.includes(name) && name !== labelOf(label) ? left.text : "";
}

/** Return whether a formula consists of entries of the Jacobian, as in J11*J22 - J12*J21. */
function isOfEntries(tree: Node): boolean {
  const names = [...findNames(tree)];
  return names.length > 0 && names.every((symbol) => /^[jJ]_?[1-6]{2}$/.test(symbol));
}

/** Return whether an expression is used as a name: words, dx/dq, |J|, or the power of a name, as in J^-1. */
function isName(tree: Node): boolean {
  let top = tree.kind === "call" && tree.text === "abs" ? (tree.args[0] as Node) : tree;
  while ((top.kind === "*" || top.kind === "/") && top.args[1]?.kind === "name") top = top.args[0] as Node;
  return top.kind === "name" || (top.kind === "^" && top.args[0]?.kind === "name");
}

const hasName = ({ kind, args }: Node): boolean => (kind === "pair" || kind === "eq") && args[0]?.kind === "name";
const hasLabel = (tree: Node): boolean =>
  hasName(tree) || (tree.kind === "list" && tree.args.length === 2 && tree.args[0]?.kind === "name");

/** Return the entries of {qd1: …}, [qd1 = …] or [(qd1, …)] in the order of the labels; names may be row1 or J12. */
function orderByLabels(tree: Node, labels: readonly string[], { rows, columns }: Shape): Node {
  const inner = tree.args[0];
  if (tree.args.length === 1 && inner && isListOrSet(tree)) {
    const isOnlyWrapper = tree.kind === "set" || inner.args.every(hasName);
    if (inner.kind === "dict" || (inner.kind === "list" && isOnlyWrapper))
      return orderByLabels(inner, labels, { rows, columns });
  }
  if (!["dict", "list", "set", "and"].includes(tree.kind) || !tree.args.every(hasLabel)) return tree;
  const names = tree.args.map((arg) => labelOf(arg.args[0]?.text ?? ""));
  const repeatedIndex = names.findIndex((label, i) => names.lastIndexOf(label) !== i);
  const areNamed = tree.args.every(hasName);
  if (repeatedIndex >= 0 && areNamed)
    throw new ParseError("read.twice", { name: tree.args[repeatedIndex]?.args[0]?.text ?? "" });
  if (repeatedIndex >= 0) return tree; // rows of a matrix may begin with the same name
  const entriesInOrderOf = (expectedNames: readonly string[]): readonly Node[] | null =>
    expectedNames.length > 0 &&
    names.length === new Set(expectedNames).size &&
    expectedNames.every((label) => names.includes(label))
      ? expectedNames.map((label) => tree.args[names.indexOf(label)]?.args[1] as Node)
      : null;
  const rowNames = Array.from({ length: rows }, (_, i) => `row${i + 1}`);
  const orderedEntries = entriesInOrderOf(labels.map(labelOf)) ?? entriesInOrderOf(rowNames);
  if (orderedEntries) return node("list", ...orderedEntries);
  const orderedMatrixEntries = entriesInOrderOf(
    Array.from({ length: rows * columns }, (_, k) => `j${Math.floor(k / columns) + 1}${(k % columns) + 1}`),
  );
  if (orderedMatrixEntries) return listOf(splitIntoRows(orderedMatrixEntries, columns));
  if (names.length > 0 && areNamed) throw new ParseError("read.names", { names: names.slice(0, 5).join(", ") });
  return tree;
}

/** As "px", "xe" and "ytcp"; group: the coordinate. */
const POINT_OF_ENTRY = wholePattern("point_of_entry");

/** Return the name of an entry for comparison: x for P_x, p_x, px and x; vx for v_x and x_dot; wx for ω_x. */
export function labelOf(name: string): string {
  const spelling = respell(name.toLowerCase());
  const entry = POINT_OF_ENTRY.exec(spelling)?.[1];
  return entry ?? (spelling.length > 1 && spelling.startsWith("p") ? spelling.slice(1) : spelling);
}

/** Return whether an answer is empty, or a list of blanks. */
export function isBlank(tree: Node): boolean {
  if (isListOrSet(tree)) return tree.args.length > 0 && tree.args.every(isBlank);
  return tree.kind === "blank";
}
