// Expressions as trees of plain nodes. The kinds are those of ../../../exercises/formula/trees.py.

import { ENGLISH, type Message, message, textOf, type Values, type TextKey } from "../text/text.js";
import { VOCABULARY } from "./vocabulary.js";

type Formula = "number" | "decimal" | "name" | "blank" | "call" | "neg" | "+" | "-" | "*" | "/" | "^";
type Collection = "list" | "set" | "dict" | "pair";
type Statement = "eq" | "in" | "and" | "or";
export type Kind = Formula | Collection | Statement;

export interface Node {
  readonly kind: Kind;
  /** The operands, arguments or entries; empty for a leaf. */
  readonly args: readonly Node[];
  /** The name of a "name" or "call", the typed text of a number, or CHAIN; else "". */
  readonly text: string;
  /** The value of a "number" (a whole number) or "decimal" (one with a decimal point or exponent); else NaN. */
  readonly value: number;
  /** The number of significant digits of a decimal that was typed; else 0. */
  readonly digits: number;
}

/** Values of symbols at a configuration, by name. */
export type SymbolValues = Readonly<Record<string, number>>;

/** Names of constants, such as pi. */
export const CONSTANTS: readonly string[] = [...new Set(Object.values(VOCABULARY.constants))];

/** A text that is not a valid answer. `why` says what was found, where, and what would be valid. */
export class ParseError extends Error {
  readonly why: Message;

  constructor(key: TextKey, values: Values = {}) {
    const why = message(key, values);
    super(textOf(why, ENGLISH));
    this.why = why;
  }
}

/** Return what `parse` returns; if the text can't be parsed, what `recover` returns for the error. */
export function catchParseError<T, U>(parse: () => T, recover: (error: ParseError) => U): T | U {
  try {
    return parse();
  } catch (error) {
    if (error instanceof ParseError) return recover(error);
    throw error;
  }
}

// eslint-disable-next-line no-control-regex
const INVISIBLE_CHARACTERS = /[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]/gu;

/** Return a text in one line; invisible characters, and those that change the direction of text, are escaped. */
function escapeInvisible(text: string): string {
  return text
    .replace(/[\t\n]/g, " ")
    .replace(INVISIBLE_CHARACTERS, (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
}

/** Return an error that reports the index of a character and the text around it. */
export function errorAt(key: TextKey, values: Values, text: string, index: number): ParseError {
  const excerpt = escapeInvisible(text.slice(Math.max(0, index - 15), index + 15));
  return new ParseError("read.at", { what: message(key, values), at: index + 1, near: excerpt });
}

export const node = (kind: Kind, ...args: readonly Node[]): Node => ({ kind, args, text: "", value: NaN, digits: 0 });
export const name = (text: string): Node => ({ ...node("name"), text });
export const call = (text: string, ...args: readonly Node[]): Node => ({ ...node("call", ...args), text });
export const integer = (value: number, text = String(value)): Node => ({ ...node("number"), text, value });
export const decimal = (value: number): Node => ({ ...node("decimal"), value });

/** The `text` of an "and" of equations that were written as A = B = C. */
export const CHAIN = "=";

/** Return the sides of A = B = C; an empty list for other nodes. */
export function listSides({ kind, args, text }: Node): readonly Node[] {
  if (kind === "eq") return args;
  if (kind !== "and" || text !== CHAIN || args.some((arg) => arg.kind !== "eq")) return [];
  return [args[0]?.args[0] as Node, ...args.map((arg) => arg.args[1] as Node)];
}

/** Rebuild a tree from its leaves up, without recursion: `make` gets a node and its rebuilt arguments. */
export function rebuild(tree: Node, make: (top: Node, args: readonly Node[]) => Node): Node {
  const results: Node[] = [];
  const pending = [{ top: tree, areArgsDone: false }];
  for (let visit = pending.pop(); visit; visit = pending.pop()) {
    const { top, areArgsDone } = visit;
    if (areArgsDone || top.args.length === 0) results.push(make(top, results.splice(results.length - top.args.length)));
    else {
      pending.push({ top, areArgsDone: true });
      for (let i = top.args.length - 1; i >= 0; i -= 1) pending.push({ top: top.args[i] as Node, areArgsDone: false });
    }
  }
  return results[0] as Node;
}

/** Return the tree with a name replaced by another tree. */
export function replaceName(tree: Node, oldName: string, replacement: Node): Node {
  return rebuild(tree, (top, args) => {
    if (args.length > 0) return { ...top, args };
    return top.kind === "name" && top.text === oldName ? replacement : top;
  });
}

/** Return whether some node of a tree passes a test; the search ends at this node. */
export function anyNode(tree: Node, passes: (node: Node) => boolean): boolean {
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

/** Call a function with each node of a tree. */
export function visitNodes(tree: Node, visit: (node: Node) => void): void {
  anyNode(tree, (node) => {
    visit(node);
    return false;
  });
}

/** Return the names in trees, without constants. */
export function findNames(...trees: readonly Node[]): Set<string> {
  const names = new Set<string>();
  for (const tree of trees) visitNodes(tree, ({ kind, text }) => kind === "name" && names.add(text));
  for (const constant of CONSTANTS) names.delete(constant);
  return names;
}

/** Return whether a tree contains no names, or only those of constants. */
export const isConstant = (tree: Node): boolean => findNames(tree).size === 0;

/** Return whether a tree contains one of some names. */
export const hasNameOf = (tree: Node, names: { readonly has: (name: string) => boolean }): boolean =>
  anyNode(tree, ({ kind, text }) => kind === "name" && names.has(text));

/** Return the number of significant digits of the longest decimal in a tree; 0 without one. */
export function countDigitsOfDecimals(tree: Node): number {
  let maxDigits = 0;
  visitNodes(tree, ({ digits }) => (maxDigits = Math.max(maxDigits, digits)));
  return maxDigits;
}

/** Return whether a tree contains a blank: a placeholder that the student did not replace. */
export const hasBlank = (tree: Node): boolean => anyNode(tree, ({ kind }) => kind === "blank");

export const isListOrSet = (tree: Node | undefined): boolean => tree?.kind === "list" || tree?.kind === "set";

/** The entries of a matrix, row by row. */
export type Rows = readonly (readonly Node[])[];

/** Return a matrix as a list of its rows. */
export const listOf = (rows: Rows): Node => node("list", ...rows.map((row) => node("list", ...row)));

/** Return entries as rows of a given length. */
export const splitIntoRows = <T>(entries: readonly T[], columns: number): T[][] =>
  Array.from({ length: entries.length / columns }, (_, i) => entries.slice(i * columns, (i + 1) * columns));

/** Return the row and the column (from 1) of an entry, given its index row by row (from 0). */
export const locateEntry = (index: number, columns: number): { readonly row: number; readonly column: number } => ({
  row: Math.floor(index / columns) + 1,
  column: (index % columns) + 1,
});

/** Return the columns of rows of equal length. */
export const transposeRows = <T>(rows: readonly (readonly T[])[]): T[][] =>
  (rows[0] ?? []).map((_, j) => rows.map((row) => row[j] as T));

/** Return whether all nodes are lists of one length. */
export const isRectangle = (items: readonly Node[]): boolean =>
  items.every(({ kind, args }) => kind === "list" && args.length === items[0]?.args.length);

/**
 * Return rows of scalars from a list of rows, a list of scalars (a column), or a scalar (1 x 1). Throws ParseError if
 * rows differ in length or lists are nested deeper.
 */
export function asMatrix(tree: Node): Node[][] {
  const isListOfLists = ({ kind, args }: Node): boolean =>
    kind === "list" && args.length > 0 && args.every((item) => item.kind === "list");
  let top = tree;
  while (top.kind === "list" && top.args.length === 1 && isListOfLists(top.args[0] as Node)) top = top.args[0] as Node;
  const isRowMatrix = (item: Node): boolean =>
    isListOfLists(item) && item.args.length === 1 && (item.args[0] as Node).args.length > 1;
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
    return transposeRows(items.map(({ args }) => args.map((entry) => entry.args[0] as Node))); // [[[a], [b]], [[c], [d]]]
  const rows = items.map((item) => (item.kind === "list" ? [...item.args] : [item]));
  const lengths = rows.map((row) => row.length);
  if (rows.length === 0) throw new ParseError("read.empty-list");
  if (new Set(lengths).size !== 1) throw new ParseError("read.ragged", { lengths: lengths.join(", ") });
  if (rows.flat().some(({ kind }) => ["list", "set", "dict"].includes(kind))) throw new ParseError("read.nested-list");
  return rows;
}
