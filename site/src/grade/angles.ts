// Sines and cosines of a formula, and the angles that may be correct instead of those in them.

import { evaluate } from "../read/evaluate.js";
import { anyNode, decimal, namesIn, type Node, node } from "../read/tree.js";

const JOINT = /^theta\d+$/;
const TURN = 2 * Math.PI;

/** Whether a node is a sine or cosine ("wave", here and below). */
export const isWave = ({ kind, text }: Node): boolean => kind === "call" && (text === "sin" || text === "cos");
export const otherWave = (tree: Node): Node => ({ ...tree, text: tree.text === "sin" ? "cos" : "sin" });

/** Return a tree in which each sine and cosine is changed. */
export function changeEveryWave(tree: Node, change: (wave: Node) => Node): Node {
  if (isWave(tree)) return change(tree);
  return tree.args.length === 0 ? tree : { ...tree, args: tree.args.map((arg) => changeEveryWave(arg, change)) };
}

/** An angle as a sum: the coefficient of each joint angle, and a constant (rad). */
type Sum = { readonly joints: ReadonlyMap<string, number>; readonly constant: number };

/** Return an angle as a sum; null if it contains anything else. */
function sumOfAngles(angle: Node): Sum | null {
  const joints = new Map<string, number>();
  let constant = 0;
  const visit = (tree: Node, sign: number): boolean => {
    const { kind, args, text } = tree;
    if (kind === "name" && JOINT.test(text)) return (joints.set(text, (joints.get(text) ?? 0) + sign), true);
    if (namesIn(tree).size === 0) {
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
export function angleText(angle: Node): string {
  const sum = sumOfAngles(angle);
  if (!sum || sum.joints.size === 0) return "";
  const joints = [...sum.joints].sort().map(([joint, count]) => `${count} ${joint}`);
  const constant = ((sum.constant % TURN) + TURN) % TURN;
  return [...joints, (constant > TURN - 1e-9 ? 0 : constant).toFixed(9)].join();
}

/** Return the angles of sines and cosines in some entries, each once. */
export function anglesIn(entries: readonly Node[]): Node[] {
  const angles = new Map<string, Node>();
  for (const entry of entries)
    anyNode(entry, (node) => {
      const [angle] = node.args;
      if (isWave(node) && angle && angleText(angle)) angles.set(angleText(angle), angle);
      return false;
    });
  return [...angles.values()];
}

/** Return a sine or cosine with a new angle if its angle equals `old`; else unchanged. */
export function withAngle(wave: Node, old: Node, angle: Node): Node {
  return angleText(wave.args[0] as Node) === angleText(old) ? { ...wave, args: [angle] } : wave;
}

/** Return angles that may be correct: sums of successive joints; the angle with a joint added, removed or negated. */
export function otherAngles(angle: Node, angles: readonly Node[]): Node[] {
  const joints = angles.filter(({ kind }) => kind === "name");
  const sum = sumOfAngles(angle);
  const negated = joints.flatMap((joint) => {
    const count = sum?.joints.get(joint.text) ?? 0;
    if (count === 0) return [];
    const twice = node("*", decimal(2 * Math.abs(count)), joint);
    return [node(count > 0 ? "-" : "+", angle, twice)];
  });
  const changed = joints.flatMap((joint) => [node("+", angle, joint), node("-", angle, joint)]);
  const candidates = [...angles, ...withConstant(sum?.constant ?? 0, angles), ...changed, ...negated];
  return candidates.filter(dependsOnJoint);
}

/** Return whether an angle depends on a joint: theta1 - theta1 does not. */
function dependsOnJoint(angle: Node): boolean {
  const sum = sumOfAngles(angle);
  return sum === null || [...sum.joints.values()].some((count) => count !== 0);
}

function withConstant(constant: number, angles: readonly Node[]): Node[] {
  return constant === 0 ? [] : angles.map((angle) => node("+", angle, decimal(constant)));
}

/** A twelfth of half a turn (15°): constants in angles are multiples of this step. */
const STEP = Math.PI / 12;

/** Return angles of a sine or cosine, now `here`, with a constant that gives it a value; never a quarter turn. */
export function otherConstants(wave: Node, here: number, value: number): Node[] {
  if (!(Math.abs(value) <= 1)) return [];
  const first = wave.text === "sin" ? Math.asin(value) : Math.acos(value);
  return [first, wave.text === "sin" ? Math.PI - first : -first].flatMap((angle) => {
    const steps = (angle - here) / STEP;
    const isOne = Math.abs(steps - Math.round(steps)) < 1e-6 && Math.round(steps) % 6 !== 0;
    return isOne ? [node("+", wave.args[0] as Node, decimal(Math.round(steps) * STEP))] : [];
  });
}

/** Return the sine or cosine of the sum from joint `first` to the last joint of this angle; null if there is none. */
export function withJointsFrom(first: Node, wave: Node, angles: readonly Node[]): Node | null {
  const [angle] = wave.args as [Node];
  const typed = sumOfAngles(angle);
  const absolute = angles.find((candidate) => {
    const joints = [...(sumOfAngles(candidate)?.joints.keys() ?? [])];
    return joints[0] === first.text && typed && [...typed.joints.keys()].sort().at(-1) === joints.at(-1);
  });
  if (!absolute || !typed) return null;
  const [expected] = typed.constant === 0 ? [absolute] : withConstant(typed.constant, [absolute]);
  return expected && isRelative(angle, expected) ? { ...wave, args: [expected] } : null;
}

/** Return whether an angle lacks only joints before its first one: theta2 instead of theta1 + theta2. */
export function isRelative(typed: Node, expected: Node): boolean {
  const [sum, absolute] = [sumOfAngles(typed), sumOfAngles(expected)];
  if (!sum || !absolute || Math.abs(sum.constant - absolute.constant) > 1e-9) return false;
  const isIn = [...sum.joints].every(([joint, count]) => count === 1 && absolute.joints.get(joint) === 1);
  const lasts = [sum, absolute].map(({ joints }) => [...joints.keys()].sort().at(-1));
  return isIn && absolute.joints.size > sum.joints.size && lasts[0] === lasts[1];
}
