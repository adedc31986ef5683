// The entries of a vector or matrix in its grid, and the same as one text.

import { withPoints } from "../read/points.js";

/** Entries as the text of a matrix; an entry that is empty is a blank, 0,5 in one of them a number. */
export function matrixText(entries: readonly string[], columns: number): string {
  if (entries.every((entry) => !entry.trim())) return "";
  const filled = entries.map((entry) => withPoints(entry).trim() || "blank");
  const rows = Array.from({ length: filled.length / columns }, (_, r) =>
    filled.slice(r * columns, (r + 1) * columns),
  );
  return `[${rows.map((row) => `[${row.join(", ")}]`).join(", ")}]`;
}

/** The entries of such a text, row by row; null where it is none of this shape. */
export function entriesOf(text: string, rows: number, columns: number): string[] | null {
  const inner = /^\s*(?:Matrix\(\s*)?\[([\s\S]*)\](?:\s*\))?\s*$/.exec(text)?.[1];
  if (inner === undefined) return null;
  const lines = pieces(inner).map((row) => {
    const entries = /^\[([\s\S]*)\]$/.exec(row)?.[1];
    return entries === undefined ? [row] : pieces(entries);
  });
  const fits = lines.length === rows && lines.every((row) => row.length === columns);
  return fits ? lines.flat().map((entry) => (entry === "blank" ? "" : entry)) : null;
}

/** What stands between the commas that are in no brackets; a comma at the end has nothing behind it. */
function pieces(text: string): string[] {
  const found = [""];
  let depth = 0;
  for (const sign of text) {
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    if (sign === "," && depth === 0) found.push("");
    else found[found.length - 1] += sign;
  }
  const trimmed = found.map((piece) => piece.trim());
  return trimmed.at(-1) === "" ? trimmed.slice(0, -1) : trimmed;
}
