// Sines and cosines of a formula, and the angles that may be correct instead of those in them.

import { evaluate } from "../read/evaluate.js";
import { anyNode, decimal, isConstant, type Node, node, visitNodes } from "../read/tree.js";

/** The name of a joint angle. */
const JOINT = /^theta\d+$/;
/** In radians. */
const FULL_TURN = 2 * Math.PI;

/** Whether a node is a sine or cosine ("wave", here and below). */
export const isWave = ({ kind, text }: Node): boolean => kind === "call" && (text === "sin" || text === "cos");
/** Return the cosine for a sine, and the sine for a cosine. */
export const exchangeWave = (tree: Node): Node => ({ ...tree, text: tree.text === "sin" ? "cos" : "sin" });

/** Return a tree in which each sine and cosine is changed. */
export function changeEveryWave(tree: Node, change: (wave: Node) => Node): Node {
  if (isWave(tree)) return change(tree);
  return tree.args.length === 0 ? tree : { ...tree, args: tree.args.map((arg) => changeEveryWave(arg, change)) };
}

/** An angle as a sum: the coefficient of each joint angle, and a constant (rad). */
type AngleSum = { readonly joints: ReadonlyMap<string, number>; readonly constant: number };

/** Return an angle as a sum; null if it contains anything else. */
function toAngleSum(angle: Node): AngleSum | null {
  const joints = new Map<string, number>();
  let constant = 0;
  const visit = (tree: Node, sign: number): boolean => {
    const { kind, args, text } = tree;
    if (kind === "name" && JOINT.test(text)) return (joints.set(text, (joints.get(text) ?? 0) + sign), true);
    if (isConstant(tree)) {
      constant += sign * evaluate(tree, {}).re;
      return true;
    }
    const [left, right] = args;
    if (kind === "neg" && left) return visit(left, -sign);
    if (kind !== "+" && kind !== "-") return false;
    return visit(left as Node, sign) && visit(right as Node, kind === "-" ? -sign : sign);
  };
  if (anyNode(angle, ({ kind }) => kind === "blank" || kind === "list") || !visit(angle, 1)) return null;
  return { joints, constant };
}

/** Return a text that is equal for equal sums of angles; "" if the angle is no such sum. */
export function makeAngleKey(angle: Node): string {
  const sum = toAngleSum(angle);
  if (!sum || sum.joints.size === 0) return "";
  const joints = [...sum.joints].sort().map(([joint, count]) => `${count} ${joint}`);
  const constant = ((sum.constant % FULL_TURN) + FULL_TURN) % FULL_TURN;
  return [...joints, (constant > FULL_TURN - 1e-9 ? 0 : constant).toFixed(9)].join();
}

/** Return the distinct angles of sines and cosines in some entries. */
export function findAngles(entries: readonly Node[]): Node[] {
  const angles = new Map<string, Node>();
  for (const entry of entries)
    visitNodes(entry, (node) => {
      const [angle] = node.args;
      if (isWave(node) && angle && makeAngleKey(angle)) angles.set(makeAngleKey(angle), angle);
    });
  return [...angles.values()];
}

/** Return a sine or cosine with the new angle if it has the old one; else unchanged. */
export function replaceAngle(wave: Node, oldAngle: Node, newAngle: Node): Node {
  return makeAngleKey(wave.args[0] as Node) === makeAngleKey(oldAngle) ? { ...wave, args: [newAngle] } : wave;
}

/** Return angles that may be correct: sums of successive joints; the angle with a joint added, removed or negated. */
export function listOtherAngles(angle: Node, angles: readonly Node[]): Node[] {
  const joints = angles.filter(({ kind }) => kind === "name");
  const sum = toAngleSum(angle);
  const negated = joints.flatMap((joint) => {
    const count = sum?.joints.get(joint.text) ?? 0;
    if (count === 0) return [];
    const twice = node("*", decimal(2 * Math.abs(count)), joint);
    return [node(count > 0 ? "-" : "+", angle, twice)];
  });
  const changed = joints.flatMap((joint) => [node("+", angle, joint), node("-", angle, joint)]);
  const candidates = [...angles, ...addConstant(sum?.constant ?? 0, angles), ...changed, ...negated];
  return candidates.filter(dependsOnJoint);
}

/** Return whether an angle depends on a joint: theta1 - theta1 does not. */
function dependsOnJoint(angle: Node): boolean {
  const sum = toAngleSum(angle);
  return sum === null || [...sum.joints.values()].some((count) => count !== 0);
}

/** Return the angles plus a constant (rad); an empty list if it is 0. */
function addConstant(constant: number, angles: readonly Node[]): Node[] {
  return constant === 0 ? [] : angles.map((angle) => node("+", angle, decimal(constant)));
}

/** A twelfth of half a turn (15°): constants added to angles are multiples of this step. */
const ANGLE_STEP = Math.PI / 12;

/**
 * Return the angle of a sine or cosine plus a constant with which it has the wanted value, in every way. The angle's
 * value is now `currentAngle` (rad). Quarter turns are omitted, because they exchange sine and cosine.
 */
export function findAnglesWithValue(wave: Node, currentAngle: number, wantedSine: number): Node[] {
  if (!(Math.abs(wantedSine) <= 1)) return [];
  const principalAngle = wave.text === "sin" ? Math.asin(wantedSine) : Math.acos(wantedSine);
  return [principalAngle, wave.text === "sin" ? Math.PI - principalAngle : -principalAngle].flatMap((angle) => {
    const steps = (angle - currentAngle) / ANGLE_STEP;
    const isCandidate = Math.abs(steps - Math.round(steps)) < 1e-6 && Math.round(steps) % 6 !== 0;
    return isCandidate ? [node("+", wave.args[0] as Node, decimal(Math.round(steps) * ANGLE_STEP))] : [];
  });
}

/** Return the sine or cosine of the sum from joint `first` to the last joint of this angle; null if there is none. */
export function addJointsFrom(first: Node, wave: Node, angles: readonly Node[]): Node | null {
  const [angle] = wave.args as [Node];
  const typedSum = toAngleSum(angle);
  const absoluteAngle = angles.find((candidate) => {
    const joints = [...(toAngleSum(candidate)?.joints.keys() ?? [])];
    return joints[0] === first.text && typedSum && [...typedSum.joints.keys()].sort().at(-1) === joints.at(-1);
  });
  if (!absoluteAngle || !typedSum) return null;
  const [expected] = typedSum.constant === 0 ? [absoluteAngle] : addConstant(typedSum.constant, [absoluteAngle]);
  return expected && isRelative(angle, expected) ? { ...wave, args: [expected] } : null;
}

/** Return whether an angle lacks only joints before its first one, as theta2 instead of theta1 + theta2. */
export function isRelative(typed: Node, expected: Node): boolean {
  const [typedSum, expectedSum] = [toAngleSum(typed), toAngleSum(expected)];
  if (!typedSum || !expectedSum || Math.abs(typedSum.constant - expectedSum.constant) > 1e-9) return false;
  const hasOnlyExpectedJoints = [...typedSum.joints].every(
    ([joint, count]) => count === 1 && expectedSum.joints.get(joint) === 1,
  );
  const lastJoints = [typedSum, expectedSum].map(({ joints }) => [...joints.keys()].sort().at(-1));
  return hasOnlyExpectedJoints && expectedSum.joints.size > typedSum.joints.size && lastJoints[0] === lastJoints[1];
}
