// What was written of matrices and not worked out: 1/a1 * [[a, b], [c, d]] * [vx; vy], and [qd1; qd2] = [a; b].
// The rules of ../../../exercises/formula/products.py; ../../tests/readers.test.ts holds both together.

import {
  anyNode,
  columnsOf,
  integer,
  type Kind,
  listOf,
  type Node,
  node,
  ReadError,
  rebuilt,
  type Rows,
} from "./tree.js";
import { LIMITS, VOCABULARY } from "./vocabulary.js";

const OPERATIONS: ReadonlySet<Kind> = new Set<Kind>(["+", "-", "*", "/", "neg", "^"]);
/** Rows of a matrix that is inverted. */
const LARGEST = 3;

const isList = ({ kind }: Node): boolean => kind === "list";

/** A tree in which matrices are no operands: what was to be done with them is done. Throws ReadError. */
export function carriedOut(tree: Node): Node {
  const isOpen = ({ kind, args }: Node) => (OPERATIONS.has(kind) || kind === "eq") && args.some(isList);
  if (!anyNode(tree, isOpen)) return tree;
  let made = 0;
  return rebuilt(tree, (top, args) => {
    if (args.length === 0) return top;
    const found = operation(top, args);
    if (OPERATIONS.has(top.kind) && isList(found)) {
      made += sizeOf(found, LIMITS.worked_out - made);
      if (made >= LIMITS.worked_out) throw new ReadError("read.long-products");
    }
    return found;
  });
}

/** How many nodes a tree has, counted no further than `most`. */
export function sizeOf(tree: Node, most: number): number {
  let count = 0;
  const stack = [tree];
  for (let top = stack.pop(); top && count < most; top = stack.pop()) {
    count += 1;
    for (const arg of top.args) stack.push(arg);
  }
  return count;
}

function operation(top: Node, given: readonly Node[]): Node {
  if (top.kind === "eq" && given.every(isList)) return equation(given as [Node, Node]);
  if (!OPERATIONS.has(top.kind) || !given.some(isList)) return { ...top, args: given };
  const args = given.map((arg) => (isBracket(arg) ? (arg.args[0] as Node) : arg)); // [a + b] c: brackets, and no list
  const [one, other] = args as [Node, Node];
  if (!args.some(isList)) return { ...top, args };
  if (top.kind === "^") return isList(one) && !isList(other) ? power(rowsOf(one), other) : impossible("^", args);
  if (top.kind === "neg") return each(rowsOf(one), (entry) => node("neg", entry));
  const both = isList(one) && isList(other);
  if ((top.kind === "+" || top.kind === "-") && both) return sum(top.kind, args);
  if (top.kind === "*" && both) return product(args);
  if (top.kind === "*" && isList(other)) return each(rowsOf(other), (entry) => node("*", one, entry));
  if ((top.kind === "*" || top.kind === "/") && !isList(other))
    return each(rowsOf(one), (entry) => node(top.kind, entry, other));
  return impossible(top.kind, args);
}

const isBracket = (tree: Node): boolean => isList(tree) && tree.args.length === 1 && !isList(tree.args[0] as Node);

/** The rows of a list; of a list of entries a column. */
function rowsOf(list: Node): Rows {
  const rows = list.args.map((item) => (isList(item) ? item.args : [item]));
  const width = rows[0]?.length;
  if (width === undefined || rows.some((row) => row.length !== width) || rows.flat().some(isList))
    throw new ReadError("read.no-matrix");
  return rows;
}

const each = (rows: Rows, made: (entry: Node) => Node): Node => listOf(rows.map((row) => row.map(made)));

function sum(sign: Kind, args: readonly Node[]): Node {
  const [one, other] = args.map(rowsOf) as [Rows, Rows];
  if (one.length !== other.length || one[0]?.length !== other[0]?.length) return impossible(sign, args);
  return listOf(one.map((row, i) => row.map((entry, j) => node(sign, entry, other[i]?.[j] as Node))));
}

/** An equation of two vectors or matrices as one for each entry, a name before what it is. */
function equation(args: readonly [Node, Node]): Node {
  if (isBracket(args[0])) return node("eq", args[0].args[0] as Node, args[1]); // [theta2] = [0, pi]
  const [one, other] = args.map(rowsOf) as [Rows, Rows];
  const shapes = [one, other].map((rows) => [rows.length, rows[0]?.length as number]);
  const isVector = shapes.every((shape) => shape.includes(1));
  const [left, right] = shapes.map((shape) => (isVector ? Math.max(...shape) : shape.join()));
  if (left !== right) return impossible("=", args);
  const values = other.flat();
  const pairs = one.flat().map((a, i) => {
    const b = values[i] as Node;
    return b.kind === "name" && a.kind !== "name" ? node("eq", b, a) : node("eq", a, b);
  });
  return node("and", ...pairs);
}

function product(args: readonly Node[]): Node {
  const [one, other] = args.map(rowsOf) as [Rows, Rows];
  if (one[0]?.length !== other.length) return impossible("*", args);
  if (one.length * other.length * (other[0] as readonly Node[]).length >= LIMITS.worked_out)
    throw new ReadError("read.long-products");
  const times = (row: readonly Node[], column: readonly Node[]): Node =>
    row.map((entry, i) => node("*", entry, column[i] as Node)).reduce((total, term) => node("+", total, term));
  return listOf(one.map((row) => columnsOf(other).map((column) => times(row, column))));
}

/** The transpose, or the inverse by cofactors, of a matrix. */
function power(rows: Rows, exponent: Node): Node {
  if (exponent.kind === "name" && VOCABULARY.transposed.includes(exponent.text)) return listOf(columnsOf(rows));
  const [of] = exponent.args;
  const isInverse = exponent.kind === "neg" && of?.kind === "number" && of.value === 1;
  if (!isInverse || rows.length !== rows[0]?.length || rows.length > LARGEST)
    throw new ReadError("read.power-of-matrix", { most: LARGEST });
  const whole = determinant(rows);
  const cofactors = rows.map((_, i) => rows.map((_row, j) => signed(i + j, minor(rows, j, i))));
  return each(cofactors, (entry) => node("/", entry, whole));
}

function minor(rows: Rows, i: number, j: number): Node {
  return determinant(rows.filter((_, r) => r !== i).map((row) => row.filter((_, c) => c !== j)));
}

function determinant(rows: Rows): Node {
  const [first] = rows;
  if (!first) return integer(1);
  return first
    .map((entry, j) => (rows.length === 1 ? entry : signed(j, node("*", entry, minor(rows, 0, j)))))
    .reduce((total, term) => node("+", total, term));
}

const signed = (index: number, tree: Node): Node => (index % 2 ? node("neg", tree) : tree);

function impossible(sign: Kind | "=", args: readonly Node[]): never {
  const shapes = args.filter(isList).map((arg) => {
    const rows = rowsOf(arg);
    return `${rows.length} × ${rows[0]?.length}`;
  });
  throw new ReadError("read.no-product", { sign, shapes: shapes.join(", ") });
}
