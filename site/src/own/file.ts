// Write the ROBOT.toml of a table for `qdot solve`, which derives formulas for the same arm.

import { ENTRIES, movingEntry, type Table, type Triple, variableOf } from "./table.js";

export function tomlOf(table: Table): string {
  const { name, convention, angles, task, tool, place, turn } = table;
  const isZero = (three: Triple<string>): boolean => three.every((text) => (text.trim() || "0") === "0");
  const base = [
    ...(isZero(place) ? [] : [`position = ${tomlList(place)}`]),
    ...(isZero(turn) ? [] : [`rpy = ${tomlList(turn)}`]),
  ];
  const lines = [
    `name = ${tomlString(name || "my arm")}`,
    ...(convention === "dh" ? [] : [`convention = ${tomlString(convention)}`]),
    ...(angles === "radians" ? [] : [`angles = ${tomlString(angles)}`]),
    ...(task ? [`task = [${task.map(tomlString).join(", ")}]`] : []),
    ...(isZero(tool) ? [] : [`tool = {position = ${tomlList(tool)}}`]),
    ...(base.length > 0 ? [`base = {${base.join(", ")}}`] : []),
  ];
  table.rows.forEach((row, i) => {
    const moving = movingEntry(row.kind);
    lines.push("", "[[joint]]", `kind = "${row.kind}"`);
    for (const entry of ENTRIES)
      lines.push(
        `${entry} = ${tomlString(entry === moving ? withVariableName(row[entry], row.kind, i) : plainCell(row[entry]))}`,
      );
  });
  return `${lines.join("\n")}\n`;
}

/** Return the entry with the joint variable; a number alone is added to the variable. */
function withVariableName(text: string, kind: "R" | "P", index: number): string {
  const typed = plainCell(text);
  const variable = new RegExp(`\\b(q|${kind === "R" ? "theta" : "d"})${index + 1}\\b`, "u");
  if (variable.test(typed)) return typed;
  return typed === "0" ? variableOf(index) : `${variableOf(index)} + (${typed})`;
}

/** Return a cell as ROBOT.toml takes it: ASCII signs, a decimal point, and "0" if it is empty. */
function plainCell(text: string): string {
  const typed = text.replace(/[−–]/gu, "-").replace(/π/gu, "pi").replace(/θ_?/gu, "theta");
  return typed.replace(/^(\s*[-+]?\d*),(\d+\s*)$/u, "$1.$2").trim() || "0";
}

const tomlList = (three: Triple<string>): string => `[${three.map((text) => tomlString(plainCell(text))).join(", ")}]`;

/** Quote a text for TOML. */
const tomlString = (text: string): string => JSON.stringify(text).replace(/\x7f/g, "\\u007f");
