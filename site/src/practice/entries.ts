// Convert the entries of a vector or matrix in its grid to text, and text in any form of a matrix to entries (by rows).

import { readCommasAsPoints } from "../read/points.js";
import { convertTable } from "../read/tables.js";
import { splitIntoRows } from "../read/tree.js";

/** Return entries as the text of a matrix; an empty entry is a blank, and 0,5 in an entry is one number. */
export function writeMatrix(entries: readonly string[], columns: number): string {
  if (entries.every((entry) => !entry.trim())) return "";
  const typedEntries = entries.map((entry) => readCommasAsPoints(entry).trim() || "blank");
  return `[${splitIntoRows(typedEntries, columns)
    .map((row) => `[${row.join(", ")}]`)
    .join(", ")}]`;
}

/** Return the entries of a matrix typed with brackets, or in rows (lines or semicolons); null for other shapes. */
export function parseEntries(text: string, rows: number, columns: number): string[] | null {
  return (
    parseBracketedEntries(text, rows, columns) ??
    parseBracketedEntries(convertTable(text, rows, columns) ?? "", rows, columns)
  );
}

/** Return the entries of a matrix in brackets: [[a, b], [c, d]], [a, b; c, d] or Matrix([…]); null for other texts. */
function parseBracketedEntries(text: string, rows: number, columns: number): string[] | null {
  const content = /^\s*(?:Matrix\(\s*)?\[([\s\S]*)\](?:\s*\))?\s*$/.exec(text)?.[1];
  if (content === undefined) return null;
  const semicolonRows = splitOutside(content, ";");
  const entryRows =
    semicolonRows.length > 1
      ? semicolonRows.map((row) => splitOutside(row, ","))
      : splitOutside(content, ",").map((row) => {
          const entries = /^\[([\s\S]*)\]$/.exec(row)?.[1];
          return entries === undefined ? [row] : splitOutside(entries, ",");
        });
  const hasShape = entryRows.length === rows && entryRows.every((row) => row.length === columns);
  return hasShape ? entryRows.flat().map((entry) => (entry === "blank" ? "" : entry)) : null;
}

/** Return the pieces between separators outside of brackets; a separator at the end is ignored. */
function splitOutside(text: string, separator: string): string[] {
  const pieces = [""];
  let depth = 0;
  for (const sign of text) {
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    if (sign === separator && depth === 0) pieces.push("");
    else pieces[pieces.length - 1] += sign;
  }
  const trimmed = pieces.map((piece) => piece.trim());
  return trimmed.at(-1) === "" ? trimmed.slice(0, -1) : trimmed;
}

/** Return whether a text is a matrix without brackets, a row a line, that still lacks rows. */
export function isUnfinished(text: string, rows: number, columns: number): boolean {
  const isBracketed = /^\s*(?:\w+\s*:?[=:])?\s*(?:[[({]|\w+\()/.test(text);
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  return !isBracketed && lines.length < rows && parseEntries(`[${text}]`, rows, columns) === null;
}
