// The entries of a vector or matrix in its grid, and the same as a text in any form in which matrices are typed.

import { readCommasAsPoints } from "../read/points.js";
import { tableText } from "../read/tables.js";
import { inRows } from "../read/tree.js";

/** Return entries as the text of a matrix; an empty entry is a blank, and 0,5 in an entry is one number. */
export function matrixText(entries: readonly string[], columns: number): string {
  if (entries.every((entry) => !entry.trim())) return "";
  const filled = entries.map((entry) => readCommasAsPoints(entry).trim() || "blank");
  return `[${inRows(filled, columns)
    .map((row) => `[${row.join(", ")}]`)
    .join(", ")}]`;
}

/** Return the entries of such a text, or of rows separated by lines or semicolons; null for another shape. */
export function entriesOf(text: string, rows: number, columns: number): string[] | null {
  return listedEntries(text, rows, columns) ?? listedEntries(tableText(text, rows, columns) ?? "", rows, columns);
}

function listedEntries(text: string, rows: number, columns: number): string[] | null {
  const inner = /^\s*(?:Matrix\(\s*)?\[([\s\S]*)\](?:\s*\))?\s*$/.exec(text)?.[1];
  if (inner === undefined) return null;
  const byRow = splitOutside(inner, ";");
  const lines =
    byRow.length > 1
      ? byRow.map((row) => splitOutside(row, ","))
      : splitOutside(inner, ",").map((row) => {
          const entries = /^\[([\s\S]*)\]$/.exec(row)?.[1];
          return entries === undefined ? [row] : splitOutside(entries, ",");
        });
  const fits = lines.length === rows && lines.every((row) => row.length === columns);
  return fits ? lines.flat().map((entry) => (entry === "blank" ? "" : entry)) : null;
}

/** Return the pieces between separators outside of brackets; a separator at the end is ignored. */
function splitOutside(text: string, separator: string): string[] {
  const parts = [""];
  let depth = 0;
  for (const sign of text) {
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    if (sign === separator && depth === 0) parts.push("");
    else parts[parts.length - 1] += sign;
  }
  const trimmed = parts.map((piece) => piece.trim());
  return trimmed.at(-1) === "" ? trimmed.slice(0, -1) : trimmed;
}

/** Return whether a matrix typed in lines lacks rows, so that another line is expected. */
export function isUnfinished(text: string, rows: number, columns: number): boolean {
  const isBracketed = /^\s*(?:\w+\s*:?[=:])?\s*(?:[[({]|\w+\()/.test(text);
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  return !isBracketed && lines.length < rows && entriesOf(`[${text}]`, rows, columns) === null;
}
