// Expressions as trees of plain nodes; what the kinds mean is as in ../../../exercises/formula/trees.py.

import type { TextKey } from "../text/en.js";
import { ENGLISH, type Message, message, said, type Values } from "../text/text.js";
import { VOCABULARY } from "./vocabulary.js";

export type Kind =
  | "number"
  | "decimal"
  | "name"
  | "blank"
  | "call"
  | "neg"
  | "+"
  | "-"
  | "*"
  | "/"
  | "^"
  | "list"
  | "set"
  | "dict"
  | "pair"
  | "eq"
  | "in"
  | "and"
  | "or";

/** `text` is the name of a name or call, `value` the number of a number or decimal, `digits` how many it has. */
export interface Node {
  readonly kind: Kind;
  readonly args: readonly Node[];
  readonly text: string;
  readonly value: number;
  readonly digits: number;
}

export const CONSTANTS: readonly string[] = [...new Set(Object.values(VOCABULARY.constants))];

/** Text that is no answer: what was found, where, and what would be understood, as a text of the catalogue. */
export class ReadError extends Error {
  readonly why: Message;

  constructor(key: TextKey, values: Values = {}) {
    const why = message(key, values);
    super(said(why, ENGLISH));
    this.why = why;
  }
}

// eslint-disable-next-line no-control-regex
const CONTROLS = /[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]/gu;

/** A text in one line, with what nobody sees, or what turns the direction of the text, written out. */
function shown(text: string): string {
  return text
    .replace(/[\t\n]/g, " ")
    .replace(CONTROLS, (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
}

/** An error with the place in the text where it is. */
export function placed(key: TextKey, values: Values, text: string, at: number): ReadError {
  const near = shown(text.slice(Math.max(0, at - 15), at + 15));
  return new ReadError("read.at", { what: message(key, values), at: at + 1, near });
}

/** What leaves have, one for all. */
const NO_ARGS: readonly Node[] = [];

export function node(kind: Kind, ...args: readonly Node[]): Node {
  return { kind, args, text: "", value: NaN, digits: 0 };
}

export function name(text: string): Node {
  return { kind: "name", args: NO_ARGS, text, value: NaN, digits: 0 };
}

export function call(text: string, ...args: readonly Node[]): Node {
  return { kind: "call", args, text, value: NaN, digits: 0 };
}

export function integer(value: number, text = String(value)): Node {
  return { kind: "number", args: NO_ARGS, text, value, digits: 0 };
}

/** The text of an "and" of equations that were written in one, A = B = C. */
export const CHAIN = "=";

/** The sides of A = B = C; nothing of what is no equation. */
export function chainOf({ kind, args, text }: Node): readonly Node[] {
  if (kind === "eq") return args;
  if (kind !== "and" || text !== CHAIN || args.some((arg) => arg.kind !== "eq")) return [];
  return [args[0]?.args[0] as Node, ...args.map((arg) => arg.args[1] as Node)];
}

/** The tree with another tree put for a name. */
export function replaced(tree: Node, old: string, put: Node): Node {
  const done: Node[] = [];
  const todo: (readonly [top: Node, ready: boolean])[] = [[tree, false]];
  for (let next = todo.pop(); next; next = todo.pop()) {
    // no recursion: a long sum is a deep tree
    const [top, ready] = next;
    if (top.kind === "name") done.push(top.text === old ? put : top);
    else if (top.args.length === 0) done.push(top);
    else if (ready) done.push({ ...top, args: done.splice(done.length - top.args.length) });
    else {
      todo.push([top, true]);
      for (let i = top.args.length - 1; i >= 0; i -= 1) todo.push([top.args[i] as Node, false]);
    }
  }
  return done[0] as Node;
}

/** Whether a node of a tree passes a test; none is tested after that. */
export function anyNode(tree: Node, passes: (each: Node) => boolean): boolean {
  if (passes(tree)) return true;
  const stack = [tree];
  for (let top = stack.pop(); top; top = stack.pop()) {
    for (const arg of top.args) {
      if (passes(arg)) return true;
      if (arg.args.length > 0) stack.push(arg); // half of all are leaves
    }
  }
  return false;
}

/** The names in a tree that are not constants. */
export function namesIn(tree: Node): Set<string> {
  const found = new Set<string>();
  anyNode(tree, ({ kind, text }) => {
    if (kind === "name") found.add(text);
    return false;
  });
  for (const each of CONSTANTS) found.delete(each);
  return found;
}

/** How many significant digits the longest decimal in a tree has; 0 without one. */
export function digitsOfDecimals(tree: Node): number {
  let most = 0;
  anyNode(tree, ({ digits }) => {
    most = Math.max(most, digits);
    return false;
  });
  return most;
}

/** Whether a placeholder is still there somewhere in the tree. */
export function hasBlank(tree: Node): boolean {
  return anyNode(tree, ({ kind }) => kind === "blank");
}

/**
 * Rows of scalars: a list of rows, a list of scalars (a column), or a scalar (1 x 1). Throws ReadError where rows
 * differ in length or lists nest deeper.
 */
export function asMatrix(tree: Node): Node[][] {
  let top = tree;
  for (
    let inner = top.args[0];
    top.kind === "list" && top.args.length === 1 && inner && isRows(inner);
    inner = top.args[0]
  ) {
    top = inner;
  }
  if (top.kind === "list" && top.args.length > 0 && top.args.every(isRowMatrix)) {
    top = node("list", ...top.args.map((item) => item.args[0] as Node)); // [[[a, b]], [[c, d]]]
  }
  if (top.kind === "set" && top.args.length > 0 && top.args.every((item) => item.kind === "set")) {
    top = node("list", ...top.args.map((item) => node("list", ...item.args)));
  }
  if (top.kind !== "list") return [[top]];
  const sideBySide = columns(top);
  if (sideBySide) return sideBySide;
  const rows = top.args.map((item) => (item.kind === "list" ? [...item.args] : [item]));
  const lengths = rows.map((row) => row.length);
  if (rows.length === 0) throw new ReadError("read.empty-list");
  if (new Set(lengths).size !== 1) {
    throw new ReadError("read.ragged", { lengths: lengths.join(", ") });
  }
  if (rows.some((row) => row.some((entry) => ["list", "set", "dict"].includes(entry.kind)))) {
    throw new ReadError("read.nested-list");
  }
  return rows;
}

/** A list of column vectors, [[a], [b]] each, as the rows of a matrix; null where it is none. */
function columns(list: Node): Node[][] | null {
  if (list.args.length === 0 || !list.args.every(isColumn)) return null;
  const found = list.args.map((item) => item.args.map((entry) => entry.args[0] as Node));
  const length = found[0]?.length ?? 0;
  if (found.some((column) => column.length !== length)) return null;
  return Array.from({ length }, (_, i) => found.map((column) => column[i] as Node));
}

function isColumn(tree: Node): boolean {
  const single = (item: Node) =>
    item.kind === "list" && item.args.length === 1 && item.args[0]?.kind !== "list";
  return tree.kind === "list" && tree.args.length > 1 && tree.args.every(single);
}

function isRowMatrix(tree: Node): boolean {
  const [row] = tree.args;
  return tree.kind === "list" && tree.args.length === 1 && row?.kind === "list" && row.args.length > 1;
}

function isRows(tree: Node): boolean {
  return tree.kind === "list" && tree.args.length > 0 && tree.args.every((item) => item.kind === "list");
}
