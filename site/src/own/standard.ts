// Convert a standard or modified table to the standard (distal) table of the same arm, in numbers.
//
// The rules of ../../../exercises/arm/standard_table.py: Rx and Tx of a modified row join the row before. A joint that
// counts in the other direction is a joint about the reversed axis, Rz(-q) = Rx(pi) Rz(q) Rx(-pi).

import { nameJoint, type Robot, ROWS, type TaskRow } from "../bank.js";
import { makeRandomPoses } from "../random.js";
import { type Arm, armOf, stateAt } from "../arm/model.js";
import { add, type Matrix, multiply, type Vec3 } from "../arm/vector.js";
import type { Numbers, Row, Table, Triple } from "./table.js";

/** The pose of the base frame in the world (m). */
type Base = { readonly position: Vec3; readonly rotation: Matrix };

/** Return the arm of a table as a record like those of the bank. */
export function makeRobot(table: Table, numbers: Numbers): Robot {
  const [roll, pitch, yawOfBase] = numbers.turn; // about fixed axes
  const rotation = multiplyMatrices(
    multiplyMatrices(rotateAbout(2, yawOfBase), rotateAbout(1, pitch)),
    rotateAbout(0, roll),
  );
  const typedBase: Base = { position: numbers.place, rotation };
  const isModified = table.convention === "modified-dh";
  const [base, rows] = removeReversals(
    ...(isModified ? shiftRows(typedBase, numbers.rows) : ([typedBase, numbers.rows] as const)),
  );
  const [yaw, tilt, spin] = computeBaseAngles(base.rotation);
  const joints = rows.map((row, i): Robot["joints"][number] => {
    const theta = row.theta + (i === 0 ? spin : 0);
    const variable = nameJoint(row, i);
    const addToVariable = (value: number): string => (value === 0 ? variable : `${variable} + (${value})`);
    return {
      kind: row.kind,
      theta: row.kind === "R" ? addToVariable(theta) : String(theta),
      d: row.kind === "P" ? addToVariable(row.d) : String(row.d),
      a: String(row.a),
      alpha: String(row.alpha),
    };
  });
  const robot: Robot = {
    name: "own",
    title: table.name,
    joints,
    base: { position: writeTriple(base.position), yaw: String(yaw), tilt: String(tilt) },
    point: { frame: joints.length, offset: writeTriple(numbers.tool) },
    task: ROWS.filter((row) => table.task?.includes(row) ?? true),
    values: {},
  };
  return table.task ? robot : { ...robot, task: defaultTask(armOf(robot)) };
}

const writeTriple = ([x, y, z]: Triple<number>): [string, string, string] => [String(x), String(y), String(z)];

/** Return the matrix of the rotation about axis x, y or z (0, 1, 2) by an angle (rad). */
function rotateAbout(axis: 0 | 1 | 2, angle: number): Matrix {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  if (axis === 0) return [[1, 0, 0], [0, c, -s], [0, s, c]]; // prettier-ignore
  if (axis === 1) return [[c, 0, s], [0, 1, 0], [-s, 0, c]]; // prettier-ignore
  return [[c, -s, 0], [s, c, 0], [0, 0, 1]]; // prettier-ignore
}

function multiplyMatrices(left: Matrix, right: Matrix): Matrix {
  return left.map((row) => right[0]!.map((_, j) => row.reduce((sum, value, k) => sum + value * right[k]![j]!, 0)));
}

/** Return the rows of a modified table as those of a standard one: a and alpha move to the row before. */
function shiftRows({ position, rotation }: Base, rows: readonly Row[]): readonly [Base, Row[]] {
  const [first] = rows;
  const base: Base = {
    position: add(position, multiply(rotation, [first!.a, 0, 0]) as unknown as Vec3),
    rotation: multiplyMatrices(rotation, rotateAbout(0, first!.alpha)),
  };
  return [base, rows.map((row, i) => ({ ...row, a: rows[i + 1]?.a ?? 0, alpha: rows[i + 1]?.alpha ?? 0 }))];
}

/** Return the base and the rows of the same arm, in which no joint variable has a minus sign. */
function removeReversals(originalBase: Base, originalRows: readonly Row[]): readonly [Base, readonly Row[]] {
  let base = originalBase;
  const rows = [...originalRows];
  originalRows.forEach(({ isReversed }, i) => {
    if (!isReversed) return;
    const row = rows[i]!;
    rows[i] = { ...row, theta: -row.theta, d: -row.d, alpha: row.alpha - Math.PI, isReversed: false };
    const previous = rows[i - 1];
    if (previous) rows[i - 1] = { ...previous, alpha: previous.alpha + Math.PI };
    else base = { ...base, rotation: multiplyMatrices(base.rotation, rotateAbout(0, Math.PI)) };
  });
  return [base, rows];
}

/** If the sine of the tilt is smaller, the z axes of base and world count as parallel. */
const UPRIGHT_SINE = 1e-12;

/** Return the angles with rotation = Rz(yaw) Rx(tilt) Rz(spin); the spin is added to theta in the first row. */
function computeBaseAngles(rotation: Matrix): readonly [yaw: number, tilt: number, spin: number] {
  const [[xx], [yx, , yz], [zx, zy, zz]] = rotation as unknown as Triple<Vec3>;
  const xz = rotation[0]![2]!;
  const sine = Math.hypot(xz, yz);
  if (sine < UPRIGHT_SINE) return zz > 0 ? [0, 0, Math.atan2(yx, xx)] : [0, Math.PI, Math.atan2(-yx, xx)];
  return [Math.atan2(xz, -yz), Math.atan2(sine, zz), Math.atan2(zx, zy)];
}

/** Entries of J up to this size (m or 1) count as rounding errors. */
const ZERO_TOLERANCE = 1e-6;

/** Return the task rows if none are chosen, by the rule of `default_task` in exercises/robots/robot_file.py. */
function defaultTask(arm: Arm): TaskRow[] {
  const largestByRow = ROWS.map(() => 0);
  for (const pose of makeRandomPoses(3, arm.joints.length, 5)) {
    stateAt(arm, pose).jacobian.forEach((row, k) => {
      largestByRow[k] = Math.max(largestByRow[k]!, ...row.map(Math.abs));
    });
  }
  const movingRows = ROWS.filter((_, k) => largestByRow[k]! > ZERO_TOLERANCE);
  const count = arm.joints.length;
  if (count >= 6 && movingRows.length === ROWS.length) return movingRows;
  if (count === 4 && movingRows.length === 4) return movingRows;
  const linearRows = movingRows.filter((row) => row.startsWith("v"));
  return linearRows.length > 0 ? linearRows : movingRows;
}
