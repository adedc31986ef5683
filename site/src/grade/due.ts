// An answer as it is judged, for what is shown of it while it is typed: a table is read where the shape is another else.

import type { Part } from "../bank.js";
import { read } from "../read/reader.js";
import { numbersText, tableText } from "../read/tables.js";
import { asMatrix, type Node, ReadError } from "../read/tree.js";
import { rightSide } from "./values.js";

/** The tree of an answer to a part. Throws ReadError. */
export function readDue(text: string, known: ReadonlySet<string>, { key, shape }: Part): Node {
  const [rows, columns] = shape ?? [1, 1];
  if (rows * columns === 1 || !["values", "numbers", "direction"].includes(key.type))
    return read(text, known);
  const table = key.type === "numbers" ? numbersText(text, rows) : tableText(text, rows, columns);
  if (table === null) return read(text, known);
  try {
    const tree = read(text, known);
    return isOfShape(rightSide(tree, known), rows, columns) ? tree : read(table, known);
  } catch (error) {
    if (error instanceof ReadError) return read(table, known);
    throw error;
  }
}

function isOfShape(tree: Node, rows: number, columns: number): boolean {
  const found = asMatrix(tree);
  const isRow = columns === 1 && found.length === 1 && found[0]?.length === rows;
  return isRow || (found.length === rows && found[0]?.length === columns);
}
