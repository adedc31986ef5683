// Expressions as trees of plain nodes; what the kinds mean is as in ../../../exercises/formula/trees.py.

import { ENGLISH, type Message, message, said, type Values, type TextKey } from "../text/text.js";
import { VOCABULARY } from "./vocabulary.js";

type Formula = "number" | "decimal" | "name" | "blank" | "call" | "neg" | "+" | "-" | "*" | "/" | "^";
type Collection = "list" | "set" | "dict" | "pair";
type Statement = "eq" | "in" | "and" | "or";
export type Kind = Formula | Collection | Statement;

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

export const node = (kind: Kind, ...args: readonly Node[]): Node => ({ kind, args, text: "", value: NaN, digits: 0 });
export const name = (text: string): Node => ({ ...node("name"), text });
export const call = (text: string, ...args: readonly Node[]): Node => ({ ...node("call", ...args), text });
export const integer = (value: number, text = String(value)): Node => ({ ...node("number"), text, value });
export const decimal = (value: number): Node => ({ ...node("decimal"), value });

/** The text of an "and" of equations that were written in one, A = B = C. */
export const CHAIN = "=";

/** The sides of A = B = C; nothing of what is no equation. */
export function chainOf({ kind, args, text }: Node): readonly Node[] {
  if (kind === "eq") return args;
  if (kind !== "and" || text !== CHAIN || args.some((arg) => arg.kind !== "eq")) return [];
  return [args[0]?.args[0] as Node, ...args.map((arg) => arg.args[1] as Node)];
}

/** The tree with each node `made` of what its arguments became: no recursion, for a long sum is a deep tree. */
export function rebuilt(tree: Node, made: (top: Node, args: readonly Node[]) => Node): Node {
  const done: Node[] = [];
  const todo: (readonly [top: Node, isReady: boolean])[] = [[tree, false]];
  for (let next = todo.pop(); next; next = todo.pop()) {
    const [top, isReady] = next;
    if (isReady || top.args.length === 0) done.push(made(top, done.splice(done.length - top.args.length)));
    else {
      todo.push([top, true]);
      for (let i = top.args.length - 1; i >= 0; i -= 1) todo.push([top.args[i] as Node, false]);
    }
  }
  return done[0] as Node;
}

/** The tree with another tree put for a name. */
export function replaced(tree: Node, old: string, put: Node): Node {
  return rebuilt(tree, (top, args) => {
    if (args.length > 0) return { ...top, args };
    return top.kind === "name" && top.text === old ? put : top;
  });
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
export const hasBlank = (tree: Node): boolean => anyNode(tree, ({ kind }) => kind === "blank");

export type Rows = readonly (readonly Node[])[];

/** A matrix as a list of its rows. */
export const listOf = (rows: Rows): Node => node("list", ...rows.map((row) => node("list", ...row)));

/** Entries in rows of so many each. */
export const inRows = <T>(entries: readonly T[], columns: number): T[][] =>
  Array.from({ length: entries.length / columns }, (_, i) => entries.slice(i * columns, (i + 1) * columns));

/** The columns of rows that are equally long. */
export const columnsOf = <T>(rows: readonly (readonly T[])[]): T[][] =>
  (rows[0] ?? []).map((_, j) => rows.map((row) => row[j] as T));

/** Whether all are lists of one length. */
export const isRectangle = (items: readonly Node[]): boolean =>
  items.every(({ kind, args }) => kind === "list" && args.length === items[0]?.args.length);

/**
 * Rows of scalars: a list of rows, a list of scalars (a column), or a scalar (1 x 1). Throws ReadError where rows
 * differ in length or lists nest deeper.
 */
export function asMatrix(tree: Node): Node[][] {
  const isRows = ({ kind, args }: Node): boolean =>
    kind === "list" && args.length > 0 && args.every((item) => item.kind === "list");
  let top = tree;
  while (top.kind === "list" && top.args.length === 1 && isRows(top.args[0] as Node)) top = top.args[0] as Node;
  const isRowMatrix = (item: Node): boolean =>
    isRows(item) && item.args.length === 1 && (item.args[0] as Node).args.length > 1;
  if (top.kind === "list" && top.args.length > 0 && top.args.every(isRowMatrix))
    top = node("list", ...top.args.map((item) => item.args[0] as Node)); // [[[a, b]], [[c, d]]]
  if (top.kind === "set" && top.args.length > 0 && top.args.every((item) => item.kind === "set"))
    top = listOf(top.args.map((item) => item.args));
  if (top.kind !== "list") return [[top]];
  const isRowOfOne = ({ kind, args }: Node): boolean =>
    kind === "list" && args.length === 1 && args[0]?.kind !== "list";
  const { args: items } = top;
  const areColumns = items.every(({ args }) => args.length > 1 && args.every(isRowOfOne));
  if (items.length > 0 && areColumns && isRectangle(items))
    return columnsOf(items.map(({ args }) => args.map((entry) => entry.args[0] as Node))); // [[[a], [b]], [[c], [d]]]
  const rows = items.map((item) => (item.kind === "list" ? [...item.args] : [item]));
  const lengths = rows.map((row) => row.length);
  if (rows.length === 0) throw new ReadError("read.empty-list");
  if (new Set(lengths).size !== 1) throw new ReadError("read.ragged", { lengths: lengths.join(", ") });
  if (rows.flat().some(({ kind }) => ["list", "set", "dict"].includes(kind))) throw new ReadError("read.nested-list");
  return rows;
}
