// A typed Denavit-Hartenberg table, its numbers, and the errors in its cells.
//
// The rules of ../../../exercises/robots/robot_file.py, but without symbolic lengths.

import { nameJoint, ROWS, type TaskRow } from "../bank.js";
import { parse } from "../read/reader.js";
import { evaluateRealTree } from "../read/real.js";
import { parseUnit } from "../read/units.js";
import { anyNode, catchParseError, findNames, type Node, ParseError, type SymbolValues } from "../read/tree.js";
import { type Message, message } from "../text/text.js";

export const CONVENTIONS = ["dh", "modified-dh"] as const;
type Convention = (typeof CONVENTIONS)[number];
export const ANGLES = ["radians", "degrees"] as const;
export type Angles = (typeof ANGLES)[number];
export const ENTRIES = ["theta", "d", "a", "alpha"] as const;
export type Entry = (typeof ENTRIES)[number];
export type Kind = "R" | "P";

/** A typed row. Theta of a revolute joint, or d of a prismatic one, is the joint variable plus a constant. */
export type TypedRow = { readonly kind: Kind } & Readonly<Record<Entry, string>>;

export type Triple<T> = readonly [T, T, T];

export interface Table {
  readonly name: string;
  readonly convention: Convention;
  readonly angles: Angles;
  readonly rows: readonly TypedRow[];
  /** The point P in the last frame (m). */
  readonly tool: Triple<string>;
  /** Position of the base frame in the world (m). */
  readonly place: Triple<string>;
  /** Roll, pitch and yaw of the base frame about the world's x, y and z (in the unit `angles`). */
  readonly turn: Triple<string>;
  /** The rows of J that the task counts; null for those in which the arm moves. */
  readonly task: readonly TaskRow[] | null;
}

/** A row in numbers (rad or m): its constants, and whether the joint variable has a minus sign. */
export type Row = { readonly kind: Kind; readonly isReversed: boolean } & Readonly<Record<Entry, number>>;

/** A vector of a table: the point, or the position or orientation of the base. */
type VectorName = "tool" | "place" | "turn";

export type Numbers = { readonly rows: readonly Row[] } & Readonly<Record<VectorName, Triple<number>>>;

/** The name of a cell in a row or in a vector, such as "rows/0/theta" or "tool/2". */
export type Cell = string;

export const nameRowCell = (row: number, entry: Entry): Cell => `rows/${row}/${entry}`;
export const nameVectorCell = (place: VectorName, axis: number): Cell => `${place}/${axis}`;

/** The errors in invalid cells. */
export type Faults = ReadonlyMap<Cell, Message>;

/** Maximum number of joints, as in `qdot solve`. */
export const MAX_JOINTS = 10;
/** Maximum number of characters of a cell. */
export const MAX_CHARACTERS = 100;
/** Larger numbers in cells (m or the unit of angles) are refused. */
const MAX_VALUE = 1e6;
/** A larger angle in radians is probably meant in degrees. */
const MAX_RADIANS = 7;
/** A larger length in metres is probably meant in millimetres. */
const MAX_PLAUSIBLE_LENGTH = 20;
/** A number this close (rad) to a multiple of 15 degrees is probably this angle in radians, rounded, as is 1.57. */
const ROUNDING_ERROR = 0.002;

export const ZEROS: Triple<string> = ["0", "0", "0"];

/** Return the name of a joint variable as it is typed. */
export const nameVariable = (row: number): string => `q${row + 1}`;

/** Return the entry of a row that the joint variable changes. */
export const findMovingEntry = (kind: Kind): Entry => (kind === "R" ? "theta" : "d");

/** Return the row of a new joint. */
export function makeRow(kind: Kind, row: number): TypedRow {
  const constants = { theta: "0", d: "0", a: "0", alpha: "0" };
  return { kind, ...constants, [findMovingEntry(kind)]: nameVariable(row) };
}

/** Return the row with another kind of joint: the entry with the old joint variable becomes 0. */
export function changeKind(row: TypedRow, kind: Kind, index: number): TypedRow {
  if (row.kind === kind) return row;
  return { ...row, kind, [findMovingEntry(row.kind)]: "0", [findMovingEntry(kind)]: nameVariable(index) };
}

/** Return the rows without one of them; variables of later rows get their new numbers. */
export function removeRow(rows: readonly TypedRow[], index: number): TypedRow[] {
  return rows.filter((_, i) => i !== index).map((row, i) => (i < index ? row : renumber(row, i + 1, i)));
}

function renumber(row: TypedRow, oldIndex: number, newIndex: number): TypedRow {
  const movingEntry = findMovingEntry(row.kind);
  const variable = new RegExp(`\\b(q|theta|θ|d)_?${oldIndex + 1}\\b`, "gu");
  return { ...row, [movingEntry]: row[movingEntry].replace(variable, `$1${newIndex + 1}`) };
}

/** Return the numbers of a table, or its errors cell by cell. */
export function parseTable(table: Table): Numbers | Faults {
  const faults = new Map<Cell, Message>();
  const parseOrFault = <T>(cell: Cell, parse: () => T, fallback: T): T =>
    catchParseError(parse, ({ why }) => {
      faults.set(cell, why);
      return fallback;
    });
  const rows = table.rows.map((row, i) => parseRow(row, i, table.angles, parseOrFault));
  const parseTriple = (place: VectorName): Triple<number> => {
    const [x, y, z] = table[place].map((text, axis) =>
      parseOrFault(nameVectorCell(place, axis), () => parseConstant(text, place === "turn" ? table.angles : null), 0),
    );
    return [x!, y!, z!];
  };
  const numbers = { rows, tool: parseTriple("tool"), place: parseTriple("place"), turn: parseTriple("turn") };
  return faults.size > 0 ? faults : numbers;
}

type CellParser = <T>(cell: Cell, parse: () => T, fallback: T) => T;

function parseRow(row: TypedRow, index: number, angles: Angles, parseOrFault: CellParser): Row {
  const movingEntry = findMovingEntry(row.kind);
  const numbers = { kind: row.kind, theta: 0, d: 0, a: 0, alpha: 0, isReversed: false };
  for (const entry of ENTRIES) {
    const unit = entry === "theta" || entry === "alpha" ? angles : null;
    const cell = nameRowCell(index, entry);
    if (entry !== movingEntry) numbers[entry] = parseOrFault(cell, () => parseConstant(row[entry], unit), 0);
    else {
      const parseEntry = (): VariableEntry => parseVariable(row[entry], row.kind, index, unit);
      [numbers[entry], numbers.isReversed] = parseOrFault(cell, parseEntry, [0, false]);
    }
  }
  return numbers;
}

/** A decimal comma; a cell with brackets may have the comma of a function. */
const DECIMAL_COMMA = /,(?=\d)/gu;
/** A name or sign after a value, which may be a unit; group: the name. */
const TYPED_UNIT = /(?<=[\d.)]|pi|π)\s*(°|\p{L}+)(?![\p{L}\p{N}_(])/gu;

/**
 * Return a cell with a decimal point and without units: values are converted to metres or to the unit of angles.
 * Throws ParseError for a unit of another quantity.
 */
export function normalizeCell(text: string, angles: Angles | null): string {
  const textWithPoint = text.includes("(") ? text : text.replace(DECIMAL_COMMA, ".");
  const textWithoutUnits = textWithPoint.replace(TYPED_UNIT, (typedText, name: string) => {
    const unit = parseUnit(name);
    if (!unit) return typedText;
    if (String(unit.dimension) !== (angles === null ? "0,1,0" : "0,0,0"))
      throw new ParseError(angles === null ? "own.no-length" : "own.no-angle", { unit: name });
    if (angles !== "degrees") return unit.conversion;
    return unit.conversion === "*pi/180" ? "" : `${unit.conversion}*${180 / Math.PI}`;
  });
  return textWithoutUnits.trim() || "0";
}

/** Parse a cell; an empty cell is zero. Throws ParseError. */
function parseCell(text: string, symbols: ReadonlySet<string>, angles: Angles | null): Node {
  if (text.length > MAX_CHARACTERS) throw new ParseError("read.long", { length: text.length, limit: MAX_CHARACTERS });
  return parse(normalizeCell(text, angles), symbols);
}

/** Return a cell's number (rad or m); `angles` is null for a length. Throws ParseError. */
export function parseConstant(text: string, angles: Angles | null): number {
  const tree = parseCell(text, new Set(), angles);
  refuseOtherNames(tree, new Set());
  return evaluateInUnit(tree, {}, angles);
}

/** The constant that is added to a joint variable (rad or m), and whether the variable has a minus sign. */
type VariableEntry = readonly [constant: number, isReversed: boolean];

/** Parse the cell with a row's joint variable: the variable or its negative, plus a constant. Throws ParseError. */
export function parseVariable(text: string, kind: Kind, index: number, angles: Angles | null): VariableEntry {
  const names = [nameVariable(index), nameJoint({ kind }, index)];
  const tree = parseCell(text, new Set(names), angles);
  refuseOtherNames(tree, new Set(names));
  const usedNames = [...findNames(tree)].filter((name) => names.includes(name));
  if (usedNames.length === 0) return [evaluateInUnit(tree, {}, angles), false];
  const evaluateAt = (value: number): number =>
    evaluateRealTree(tree, Object.fromEntries(names.map((name) => [name, value])));
  const [constantPart, valueAtOne, atTwo, distant] = [evaluateAt(0), evaluateAt(1), evaluateAt(2), evaluateAt(-7.5)];
  const slope = valueAtOne - constantPart;
  const isLinear = [atTwo - constantPart - 2 * slope, distant - constantPart + 7.5 * slope].every(
    (bend) => Math.abs(bend) < 1e-9 * (1 + Math.abs(constantPart)),
  );
  if (!isLinear || Math.abs(Math.abs(slope) - 1) > 1e-9)
    throw new ParseError("own.moves", { own: nameVariable(index), offset: EXAMPLES[angles ?? "length"] });
  refuseOtherUnit(constantPart, angles, tree);
  return [convertToRadians(requireFinite(constantPart), angles), slope < 0];
}

/** Examples of a constant that may be added to a joint variable. */
const EXAMPLES = { length: "0.2", degrees: "90", radians: "pi/2" } as const;

function refuseOtherNames(tree: Node, symbols: ReadonlySet<string>): void {
  const unknownNames = [...findNames(tree)].filter((name) => !symbols.has(name));
  if (unknownNames.length > 0) throw new ParseError("own.letters", { names: unknownNames.join(", ") });
}

/** Functions that take or return angles. Their angles would be in radians, also in a table in degrees. */
const ANGLE_FUNCTIONS = /^(a?(sin|cos|tan)|atan2)$/;

function evaluateInUnit(tree: Node, values: SymbolValues, angles: Angles | null): number {
  const value = requireFinite(evaluateRealTree(tree, values));
  refuseOtherUnit(value, angles, tree);
  return convertToRadians(value, angles);
}

const convertToRadians = (value: number, angles: Angles | null): number =>
  angles === "degrees" ? (value * Math.PI) / 180 : value;

function requireFinite(value: number): number {
  if (!Number.isFinite(value)) throw new ParseError("own.not-real");
  if (Math.abs(value) > MAX_VALUE) throw new ParseError("own.out-of-range");
  return value;
}

/** Refuse degrees where radians are expected, and vice versa. */
function refuseOtherUnit(value: number, angles: Angles | null, tree: Node): void {
  const hasPi = anyNode(tree, ({ kind, text }) => kind === "name" && text === "pi");
  const hasAngleFunction = anyNode(tree, ({ kind, text }) => kind === "call" && ANGLE_FUNCTIONS.test(text));
  if (angles === "degrees" && (hasPi || hasAngleFunction)) throw new ParseError("own.in-degrees");
  if (angles === "radians" && Math.abs(value) > MAX_RADIANS && !hasPi)
    throw new ParseError("own.in-radians", { value });
  if (angles === null && hasPi) throw new ParseError("own.pi");
}

/** Return a warning on numbers that are probably in millimetres or radians, or rounded; null if there are none. */
export function findUnitWarning({ rows, tool, turn }: Numbers, angles: Angles): Message | null {
  const lengths = [...rows.flatMap(({ a, d }) => [a, d]), ...tool].map(Math.abs);
  const maxLength = Math.max(...lengths);
  if (maxLength > MAX_PLAUSIBLE_LENGTH)
    return message("own.millimetres", { length: maxLength, metres: maxLength / 1000 });
  for (const angle of [...rows.flatMap(({ theta, alpha }) => [theta, alpha]), ...turn]) {
    const value = angles === "degrees" ? (angle * 180) / Math.PI : angle;
    const degrees = 15 * Math.round((value * 180) / Math.PI / 15);
    const difference = Math.abs(value - (degrees * Math.PI) / 180);
    if (degrees === 0 || Math.abs(degrees) > 360 || difference > ROUNDING_ERROR || difference < 1e-9) continue;
    return angles === "degrees"
      ? message("own.looks-radians", { value, degrees })
      : message("own.rounded", { value, degrees });
  }
  return null;
}

export const isTaskRow = (name: string): name is TaskRow => (ROWS as readonly string[]).includes(name);
