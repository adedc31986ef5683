// The arm in numbers: frames, point of interest, Jacobian, determinant and singular values at a pose. Touches no page.
//
// Standard (distal) DH table: T_i = Rz(theta) Tz(d) Tx(a) Rx(alpha), after the base's position, yaw about z and tilt
// about x; z_{i-1} is the axis of joint i and p*_{i-1} goes from O_{i-1} to the point of interest P. World frame; rows
// of the 6 x n Jacobian are vx vy vz wx wy wz. Follows ../../../exercises/arm/kinematics.py (NumericChain).

import type { NamedPose, Robot } from "../bank.js";
import { read } from "../read/reader.js";
import { realValue } from "../read/real.js";
import { singularValues } from "./svd.js";
import { add, along, cross, determinant, type Matrix, norm, subtract, type Vec3, ZERO } from "./vector.js";

export const ROWS = ["vx", "vy", "vz", "wx", "wy", "wz"] as const;

/** A pose: the joint variables theta_i (rad) or d_i (m), without the offsets that the table adds. */
export type Pose = readonly number[];

export type Frame = { readonly x: Vec3; readonly y: Vec3; readonly z: Vec3; readonly o: Vec3 };

/** A joint's row of the table: `offset` is added to its variable; `other` is the constant d or theta. */
export interface Joint {
  readonly kind: "R" | "P";
  readonly name: string;
  readonly offset: number;
  readonly other: number;
  readonly a: number;
  readonly alpha: number;
  /** What the table has for a and d: a letter or a number, by which they are called in a drawing. */
  readonly called: { readonly a: string; readonly d: string };
}

export interface Arm {
  readonly joints: readonly Joint[];
  readonly base: Frame;
  readonly point: { readonly frame: number; readonly offset: Vec3 };
  readonly task: readonly number[];
  /** Poses with slides further out than usual, which are shown all the same. */
  readonly shown?: readonly Pose[];
  /** What the base's position and the point's offset are called, coordinate by coordinate, where that is told. */
  readonly called?: Readonly<Record<"base" | "offset", readonly [string, string, string]>>;
}

/** The arm at a pose. `corners[i-1]` is O_{i-1} + d_i z_{i-1}; `jacobian` is 6 x n, `counted` the rows of the task. */
export interface State {
  readonly pose: Pose;
  readonly frames: readonly Frame[];
  readonly corners: readonly Vec3[];
  readonly point: Vec3;
  readonly jacobian: Matrix;
  readonly counted: Matrix;
}

/** `det` is null where J is not square; `volume` is the product of the singular values; `ratio` is least to largest. */
export interface Measures {
  readonly det: number | null;
  readonly volume: number;
  readonly sigma: readonly number[];
  readonly least: number;
  readonly ratio: number;
}

const WORLD: Frame = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], o: ZERO };

/** The numbers of a robot's table. Throws ReadError for an entry that is no expression. */
export function armOf(robot: Robot): Arm {
  const names = robot.joints.map((row, i) => `${row.kind === "R" ? "theta" : "d"}${i + 1}`);
  const known = new Set([...names, ...Object.keys(robot.values)]);
  const zeros = Object.fromEntries(names.map((name) => [name, 0]));
  const number = (text: string): number => realValue(read(text, known), { ...zeros, ...robot.values });
  const vector = ([x, y, z]: readonly [string, string, string]): Vec3 => [number(x), number(y), number(z)];
  const { base, point } = robot;
  const turned = stepped(WORLD, number(base.yaw), 0, 0, number(base.tilt));
  return {
    joints: robot.joints.map((row, i) => ({
      kind: row.kind,
      name: names[i]!,
      offset: number(row.kind === "R" ? row.theta : row.d),
      other: number(row.kind === "R" ? row.d : row.theta),
      a: number(row.a),
      alpha: number(row.alpha),
      called: { a: row.a, d: row.kind === "R" ? row.d : "" },
    })),
    base: { ...turned, o: vector(base.position) },
    point: { frame: point.frame, offset: vector(point.offset) },
    task: robot.task.map((row) => ROWS.indexOf(row)),
    called: { base: base.position, offset: point.offset },
  };
}

/** A pose by the names of the joints. */
export function namedPose(arm: Arm, pose: Pose): NamedPose {
  return Object.fromEntries(arm.joints.map(({ name }, i) => [name, pose[i]!]));
}

/** The first joints of an arm alone, with a point fixed in the last of their frames. */
export function firstJoints(arm: Arm, count: number, offset: Vec3, task: readonly number[]): Arm {
  return { ...arm, joints: arm.joints.slice(0, count), point: { frame: count, offset }, task };
}

/** The frame after Rz(theta) Tz(d) Tx(a) Rx(alpha) from another. */
function stepped({ x, y, z, o }: Frame, theta: number, d: number, a: number, alpha: number): Frame {
  const [ct, st, ca, sa] = [Math.cos(theta), Math.sin(theta), Math.cos(alpha), Math.sin(alpha)];
  const x1 = mixed(x, ct, y, st);
  const side = mixed(x, -st, y, ct);
  return { x: x1, y: mixed(side, ca, z, sa), z: mixed(side, -sa, z, ca), o: along(along(o, z, d), x1, a) };
}

function mixed(a: Vec3, s: number, b: Vec3, t: number): Vec3 {
  return [a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t];
}

/** A vector's coordinates in a frame, as a vector of the world. */
export function fromFrame(frame: Frame, [u, v, w]: Vec3): Vec3 {
  return add(mixed(frame.x, u, frame.y, v), mixed(frame.z, w, ZERO, 0));
}

/** theta_i and d_i of a row at a value of its variable. */
export function entries(joint: Joint, value: number): readonly [theta: number, d: number] {
  const own = value + joint.offset;
  return joint.kind === "R" ? [own, joint.other] : [joint.other, own];
}

/** Where the arm is in a pose, without how it moves there. */
export function placesAt(arm: Arm, pose: Pose): Pick<State, "frames" | "corners" | "point"> {
  const frames: Frame[] = [arm.base];
  const corners: Vec3[] = [];
  arm.joints.forEach((joint, i) => {
    const before = frames[i]!;
    const [theta, d] = entries(joint, pose[i] ?? 0);
    corners.push(along(before.o, before.z, d));
    frames.push(stepped(before, theta, d, joint.a, joint.alpha));
  });
  const carrier = frames[arm.point.frame]!;
  return { frames, corners, point: add(carrier.o, fromFrame(carrier, arm.point.offset)) };
}

export function stateAt(arm: Arm, pose: Pose): State {
  const { frames, corners, point } = placesAt(arm, pose);
  const columns = arm.joints.map((joint, i) => {
    const { z, o } = frames[i]!;
    const moves = i < arm.point.frame;
    const turns = joint.kind === "R";
    const linear = !moves ? ZERO : turns ? cross(z, subtract(point, o)) : z;
    return [...linear, ...(turns ? z : ZERO)];
  });
  const jacobian = ROWS.map((_, row) => columns.map((column) => column[row]!));
  return { pose, frames, corners, point, jacobian, counted: arm.task.map((row) => jacobian[row]!) };
}

export function measuresOf({ counted }: State): Measures {
  const sigma = singularValues(counted);
  const [most, least] = [sigma[0] ?? 0, sigma[sigma.length - 1] ?? 0];
  return {
    det: counted.length === (counted[0]?.length ?? 0) ? determinant(counted) : null,
    volume: sigma.reduce((product, value) => product * value, 1),
    sigma,
    least,
    ratio: most > 0 ? least / most : 0,
  };
}

/** det J where J is square, else the product of the singular values, sqrt(det(J J^T)). */
export function signedVolume(arm: Arm, pose: Pose): number {
  const { counted } = stateAt(arm, pose);
  if (counted.length === arm.joints.length) return determinant(counted);
  return singularValues(counted).reduce((product, value) => product * value, 1);
}

/** p*_i, from O_i to the point, for the frames i that come before the point's own or are it. */
export function pStar(arm: Arm, state: State): readonly Vec3[] {
  return state.frames.slice(0, arm.point.frame + 1).map((frame) => subtract(state.point, frame.o));
}

/** Length of all links one after another (m): against it distances are judged, and drawings scaled. */
export function reachOf(arm: Arm): number {
  const links = arm.joints.map((joint) => norm([joint.a, joint.kind === "R" ? joint.other : 0]));
  const fixed = links.reduce((sum, value) => sum + value, norm(arm.point.offset));
  const slides = arm.joints.filter((joint) => joint.kind === "P").length;
  return fixed + slides * (fixed > 0 ? longest(arm) : 0.4) || 0.4;
}

/** Whether the task counts velocities and turns at once, so that singular values depend on the unit of length. */
export const isMixed = (arm: Arm): boolean => arm.task.some((row) => row < 3) && arm.task.some((row) => row > 2);

/** The longest part of the arm (m), to which its slides are measured; 0.4 for one without any. */
export function longest(arm: Arm): number {
  const parts = arm.joints.flatMap((joint) => [joint.a, joint.kind === "R" ? joint.other : 0]);
  const least = arm.joints.some((joint) => joint.kind === "P") ? 0.3 : 0; // a slide that can be seen
  return Math.max(least, ...[...parts, ...arm.point.offset].map(Math.abs)) || 0.4;
}

/** The columns of J that are drawn as arrows at P: how the point moves, or how the link turns if only that counts. */
export function arrowsOf(arm: Arm, state: State): { readonly turning: boolean; readonly columns: readonly Vec3[] } {
  const turning = arm.task.every((row) => row > 2);
  const first = turning ? 3 : 0;
  const columns = arm.joints.map((_, j): Vec3 => {
    const [x, y, z] = [0, 1, 2].map((k) => state.jacobian[first + k]![j]!);
    return [x!, y!, z!];
  });
  return { turning, columns };
}
