// A typed Denavit-Hartenberg table, its numbers, and the errors of its cells.
//
// The rules of ../../../exercises/arm/robot_file.py, but without symbolic lengths.

import type { TaskRow } from "../bank.js";
import { ROWS } from "../arm/model.js";
import { read } from "../read/reader.js";
import { realValue } from "../read/real.js";
import { anyNode, namesIn, type Node, ReadError } from "../read/tree.js";
import { type Message, message } from "../text/text.js";

export const CONVENTIONS = ["dh", "modified-dh"] as const;
export type Convention = (typeof CONVENTIONS)[number];
export const ANGLES = ["radians", "degrees"] as const;
export type Angles = (typeof ANGLES)[number];
export const ENTRIES = ["theta", "d", "a", "alpha"] as const;
export type Entry = (typeof ENTRIES)[number];
export type Kind = "R" | "P";

/** A row as it is typed; theta of a revolute joint, and d of a prismatic one, is its variable with what is added. */
export type TypedRow = { readonly kind: Kind } & Readonly<Record<Entry, string>>;

export type Triple<T> = readonly [T, T, T];

export interface Table {
  readonly name: string;
  readonly convention: Convention;
  readonly angles: Angles;
  readonly rows: readonly TypedRow[];
  /** The point of interest in the last frame (m). */
  readonly tool: Triple<string>;
  /** Where the base frame is in the world (m), and how it is turned: roll, pitch, yaw about the world's axes. */
  readonly place: Triple<string>;
  readonly turn: Triple<string>;
  /** The rows of J that count; null for those in which the arm moves. */
  readonly task: readonly TaskRow[] | null;
}

/** A row in numbers (rad, m): what is added to the variable, and whether that counts the other way. */
export interface Row {
  readonly kind: Kind;
  readonly theta: number;
  readonly d: number;
  readonly a: number;
  readonly alpha: number;
  readonly reversed: boolean;
}

export interface Numbers {
  readonly rows: readonly Row[];
  readonly tool: Triple<number>;
  readonly place: Triple<number>;
  readonly turn: Triple<number>;
}

/** The cell of a row, or of a place of three: "rows/0/theta", "tool/2". */
export type Cell = string;

export const rowCell = (row: number, entry: Entry): Cell => `rows/${row}/${entry}`;
export const placeCell = (place: "tool" | "place" | "turn", axis: number): Cell => `${place}/${axis}`;

export type Faults = ReadonlyMap<Cell, Message>;

/** As many joints as `qdot solve` takes. */
export const MOST_JOINTS = 10;
/** No cell is longer. */
export const LONGEST = 100;
/** Metres: longer than any arm. */
const FAR = 1e6;
/** Radians above which an angle is meant in degrees. */
const MANY_TURNS = 7;
/** Metres above which a length is probably meant in millimetres. */
const LONG = 20;

export const ZEROS: Triple<string> = ["0", "0", "0"];

/** The name of a joint's variable, as it is typed. */
export const variableOf = (row: number): string => `q${row + 1}`;

/** What moves of a row. */
export const movingEntry = (kind: Kind): Entry => (kind === "R" ? "theta" : "d");

/** A row of a new joint. */
export function newRow(kind: Kind, row: number): TypedRow {
  const still = { theta: "0", d: "0", a: "0", alpha: "0" };
  return { kind, ...still, [movingEntry(kind)]: variableOf(row) };
}

/** The row of another kind: what moved stands still, and the other way round. */
export function withKind(row: TypedRow, kind: Kind, index: number): TypedRow {
  if (row.kind === kind) return row;
  return { ...row, kind, [movingEntry(row.kind)]: "0", [movingEntry(kind)]: variableOf(index) };
}

/** The rows without one of them; variables of those behind it are called by their new numbers. */
export function withoutRow(rows: readonly TypedRow[], index: number): TypedRow[] {
  return rows.filter((_, i) => i !== index).map((row, i) => (i < index ? row : renumbered(row, i + 1, i)));
}

function renumbered(row: TypedRow, from: number, to: number): TypedRow {
  const moving = movingEntry(row.kind);
  const own = new RegExp(`\\b(q|theta|θ|d)_?${from + 1}\\b`, "gu");
  return { ...row, [moving]: row[moving].replace(own, `$1${to + 1}`) };
}

/** What a table says in numbers, or else what is wrong with it, cell by cell. */
export function numbersOf(table: Table): Numbers | Faults {
  const faults = new Map<Cell, Message>();
  const kept = <T>(cell: Cell, work: () => T, otherwise: T): T => {
    try {
      return work();
    } catch (error) {
      if (!(error instanceof ReadError)) throw error;
      faults.set(cell, error.why);
      return otherwise;
    }
  };
  const rows = table.rows.map((row, i) => numbersOfRow(row, i, table.angles, kept));
  const three = (place: "tool" | "place" | "turn"): Triple<number> => {
    const [x, y, z] = table[place].map((text, axis) =>
      kept(placeCell(place, axis), () => constant(text, place === "turn" ? table.angles : null), 0),
    );
    return [x!, y!, z!];
  };
  const numbers = { rows, tool: three("tool"), place: three("place"), turn: three("turn") };
  return faults.size > 0 ? faults : numbers;
}

type Kept = <T>(cell: Cell, work: () => T, otherwise: T) => T;

function numbersOfRow(row: TypedRow, index: number, angles: Angles, kept: Kept): Row {
  const moving = movingEntry(row.kind);
  const found = { kind: row.kind, theta: 0, d: 0, a: 0, alpha: 0, reversed: false };
  for (const entry of ENTRIES) {
    const unit = entry === "theta" || entry === "alpha" ? angles : null;
    const cell = rowCell(index, entry);
    if (entry !== moving) found[entry] = kept(cell, () => constant(row[entry], unit), 0);
    else {
      const [rest, reversed] = kept(cell, () => withVariable(row[entry], row.kind, index, unit), [0, false]);
      found[entry] = rest;
      found.reversed = reversed;
    }
  }
  return found;
}

/** A decimal number as it is written where a comma stands before the decimals. */
const WITH_COMMA = /^\s*[-+−]?\d*,\d+\s*$/u;

/** The tree of a cell; nothing is zero. Throws ReadError. */
function treeOf(text: string, known: ReadonlySet<string>): Node {
  if (text.length > LONGEST) throw new ReadError("read.long", { length: text.length, most: LONGEST });
  return read(WITH_COMMA.test(text) ? text.replace(",", ".") : text.trim() || "0", known);
}

/** A cell's number (rad where it is an angle, else m); `angles` is null for a length. Throws ReadError. */
export function constant(text: string, angles: Angles | null): number {
  const tree = treeOf(text, new Set());
  refuseLetters(tree, new Set());
  return inUnit(tree, {}, angles);
}

type Variable = readonly [rest: number, reversed: boolean];

/** What a cell adds to its joint's own variable, and whether that has a minus before it. Throws ReadError. */
export function withVariable(text: string, kind: Kind, index: number, angles: Angles | null): Variable {
  const own = variablesOf(kind, index);
  const tree = treeOf(text, new Set(own));
  refuseLetters(tree, new Set(own));
  const used = [...namesIn(tree)].filter((name) => own.includes(name));
  if (used.length === 0) return [inUnit(tree, {}, angles), false];
  const at = (value: number): number => {
    const values = Object.fromEntries(own.map((name) => [name, value]));
    return realValue(tree, values);
  };
  const [rest, one, two, far] = [at(0), at(1), at(2), at(-7.5)];
  const slope = one - rest;
  const isStraight = [two - rest - 2 * slope, far - rest + 7.5 * slope].every(
    (bend) => Math.abs(bend) < 1e-9 * (1 + Math.abs(rest)),
  );
  if (!isStraight || Math.abs(Math.abs(slope) - 1) > 1e-9)
    throw new ReadError("own.moves", { own: own[0]!, offset: offsetFor(angles) });
  refuseTurns(rest, angles, tree);
  return [inRadians(finite(rest), angles), slope < 0];
}

const offsetFor = (angles: Angles | null): string => (angles === null ? "0.2" : angles === "degrees" ? "90" : "pi/2");

/** What a joint's own variable may be called. */
function variablesOf(kind: Kind, index: number): readonly string[] {
  return [variableOf(index), `${kind === "R" ? "theta" : "d"}${index + 1}`];
}

function refuseLetters(tree: Node, known: ReadonlySet<string>): void {
  const others = [...namesIn(tree)].filter((name) => !known.has(name));
  if (others.length > 0) throw new ReadError("own.letters", { names: others.join(", ") });
}

/** Functions of angles and those whose values are angles, which would be in radians. */
const OF_ANGLES = /^(a?(sin|cos|tan)|atan2)$/;

function inUnit(tree: Node, values: Readonly<Record<string, number>>, angles: Angles | null): number {
  const value = finite(realValue(tree, values));
  refuseTurns(value, angles, tree);
  return inRadians(value, angles);
}

function inRadians(value: number, angles: Angles | null): number {
  return angles === "degrees" ? (value * Math.PI) / 180 : value;
}

function finite(value: number): number {
  if (!Number.isFinite(value)) throw new ReadError("own.not-real");
  if (Math.abs(value) > FAR) throw new ReadError("own.out-of-range");
  return value;
}

/** Refuse degrees where radians are expected, and the other way round. */
function refuseTurns(value: number, angles: Angles | null, tree: Node): void {
  if (angles === "degrees" && (hasPi(tree) || hasAngles(tree))) throw new ReadError("own.in-degrees");
  if (angles === "radians" && Math.abs(value) > MANY_TURNS && !hasPi(tree))
    throw new ReadError("own.in-radians", { value });
  if (angles === null && hasPi(tree)) throw new ReadError("own.pi");
}

const hasPi = (tree: Node): boolean => anyNode(tree, ({ kind, text }) => kind === "name" && text === "pi");
const hasAngles = (tree: Node): boolean => anyNode(tree, ({ kind, text }) => kind === "call" && OF_ANGLES.test(text));

/** What may be right, but is probably meant otherwise; null where nothing is. */
export function noteOn({ rows, tool }: Numbers): Message | null {
  const lengths = [...rows.flatMap(({ a, d }) => [a, d]), ...tool].map(Math.abs);
  const most = Math.max(...lengths);
  return most > LONG ? message("own.millimetres", { length: most, metres: most / 1000 }) : null;
}

export const isTaskRow = (name: string): name is TaskRow => (ROWS as readonly string[]).includes(name);
