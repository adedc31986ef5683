// Vectors and matrices without commas: entries in lines, in columns with tabs or wide gaps, Matlab's [a b; c d], 0,5; 1,25.
// The rules of ../../../exercises/formula/tables.py: a text is looked at so only where it is of another shape than is due.

import { withoutUnits } from "./notation.js";
import { compiled, pattern, stripped, VOCABULARY, whole } from "./vocabulary.js";

const FRAME = pattern("frame_of_table", "g");
const GAP = pattern("gap_of_table");
const BLANK = pattern("gap_of_matlab");
const GOES_ON = compiled(VOCABULARY.patterns.line_goes_on);
const MATLAB = whole("rows_of_matlab");
const BETWEEN = pattern("between_numbers");
const NUMBER = whole("decimal_with_comma");
const FACTORS = ["", ...new Set(Object.values(VOCABULARY.units))];
/** Characters of a table that is read. */
const MOST = 4000;

type Cells = readonly (readonly string[])[];

/** A table as the text of a list of rows; null for what is none of this shape. */
export function tableText(text: string, rows: number, columns: number): string | null {
  if ([...text].length > MOST) return null;
  const isTable = (cells: Cells): boolean =>
    cells.length === rows && cells.every((row) => row.length === columns && row.every(isWhole));
  const lines = text
    .split("\n")
    .map((line) => line.replace(FRAME, ""))
    .filter((line) => stripped(line) !== "");
  if (lines.length === rows && rows > 1 && !lines.slice(1).some((line) => GOES_ON.test(line))) {
    const cells = lines.map((line) => (columns > 1 ? stripped(line).split(GAP) : [line]));
    if (isTable(cells)) return listed(cells);
  }
  const matlab = MATLAB.exec(stripped(text));
  if (!matlab) return null;
  const filled = (matlab[1] as string).split(";").filter((row) => stripped(row) !== "");
  const found = filled.map((row) => stripped(row).split(BLANK));
  const cells = columns === 1 && found.length === 1 ? (found[0] as string[]).map((cell) => [cell]) : found;
  return isTable(cells) ? listed(cells) : null;
}

/** Numbers that are separated by anything but commas as the text of a list; null for what is none. */
export function numbersText(text: string, count: number): string | null {
  if (count < 2 || [...text].length > MOST) return null;
  let inner = stripped(withoutUnits(text, new Set()));
  const ends = inner.slice(0, 1) + inner.slice(-1);
  if (ends === "()" || ends === "[]" || (ends === "{}" && inner.includes(";"))) inner = inner.slice(1, -1);
  const entries = inner.split(BETWEEN).map(stripped);
  if (entries.length === count && entries.every(isNumber))
    return `[${entries.map((entry) => entry.replace(",", ".")).join(", ")}]`;
  return tableText(text, count, 1);
}

/** Whether a number stands there, alone or times what its unit is worth. */
function isNumber(entry: string): boolean {
  return FACTORS.some(
    (factor) => entry.endsWith(factor) && NUMBER.test(entry.slice(0, entry.length - factor.length)),
  );
}

function listed(cells: Cells): string {
  const rows = cells.map((row) => row.map(stripped).join(", "));
  return `[${(cells[0]?.length === 1 ? rows : rows.map((row) => `[${row}]`)).join(", ")}]`;
}

/** Whether an entry holds no comma or semicolon, and as many brackets closed as open. */
function isWhole(cell: string): boolean {
  const count = (sign: string): number => cell.split(sign).length - 1;
  return (
    !/[,;=]/.test(cell) &&
    ["()", "[]", "{}"].every(([one, other]) => count(one as string) === count(other as string))
  );
}
