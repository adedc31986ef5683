// Write the ROBOT.toml of a table for `qdot solve`, which derives formulas for the same arm.

import { catchParseError } from "../read/tree.js";
import {
  type Angles,
  ENTRIES,
  findMovingEntry,
  nameVariable,
  normalizeCell,
  type Table,
  type Triple,
} from "./table.js";

export function writeToml(table: Table): string {
  const { name, convention, angles, task, tool, place, turn } = table;
  const isZero = (triple: Triple<string>): boolean => triple.every((text) => (text.trim() || "0") === "0");
  const base = [
    ...(isZero(place) ? [] : [`position = ${writeTomlList(place, null)}`]),
    ...(isZero(turn) ? [] : [`rpy = ${writeTomlList(turn, angles)}`]),
  ];
  const lines = [
    `name = ${quoteForToml(name || "my arm")}`,
    ...(convention === "dh" ? [] : [`convention = ${quoteForToml(convention)}`]),
    ...(angles === "radians" ? [] : [`angles = ${quoteForToml(angles)}`]),
    ...(task ? [`task = [${task.map(quoteForToml).join(", ")}]`] : []),
    ...(isZero(tool) ? [] : [`tool = {position = ${writeTomlList(tool, null)}}`]),
    ...(base.length > 0 ? [`base = {${base.join(", ")}}`] : []),
  ];
  table.rows.forEach((row, i) => {
    const movingEntry = findMovingEntry(row.kind);
    lines.push("", "[[joint]]", `kind = "${row.kind}"`);
    for (const entry of ENTRIES) {
      const typed = writePlainly(row[entry], entry === "theta" || entry === "alpha" ? angles : null);
      const cell = entry === movingEntry ? addVariableName(typed, row.kind, i) : typed;
      lines.push(`${entry} = ${quoteForToml(cell)}`);
    }
  });
  return `${lines.join("\n")}\n`;
}

/** Return the entry with the joint variable; a number alone is added to the variable. */
function addVariableName(typed: string, kind: "R" | "P", index: number): string {
  const variable = new RegExp(`\\b(q|${kind === "R" ? "theta" : "d"})${index + 1}\\b`, "u");
  if (variable.test(typed)) return typed;
  return typed === "0" ? nameVariable(index) : `${nameVariable(index)} + (${typed})`;
}

/** Return a cell as ROBOT.toml takes it: ASCII signs, a decimal point, no units, and "0" if it is empty. */
function writePlainly(text: string, angles: Angles | null): string {
  const plainText = text.replace(/[−–]/gu, "-").replace(/π/gu, "pi").replace(/θ_?/gu, "theta");
  return catchParseError(
    () => normalizeCell(plainText, angles),
    () => plainText.trim(),
  );
}

const writeTomlList = (triple: Triple<string>, angles: Angles | null): string =>
  `[${triple.map((text) => quoteForToml(writePlainly(text, angles))).join(", ")}]`;

/** Quote a text for TOML. */
const quoteForToml = (text: string): string => JSON.stringify(text).replace(/\x7f/g, "\\u007f");
