// The standard (distal) table of an arm that is told by a standard or a modified one, in numbers.
//
// The rules of ../../../exercises/arm/standard_table.py: Rx and Tx of a modified row join the row before it; a joint
// that counts the other way is one about an axis the other way up, Rz(-q) = Rx(pi) Rz(q) Rx(-pi).

import type { Robot, TaskRow } from "../bank.js";
import { type Arm, armOf, ROWS, stateAt } from "../arm/model.js";
import { randomPoses } from "../arm/random.js";
import { add, type Matrix, times, type Vec3 } from "../arm/vector.js";
import type { Numbers, Row, Table, Triple } from "./table.js";

type Base = { readonly position: Vec3; readonly rotation: Matrix };

/** The arm that a table tells, as a record of the bank tells one. */
export function robotOf(table: Table, numbers: Numbers): Robot {
  const home: Base = { position: numbers.place, rotation: turned(numbers.turn) };
  const isModified = table.convention === "modified-dh";
  const [base, rows] = upright(...(isModified ? shifted(home, numbers.rows) : ([home, numbers.rows] as const)));
  const [yaw, tilt, rest] = anglesOf(base.rotation);
  const joints = rows.map((row, i): Robot["joints"][number] => {
    const theta = row.theta + (i === 0 ? rest : 0);
    const own = `${row.kind === "R" ? "theta" : "d"}${i + 1}`;
    const moving = (value: number): string => (value === 0 ? own : `${own} + (${value})`);
    return {
      kind: row.kind,
      theta: row.kind === "R" ? moving(theta) : String(theta),
      d: row.kind === "P" ? moving(row.d) : String(row.d),
      a: String(row.a),
      alpha: String(row.alpha),
    };
  });
  const robot: Robot = {
    name: "own",
    title: table.name,
    joints,
    base: { position: texts(base.position), yaw: String(yaw), tilt: String(tilt) },
    point: { frame: joints.length, offset: texts(numbers.tool) },
    task: ROWS.filter((row) => table.task?.includes(row) ?? true),
    values: {},
  };
  return table.task ? robot : { ...robot, task: usualTask(armOf(robot)) };
}

const texts = ([x, y, z]: Triple<number>): [string, string, string] => [String(x), String(y), String(z)];

/** Rz(yaw) Ry(pitch) Rx(roll), all about the outer axes. */
function turned([roll, pitch, yaw]: Triple<number>): Matrix {
  return product(product(about(2, yaw), about(1, pitch)), about(0, roll));
}

/** The rotation about axis x, y or z (0, 1, 2). */
function about(axis: 0 | 1 | 2, angle: number): Matrix {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  if (axis === 0) return [[1, 0, 0], [0, c, -s], [0, s, c]]; // prettier-ignore
  if (axis === 1) return [[c, 0, s], [0, 1, 0], [-s, 0, c]]; // prettier-ignore
  return [[c, -s, 0], [s, c, 0], [0, 0, 1]]; // prettier-ignore
}

function product(left: Matrix, right: Matrix): Matrix {
  return left.map((row) => right[0]!.map((_, j) => row.reduce((sum, value, k) => sum + value * right[k]![j]!, 0)));
}

/** The rows of a modified table as those of the standard one: their a and alpha stand before their joint. */
function shifted({ position, rotation }: Base, rows: readonly Row[]): readonly [Base, Row[]] {
  const [first] = rows;
  const base: Base = {
    position: add(position, times(rotation, [first!.a, 0, 0]) as unknown as Vec3),
    rotation: product(rotation, about(0, first!.alpha)),
  };
  return [base, rows.map((row, i) => ({ ...row, a: rows[i + 1]?.a ?? 0, alpha: rows[i + 1]?.alpha ?? 0 }))];
}

/** The table without joints that count the other way. */
function upright(home: Base, told: readonly Row[]): readonly [Base, readonly Row[]] {
  let base = home;
  const rows = [...told];
  told.forEach(({ reversed }, i) => {
    if (!reversed) return;
    const row = rows[i]!;
    rows[i] = { ...row, theta: -row.theta, d: -row.d, alpha: row.alpha - Math.PI, reversed: false };
    const before = rows[i - 1];
    if (before) rows[i - 1] = { ...before, alpha: before.alpha + Math.PI };
    else base = { ...base, rotation: product(base.rotation, about(0, Math.PI)) };
  });
  return [base, rows];
}

/** Below this sine an axis counts as upright. */
const UPRIGHT = 1e-12;

/** Angles of Rz(yaw) Rx(tilt) Rz(rest); the last turn joins the first row. */
function anglesOf(rotation: Matrix): readonly [yaw: number, tilt: number, rest: number] {
  const [[xx], [yx, , yz], [zx, zy, zz]] = rotation as unknown as Triple<Vec3>;
  const xz = rotation[0]![2]!;
  const sine = Math.hypot(xz, yz);
  if (sine < UPRIGHT) return zz > 0 ? [0, 0, Math.atan2(yx, xx)] : [0, Math.PI, Math.atan2(-yx, xx)];
  return [Math.atan2(xz, -yz), Math.atan2(sine, zz), Math.atan2(zx, zy)];
}

/** What is no rounding error in an entry of J. */
const CLEARLY = 1e-6;

/** The rows that count where none are named, as `default_task` of exercises/arm/robot_file.py has them. */
function usualTask(arm: Arm): TaskRow[] {
  const most = ROWS.map(() => 0);
  for (const pose of randomPoses(3, arm.joints.length, 5)) {
    stateAt(arm, pose).jacobian.forEach((row, k) => {
      most[k] = Math.max(most[k]!, ...row.map(Math.abs));
    });
  }
  const moving = ROWS.filter((_, k) => most[k]! > CLEARLY);
  const count = arm.joints.length;
  if (count >= 6 && moving.length === ROWS.length) return moving;
  if (count === 4 && moving.length === 4) return moving;
  const linear = moving.filter((row) => row.startsWith("v"));
  return linear.length > 0 ? linear : moving;
}
