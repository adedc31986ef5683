// The arm in numbers: frames, point P, Jacobian, determinant and singular values at a pose. Needs no page.
//
// Standard (distal) DH table: T_i = Rz(theta) Tz(d) Tx(a) Rx(alpha), after the base's position, yaw about z and tilt
// about x. z_{i-1} is the axis of joint i; p*_{i-1} points from O_{i-1} to the point of interest P. World frame; the
// rows of the 6 x n Jacobian are vx vy vz wx wy wz. Follows ../../../exercises/arm/kinematics.py (NumericChain).

import { nameJoint, type NamedPose, type Robot, ROWS } from "../bank.js";
import { parse } from "../read/reader.js";
import { evaluateRealTree } from "../read/real.js";
import { singularValues } from "./svd.js";
import { add, addScaled, cross, determinant, type Matrix, norm, subtract, type Vec3, ZERO } from "./vector.js";

/** A pose: as on the page, the values of all joint variables theta_i (rad) or d_i (m), without the table's offsets. */
export type Pose = readonly number[];

/** The axes of a frame (unit vectors), and its origin (m), in the world frame. */
export type Frame = { readonly x: Vec3; readonly y: Vec3; readonly z: Vec3; readonly o: Vec3 };

/** A joint's row of the table (m, rad). */
export interface Joint {
  readonly kind: "R" | "P";
  /** The name of the joint variable. */
  readonly name: string;
  /** The constant added to the joint variable, and the constant in the other column of theta and d. */
  readonly offset: number;
  readonly otherConstant: number;
  readonly a: number;
  readonly alpha: number;
  /** The table's texts for a and d, which label the lengths in a drawing; d is empty for a prismatic joint. */
  readonly labels: { readonly a: string; readonly d: string };
}

export interface Arm {
  readonly joints: readonly Joint[];
  readonly base: Frame;
  /** The point P: its coordinates `offset` in frame number `frame`. */
  readonly point: { readonly frame: number; readonly offset: Vec3 };
  /** The rows of the Jacobian that the task counts, as indices into `ROWS`. */
  readonly task: readonly number[];
  /** Poses in which prismatic joints go beyond their usual range, which must still be shown. */
  readonly shownPoses?: readonly Pose[];
  /** The table's texts for the coordinates of the base's position and of the point's offset, if known. */
  readonly labels?: Readonly<Record<"base" | "offset", readonly [string, string, string]>>;
}

/** The arm at a pose. `corners[i-1]` is O_{i-1} + d_i z_{i-1}; `jacobian` is 6 x n, `taskJacobian` its task rows. */
export interface State {
  readonly pose: Pose;
  readonly frames: readonly Frame[];
  readonly corners: readonly Vec3[];
  readonly point: Vec3;
  readonly jacobian: Matrix;
  readonly taskJacobian: Matrix;
}

/**
 * `det` is null if J is not square; `volume` is the product of the singular values `sigma` (largest first); `ratio` is
 * the least of these divided by the largest, with lengths in units of the reach: otherwise,
 * it would depend on the unit of length if a matrix contains metres and radians.
 */
export interface Measures {
  readonly det: number | null;
  readonly volume: number;
  readonly sigma: readonly number[];
  readonly minSigma: number;
  readonly ratio: number;
}

const WORLD: Frame = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], o: ZERO };

/** Return the arm of a robot's table. Throws ParseError for an entry that can't be parsed. */
export function armOf(robot: Robot): Arm {
  const names = robot.joints.map(nameJoint);
  const knownNames = new Set([...names, ...Object.keys(robot.values)]);
  const zeros = Object.fromEntries(names.map((name) => [name, 0]));
  const number = (text: string): number => evaluateRealTree(parse(text, knownNames), { ...zeros, ...robot.values });
  const vector = ([x, y, z]: readonly [string, string, string]): Vec3 => [number(x), number(y), number(z)];
  const { base, point } = robot;
  const orientation = nextFrame(WORLD, number(base.yaw), 0, 0, number(base.tilt));
  return {
    joints: robot.joints.map((row, i) => ({
      kind: row.kind,
      name: names[i]!,
      offset: number(row.kind === "R" ? row.theta : row.d),
      otherConstant: number(row.kind === "R" ? row.d : row.theta),
      a: number(row.a),
      alpha: number(row.alpha),
      labels: { a: row.a, d: row.kind === "R" ? row.d : "" },
    })),
    base: { ...orientation, o: vector(base.position) },
    point: { frame: point.frame, offset: vector(point.offset) },
    task: robot.task.map((row) => ROWS.indexOf(row)),
    labels: { base: base.position, offset: point.offset },
  };
}

/** Return the values of a pose by the names of the joints. */
export function namedPose(arm: Arm, pose: Pose): NamedPose {
  return Object.fromEntries(arm.joints.map(({ name }, i) => [name, pose[i]!]));
}

/** Return the frame after Rz(theta) Tz(d) Tx(a) Rx(alpha). */
function nextFrame({ x, y, z, o }: Frame, theta: number, d: number, a: number, alpha: number): Frame {
  const [ct, st, ca, sa] = [Math.cos(theta), Math.sin(theta), Math.cos(alpha), Math.sin(alpha)];
  const x1 = combine(x, ct, y, st);
  const side = combine(x, -st, y, ct);
  return { x: x1, y: combine(side, ca, z, sa), z: combine(side, -sa, z, ca), o: addScaled(addScaled(o, z, d), x1, a) };
}

/** Return s a + t b. */
function combine(a: Vec3, s: number, b: Vec3, t: number): Vec3 {
  return [a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t];
}

/** Return a vector in world coordinates, given its coordinates in a frame. */
export function fromFrame(frame: Frame, [u, v, w]: Vec3): Vec3 {
  return add(combine(frame.x, u, frame.y, v), combine(frame.z, w, ZERO, 0));
}

/** Return theta_i and d_i of a row for a value of its joint variable. */
export function thetaAndD(joint: Joint, value: number): readonly [theta: number, d: number] {
  const total = value + joint.offset;
  return joint.kind === "R" ? [total, joint.otherConstant] : [joint.otherConstant, total];
}

/** Return where the arm is in a pose, without its Jacobian. */
export function pointsAt(arm: Arm, pose: Pose): Pick<State, "frames" | "corners" | "point"> {
  const frames: Frame[] = [arm.base];
  const corners: Vec3[] = [];
  arm.joints.forEach((joint, i) => {
    const previous = frames[i]!;
    const [theta, d] = thetaAndD(joint, pose[i] ?? 0);
    corners.push(addScaled(previous.o, previous.z, d));
    frames.push(nextFrame(previous, theta, d, joint.a, joint.alpha));
  });
  const lastFrame = frames[arm.point.frame]!;
  return { frames, corners, point: add(lastFrame.o, fromFrame(lastFrame, arm.point.offset)) };
}

export function stateAt(arm: Arm, pose: Pose): State {
  const { frames, corners, point } = pointsAt(arm, pose);
  const columns = arm.joints.map((joint, i) => {
    const { z, o } = frames[i]!;
    const movesPoint = i < arm.point.frame;
    const isRevolute = joint.kind === "R";
    const linear = !movesPoint ? ZERO : isRevolute ? cross(z, subtract(point, o)) : z;
    return [...linear, ...(isRevolute ? z : ZERO)];
  });
  const jacobian = ROWS.map((_, row) => columns.map((column) => column[row]!));
  return { pose, frames, corners, point, jacobian, taskJacobian: arm.task.map((row) => jacobian[row]!) };
}

export function measuresOf(arm: Arm, { taskJacobian }: State): Measures {
  const sigma = singularValues(taskJacobian);
  const comparedSigma = mixesUnits(arm) ? singularValues(withoutUnits(arm, taskJacobian)) : sigma;
  const [maxSigma, minSigma] = [comparedSigma[0] ?? 0, comparedSigma.at(-1) ?? 0];
  return {
    det: taskJacobian.length === (taskJacobian[0]?.length ?? 0) ? determinant(taskJacobian) : null,
    volume: sigma.reduce((product, value) => product * value, 1),
    sigma,
    minSigma: sigma.at(-1) ?? 0,
    ratio: maxSigma > 0 ? minSigma / maxSigma : 0,
  };
}

/** Return a task Jacobian whose velocities and prismatic joints are measured in shares of the reach. */
function withoutUnits(arm: Arm, taskJacobian: Matrix): Matrix {
  const reach = reachOf(arm);
  return taskJacobian.map((row, k) =>
    row.map((value, i) => (value * (arm.joints[i]!.kind === "P" ? reach : 1)) / (arm.task[k]! < 3 ? reach : 1)),
  );
}

/** Return det J if J is square, else the product of the singular values, sqrt(det(J J^T)). */
export function signedVolume(arm: Arm, pose: Pose): number {
  const { taskJacobian } = stateAt(arm, pose);
  if (taskJacobian.length === arm.joints.length) return determinant(taskJacobian);
  return singularValues(taskJacobian).reduce((product, value) => product * value, 1);
}

/** Return the vectors p*_i from O_i to P, for the frames i up to the one in which P is fixed. */
export function pStar(arm: Arm, state: State): readonly Vec3[] {
  return state.frames.slice(0, arm.point.frame + 1).map((frame) => subtract(state.point, frame.o));
}

/** Return the total length of all links (m), the scale for distances and drawings. */
export function reachOf(arm: Arm): number {
  const links = arm.joints.map((joint) => norm([joint.a, joint.kind === "R" ? joint.otherConstant : 0]));
  const fixedLength = links.reduce((sum, value) => sum + value, norm(arm.point.offset));
  const prismaticCount = arm.joints.filter((joint) => joint.kind === "P").length;
  return fixedLength + prismaticCount * (fixedLength > 0 ? longestPartOf(arm) : 0.4) || 0.4;
}

/** Return whether the task counts linear and angular velocities: then singular values depend on the unit of length. */
export const isMixed = (arm: Arm): boolean => arm.task.some((row) => row < 3) && arm.task.some((row) => row > 2);

/** Return whether the entries of J have different units. */
export const mixesUnits = (arm: Arm): boolean => isMixed(arm) || new Set(arm.joints.map(({ kind }) => kind)).size > 1;

/** Return the longest part of the arm (m), the scale for its prismatic joints; 0.4 if all lengths are zero. */
export function longestPartOf(arm: Arm): number {
  const parts = arm.joints.flatMap((joint) => [joint.a, joint.kind === "R" ? joint.otherConstant : 0]);
  const shortest = arm.joints.some((joint) => joint.kind === "P") ? 0.3 : 0; // so that a prismatic joint is visible
  return Math.max(shortest, ...[...parts, ...arm.point.offset].map(Math.abs)) || 0.4;
}

/** Return the columns of J drawn as arrows at P: linear parts, or angular parts if the task is purely angular. */
export function arrowsOf(arm: Arm, state: State): { readonly isAngular: boolean; readonly columns: readonly Vec3[] } {
  const isAngular = arm.task.every((row) => row > 2);
  const first = isAngular ? 3 : 0;
  const columns = arm.joints.map((_, j): Vec3 => {
    const [x, y, z] = [0, 1, 2].map((k) => state.jacobian[first + k]![j]!);
    return [x!, y!, z!];
  });
  return { isAngular, columns };
}
