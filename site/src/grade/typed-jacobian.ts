// A typed Jacobian as numbers at any pose: its columns are drawn beside the true ones.

import { type NamedPose, type Part, type Problem, ROWS } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { parse } from "../read/reader.js";
import { catchParseError, hasBlank } from "../read/tree.js";
import { buildMatrix, checkShape } from "./forms.js";
import { isVerdict } from "./verdict.js";

/** A function that returns vx, vy, vz of each column of J at a pose (m/s at unit joint rate); null if undefined. */
export type ColumnsAt = (pose: NamedPose) => readonly (readonly number[])[] | null;

const LINEAR_ROWS = ROWS.slice(0, 3);

/** Return an answer to a question for J as a function of the pose; null for other questions or invalid answers. */
export function parseTypedColumns(problem: Problem, part: Part, answer: string): ColumnsAt | null {
  const { robot, symbols } = problem;
  const { key } = part;
  const rowNames = { jacobian: robot.task, "geometric-jacobian": ROWS }[part.kind];
  if (!rowNames || key.type !== "values" || !answer.trim()) return null;
  const symbolNames = new Set(Object.keys(symbols));
  return catchParseError(
    () => {
      const matrix = checkShape(buildMatrix(parse(answer, symbolNames), symbolNames, part.labels, key), key);
      if (isVerdict(matrix) || matrix.length !== rowNames.length || matrix.flat().some(hasBlank)) return null;
      const symbolValues = Object.fromEntries(
        Object.entries(symbols).flatMap(([name, { value }]) => (value === undefined ? [] : [[name, value]])),
      );
      return (pose) => {
        const values = { ...symbolValues, ...robot.values, ...pose };
        const columns = robot.joints.map((_, i) =>
          LINEAR_ROWS.map((name) => {
            const entry = matrix[rowNames.indexOf(name)]?.[i];
            return entry ? evaluate(entry, values).re : 0;
          }),
        );
        return columns.flat().every(Number.isFinite) ? columns : null;
      };
    },
    () => null,
  );
}
