// Convert the angles of a table to the other unit: 90 for pi/2, and pi/2 for 90. Invalid cells stay unchanged.

import { catchParseError } from "../read/tree.js";
import { type Angles, parseConstant, type Table, type TypedRow, nameVariable, parseVariable } from "./table.js";

/** Significant digits of an angle that is not a simple fraction of pi. */
const DIGITS = 9;
/** Denominators of the fractions of pi by which angles are written. */
const DENOMINATORS = [1, 2, 3, 4, 5, 6, 8, 9, 10, 12];

/** Return a table with its angles in a unit. */
export function convertAngles(table: Table, angles: Angles): Table {
  if (table.angles === angles) return table;
  const convertConstant = (text: string): string =>
    convertCell(text, () => writeAngle(parseConstant(text, table.angles), angles));
  const convertRow = (typedRow: TypedRow, i: number): TypedRow => ({
    ...typedRow,
    alpha: convertConstant(typedRow.alpha),
    theta:
      typedRow.kind === "P"
        ? convertConstant(typedRow.theta)
        : convertCell(typedRow.theta, () => convertTheta(typedRow.theta, i, table.angles, angles)),
  });
  const [x, y, z] = table.turn;
  return {
    ...table,
    angles,
    rows: table.rows.map(convertRow),
    turn: [convertConstant(x), convertConstant(y), convertConstant(z)],
  };
}

/** Return the converted text of a cell; the cell itself if it is empty or can't be parsed. */
const convertCell = (text: string, convert: () => string): string =>
  text.trim() === "" ? text : catchParseError(convert, () => text);

/** Return the theta of a revolute joint, its variable plus a constant, in another unit. */
function convertTheta(text: string, index: number, oldUnit: Angles, newUnit: Angles): string {
  const [constant, isReversed] = parseVariable(text, "R", index, oldUnit);
  const variable = `${isReversed ? "-" : ""}${nameVariable(index)}`;
  if (constant === 0) return variable;
  return `${variable} ${constant < 0 ? "-" : "+"} ${writeAngle(Math.abs(constant), newUnit)}`;
}

/** Return an angle (rad) as it is typed in a unit; in radians as a fraction of pi if it is one. */
function writeAngle(angle: number, angles: Angles): string {
  if (angles === "degrees") return writeNumber((angle * 180) / Math.PI);
  const denominator = DENOMINATORS.find((number) => isWhole((angle / Math.PI) * number));
  const numerator = Math.round((angle / Math.PI) * (denominator ?? 1));
  if (denominator === undefined || numerator === 0) return writeNumber(angle);
  const numeratorText = Math.abs(numerator) === 1 ? "pi" : `${Math.abs(numerator)}*pi`;
  return `${numerator < 0 ? "-" : ""}${numeratorText}${denominator === 1 ? "" : `/${denominator}`}`;
}

const writeNumber = (value: number): string => String(Number(value.toPrecision(DIGITS)) + 0);
const isWhole = (value: number): boolean => Math.abs(value - Math.round(value)) < 1e-8;
