// Carry out products of matrices in an answer: 1/a1 * [[a, b], [c, d]] * [vx; vy], and [qd1; qd2] = [a; b].
// The rules of ../../../exercises/formula/products.py; ../../tests/readers.test.ts compares both.

import type { Kind, Node, Rows } from "./tree.js";
import { anyNode, transposeRows, integer, listOf, node, ParseError, rebuild } from "./tree.js";
import { LIMITS, VOCABULARY } from "./vocabulary.js";

const OPERATIONS: ReadonlySet<Kind> = new Set<Kind>(["+", "-", "*", "/", "neg", "^"]);
/** Maximum number of rows of a matrix that is inverted. */
const MAX_INVERTED_SIZE = 3;

const isList = ({ kind }: Node): boolean => kind === "list";

/** Return a tree in which operations on matrices are carried out. Throws ParseError. */
export function carryOutProducts(tree: Node): Node {
  const isPending = ({ kind, args }: Node) => (OPERATIONS.has(kind) || kind === "eq") && args.some(isList);
  if (!anyNode(tree, isPending)) return tree;
  let createdNodes = 0;
  return rebuild(tree, (top, args) => {
    if (args.length === 0) return top;
    const result = applyOperation(top, args);
    if (OPERATIONS.has(top.kind) && isList(result)) {
      createdNodes += countNodes(result, LIMITS.nodes_of_results - createdNodes);
      if (createdNodes >= LIMITS.nodes_of_results) throw new ParseError("read.long-products");
    }
    return result;
  });
}

/** Return the number of nodes of a tree, or `limit` if there are more. */
export function countNodes(tree: Node, limit: number): number {
  let count = 0;
  const stack = [tree];
  for (let top = stack.pop(); top && count < limit; top = stack.pop()) {
    count += 1;
    for (const arg of top.args) stack.push(arg);
  }
  return count;
}

/** Return a node with new arguments; operations on matrices are carried out. */
function applyOperation(top: Node, operands: readonly Node[]): Node {
  if (top.kind === "eq" && operands.every(isList)) return equateEntries(operands as [Node, Node]);
  if (!OPERATIONS.has(top.kind) || !operands.some(isList)) return { ...top, args: operands };
  // in [a + b] c, the square brackets only group
  const args = operands.map((arg) => (isBracket(arg) ? (arg.args[0] as Node) : arg));
  const [left, right] = args as [Node, Node];
  if (!args.some(isList)) return { ...top, args };
  if (top.kind === "^")
    return isList(left) && !isList(right) ? transposeOrInvert(listRows(left), right) : refuseOperation("^", args);
  if (top.kind === "neg") return mapEntries(listRows(left), (entry) => node("neg", entry));
  const areBothLists = isList(left) && isList(right);
  if ((top.kind === "+" || top.kind === "-") && areBothLists) return addMatrices(top.kind, args);
  if (top.kind === "*" && areBothLists) return multiplyMatrices(args);
  if (top.kind === "*" && isList(right)) return mapEntries(listRows(right), (entry) => node("*", left, entry));
  if ((top.kind === "*" || top.kind === "/") && !isList(right))
    return mapEntries(listRows(left), (entry) => node(top.kind, entry, right));
  return refuseOperation(top.kind, args);
}

/** Return whether square brackets contain a single expression. */
const isBracket = (tree: Node): boolean => isList(tree) && tree.args.length === 1 && !isList(tree.args[0] as Node);

/** Return the rows of a list; a list of entries is a column. */
function listRows(list: Node): Rows {
  const rows = list.args.map((item) => (isList(item) ? item.args : [item]));
  const width = rows[0]?.length;
  if (width === undefined || rows.some((row) => row.length !== width) || rows.flat().some(isList))
    throw new ParseError("read.no-matrix");
  return rows;
}

const mapEntries = (rows: Rows, change: (entry: Node) => Node): Node => listOf(rows.map((row) => row.map(change)));

/** Return the sum or difference of two matrices. Throws ParseError if their shapes differ. */
function addMatrices(sign: Kind, args: readonly Node[]): Node {
  const [left, right] = args.map(listRows) as [Rows, Rows];
  if (left.length !== right.length || left[0]?.length !== right[0]?.length) return refuseOperation(sign, args);
  return listOf(left.map((row, i) => row.map((entry, j) => node(sign, entry, right[i]?.[j] as Node))));
}

/** Return an equation of vectors or matrices as one equation per entry; if one side is a name, it comes first. */
function equateEntries(args: readonly [Node, Node]): Node {
  if (isBracket(args[0])) return node("eq", args[0].args[0] as Node, args[1]); // [theta2] = [0, pi]
  const [leftRows, rightRows] = args.map(listRows) as [Rows, Rows];
  const shapes = [leftRows, rightRows].map((rows) => [rows.length, rows[0]?.length as number]);
  const isVector = shapes.every((shape) => shape.includes(1));
  const [leftShape, rightShape] = shapes.map((shape) => (isVector ? Math.max(...shape) : shape.join()));
  if (leftShape !== rightShape) return refuseOperation("=", args);
  const values = rightRows.flat();
  const pairs = leftRows.flat().map((leftEntry, i) => {
    const rightEntry = values[i] as Node;
    return rightEntry.kind === "name" && leftEntry.kind !== "name"
      ? node("eq", rightEntry, leftEntry)
      : node("eq", leftEntry, rightEntry);
  });
  return node("and", ...pairs);
}

/** Return the product of two matrices. Throws ParseError if their shapes don't match or the product is too long. */
function multiplyMatrices(args: readonly Node[]): Node {
  const [left, right] = args.map(listRows) as [Rows, Rows];
  if (left[0]?.length !== right.length) return refuseOperation("*", args);
  if (left.length * right.length * (right[0] as readonly Node[]).length >= LIMITS.nodes_of_results)
    throw new ParseError("read.long-products");
  const multiplyVectors = (row: readonly Node[], column: readonly Node[]): Node =>
    row.map((entry, i) => node("*", entry, column[i] as Node)).reduce((total, term) => node("+", total, term));
  return listOf(left.map((row) => transposeRows(right).map((column) => multiplyVectors(row, column))));
}

/** Return the transpose of a matrix, or its inverse by cofactors. */
function transposeOrInvert(rows: Rows, exponent: Node): Node {
  if (exponent.kind === "name" && VOCABULARY.transposed.includes(exponent.text)) return listOf(transposeRows(rows));
  const [negated] = exponent.args;
  const isInverse = exponent.kind === "neg" && negated?.kind === "number" && negated.value === 1;
  if (!isInverse || rows.length !== rows[0]?.length || rows.length > MAX_INVERTED_SIZE)
    throw new ParseError("read.power-of-matrix", { limit: MAX_INVERTED_SIZE });
  const determinantOfMatrix = computeDeterminant(rows);
  const cofactors = rows.map((_, i) => rows.map((_row, j) => applySign(i + j, computeMinor(rows, j, i))));
  return mapEntries(cofactors, (entry) => node("/", entry, determinantOfMatrix));
}

/** Return the minor without row i and column j. */
function computeMinor(rows: Rows, i: number, j: number): Node {
  return computeDeterminant(rows.filter((_, r) => r !== i).map((row) => row.filter((_, c) => c !== j)));
}

function computeDeterminant(rows: Rows): Node {
  const [firstRow] = rows;
  if (!firstRow) return integer(1);
  return firstRow
    .map((entry, j) => (rows.length === 1 ? entry : applySign(j, node("*", entry, computeMinor(rows, 0, j)))))
    .reduce((total, term) => node("+", total, term));
}

/** Return a tree with the sign (-1)^index. */
const applySign = (index: number, tree: Node): Node => (index % 2 ? node("neg", tree) : tree);

function refuseOperation(sign: Kind | "=", args: readonly Node[]): never {
  const shapes = args.filter(isList).map((arg) => {
    const rows = listRows(arg);
    return `${rows.length} × ${rows[0]?.length}`;
  });
  throw new ParseError("read.no-product", { sign, shapes: shapes.join(", ") });
}
