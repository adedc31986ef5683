// The angles of a table in the other unit: 90 for pi/2, and pi/2 for 90. What is wrong in a cell stays as it is typed.

import { ReadError } from "../read/tree.js";
import { type Angles, constant, type Table, type TypedRow, variableOf, withVariable } from "./table.js";

/** Digits of an angle that is no simple part of a turn. */
const DIGITS = 9;
/** Parts of pi by which angles are written. */
const PARTS = [1, 2, 3, 4, 5, 6, 8, 9, 10, 12];

/** A table with its angles in a unit. */
export function inAngles(table: Table, angles: Angles): Table {
  if (table.angles === angles) return table;
  const cell = (text: string): string => kept(text, () => written(constant(text, table.angles), angles));
  const row = (each: TypedRow, i: number): TypedRow => ({
    ...each,
    alpha: cell(each.alpha),
    theta: each.kind === "P" ? cell(each.theta) : kept(each.theta, () => turning(each.theta, i, table.angles, angles)),
  });
  const [x, y, z] = table.turn;
  return { ...table, angles, rows: table.rows.map(row), turn: [cell(x), cell(y), cell(z)] };
}

/** What is worked out of a cell; the cell itself where it is empty or can't be parsed. */
function kept(text: string, worked: () => string): string {
  if (text.trim() === "") return text;
  try {
    return worked();
  } catch (error) {
    if (error instanceof ReadError) return text;
    throw error;
  }
}

/** A revolute joint's variable with what is added to it. */
function turning(text: string, index: number, from: Angles, to: Angles): string {
  const [rest, reversed] = withVariable(text, "R", index, from);
  const own = `${reversed ? "-" : ""}${variableOf(index)}`;
  if (rest === 0) return own;
  return `${own} ${rest < 0 ? "-" : "+"} ${written(Math.abs(rest), to)}`;
}

/** An angle (rad) as it is typed in a unit: in radians as a part of pi where it is one. */
function written(angle: number, angles: Angles): string {
  if (angles === "degrees") return short((angle * 180) / Math.PI);
  const part = PARTS.find((each) => isWhole((angle / Math.PI) * each));
  const times = Math.round((angle / Math.PI) * (part ?? 1));
  if (part === undefined || times === 0) return short(angle);
  const above = Math.abs(times) === 1 ? "pi" : `${Math.abs(times)}*pi`;
  return `${times < 0 ? "-" : ""}${above}${part === 1 ? "" : `/${part}`}`;
}

const short = (value: number): string => String(Number(value.toPrecision(DIGITS)) + 0);
const isWhole = (value: number): boolean => Math.abs(value - Math.round(value)) < 1e-8;
