// A Jacobian as it was typed, in numbers at any pose: its columns are drawn beside the true ones.

import type { Part, Problem, TaskRow } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { read } from "../read/reader.js";
import { hasBlank, ReadError } from "../read/tree.js";
import { matrixOf, shaped } from "./forms.js";

/** The linear part of each column of a typed Jacobian at a pose (m/s for 1 rad/s or 1 m/s); null if undefined. */
export type OwnColumns = (pose: Readonly<Record<string, number>>) => readonly (readonly number[])[] | null;

const LINEAR: readonly TaskRow[] = ["vx", "vy", "vz"];
const ALL: readonly TaskRow[] = [...LINEAR, "wx", "wy", "wz"];

/** An answer to a question for J as a function of the pose; null for other questions, and if it can't be parsed. */
export function ownColumns(problem: Problem, part: Part, answer: string): OwnColumns | null {
  const { robot, symbols } = problem;
  const rows = { jacobian: robot.task, "geometric-jacobian": ALL }[part.kind];
  if (!rows || part.key.type !== "values" || !answer.trim()) return null;
  const known = new Set(Object.keys(symbols));
  try {
    const matrix = shaped(matrixOf(read(answer, known), known, part.labels, part.key), part.key);
    if ("outcome" in matrix || matrix.length !== rows.length || matrix.flat().some(hasBlank)) return null;
    const given = Object.fromEntries(
      Object.entries(symbols).flatMap(([name, { value }]) => (value === undefined ? [] : [[name, value]])),
    );
    return (pose) => {
      const at = { ...given, ...robot.values, ...pose };
      const columns = robot.joints.map((_, i) =>
        LINEAR.map((name) => {
          const row = rows.indexOf(name);
          const entry = matrix[row]?.[i];
          return entry ? evaluate(entry, at).re : 0;
        }),
      );
      return columns.flat().every(Number.isFinite) ? columns : null;
    };
  } catch (error) {
    if (error instanceof ReadError) return null;
    throw error;
  }
}
