// The entries of a vector or matrix in its grid, and the same as one text in any form in which matrices are typed.

import { withPoints } from "../read/points.js";
import { tableText } from "../read/tables.js";
import { inRows } from "../read/tree.js";

/** Entries as the text of a matrix; an entry that is empty is a blank, 0,5 in one of them a number. */
export function matrixText(entries: readonly string[], columns: number): string {
  if (entries.every((entry) => !entry.trim())) return "";
  const filled = entries.map((entry) => withPoints(entry).trim() || "blank");
  return `[${inRows(filled, columns)
    .map((row) => `[${row.join(", ")}]`)
    .join(", ")}]`;
}

/** The entries of such a text, or of rows in lines or between semicolons; null if it doesn't have this shape. */
export function entriesOf(text: string, rows: number, columns: number): string[] | null {
  return listedEntries(text, rows, columns) ?? listedEntries(tableText(text, rows, columns) ?? "", rows, columns);
}

function listedEntries(text: string, rows: number, columns: number): string[] | null {
  const inner = /^\s*(?:Matrix\(\s*)?\[([\s\S]*)\](?:\s*\))?\s*$/.exec(text)?.[1];
  if (inner === undefined) return null;
  const byRow = pieces(inner, ";");
  const lines =
    byRow.length > 1
      ? byRow.map((row) => pieces(row, ","))
      : pieces(inner, ",").map((row) => {
          const entries = /^\[([\s\S]*)\]$/.exec(row)?.[1];
          return entries === undefined ? [row] : pieces(entries, ",");
        });
  const fits = lines.length === rows && lines.every((row) => row.length === columns);
  return fits ? lines.flat().map((entry) => (entry === "blank" ? "" : entry)) : null;
}

/** What stands between signs that are in no brackets; a sign at the end has nothing behind it. */
function pieces(text: string, between: string): string[] {
  const found = [""];
  let depth = 0;
  for (const sign of text) {
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    if (sign === between && depth === 0) found.push("");
    else found[found.length - 1] += sign;
  }
  const trimmed = found.map((piece) => piece.trim());
  return trimmed.at(-1) === "" ? trimmed.slice(0, -1) : trimmed;
}

/** Whether rows that are typed in lines are not all there, so that another line is due. */
export function isUnfinished(text: string, rows: number, columns: number): boolean {
  const isBracketed = /^\s*(?:\w+\s*:?[=:])?\s*(?:[[({]|\w+\()/.test(text);
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  return !isBracketed && lines.length < rows && entriesOf(`[${text}]`, rows, columns) === null;
}
