// Convert the angles of a table to the other unit: 90 for pi/2, and pi/2 for 90. Invalid cells stay unchanged.

import { catchParseError } from "../read/tree.js";
import { type Angles, parseConstant, type Table, type TypedRow, variableOf, parseVariable } from "./table.js";

/** Significant digits of an angle that is no simple fraction of pi. */
const DIGITS = 9;
/** Denominators of the fractions of pi by which angles are written. */
const DENOMINATORS = [1, 2, 3, 4, 5, 6, 8, 9, 10, 12];

/** Return a table with its angles in a unit. */
export function withAnglesIn(table: Table, angles: Angles): Table {
  if (table.angles === angles) return table;
  const cell = (text: string): string => convertCell(text, () => angleText(parseConstant(text, table.angles), angles));
  const row = (typedRow: TypedRow, i: number): TypedRow => ({
    ...typedRow,
    alpha: cell(typedRow.alpha),
    theta:
      typedRow.kind === "P"
        ? cell(typedRow.theta)
        : convertCell(typedRow.theta, () => convertTheta(typedRow.theta, i, table.angles, angles)),
  });
  const [x, y, z] = table.turn;
  return { ...table, angles, rows: table.rows.map(row), turn: [cell(x), cell(y), cell(z)] };
}

/** Return the converted text of a cell; the cell itself if it is empty or can't be parsed. */
const convertCell = (text: string, convert: () => string): string =>
  text.trim() === "" ? text : catchParseError(convert, () => text);

/** Return the theta of a revolute joint, its variable plus a constant, in another unit. */
function convertTheta(text: string, index: number, from: Angles, to: Angles): string {
  const [rest, reversed] = parseVariable(text, "R", index, from);
  const variable = `${reversed ? "-" : ""}${variableOf(index)}`;
  if (rest === 0) return variable;
  return `${variable} ${rest < 0 ? "-" : "+"} ${angleText(Math.abs(rest), to)}`;
}

/** Return an angle (rad) as it is typed in a unit; in radians as a fraction of pi if it is one. */
function angleText(angle: number, angles: Angles): string {
  if (angles === "degrees") return shortNumber((angle * 180) / Math.PI);
  const denominator = DENOMINATORS.find((number) => isWhole((angle / Math.PI) * number));
  const times = Math.round((angle / Math.PI) * (denominator ?? 1));
  if (denominator === undefined || times === 0) return shortNumber(angle);
  const above = Math.abs(times) === 1 ? "pi" : `${Math.abs(times)}*pi`;
  return `${times < 0 ? "-" : ""}${above}${denominator === 1 ? "" : `/${denominator}`}`;
}

const shortNumber = (value: number): string => String(Number(value.toPrecision(DIGITS)) + 0);
const isWhole = (value: number): boolean => Math.abs(value - Math.round(value)) < 1e-8;
