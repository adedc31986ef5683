// Sines and cosines of a formula, and the angles that may be due in place of those in them.

import { evaluate } from "../read/evaluate.js";
import { anyNode, decimal, namesIn, type Node, node } from "../read/tree.js";

const JOINT = /^theta\d+$/;
const TURN = 2 * Math.PI;

export const isWave = ({ kind, text }: Node): boolean => kind === "call" && (text === "sin" || text === "cos");
export const otherWave = (tree: Node): Node => ({ ...tree, text: tree.text === "sin" ? "cos" : "sin" });

export function everyWave(tree: Node, change: (wave: Node) => Node): Node {
  if (isWave(tree)) return change(tree);
  return tree.args.length === 0 ? tree : { ...tree, args: tree.args.map((arg) => everyWave(arg, change)) };
}

/** An angle as a sum: how often each joint is counted, and a constant (rad). */
type Sum = { readonly joints: ReadonlyMap<string, number>; readonly constant: number };

/** Null where there is anything else in an angle. */
function sumIn(angle: Node): Sum | null {
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

/** The same for angles that are the same sum; nothing for what is none. */
export function angleText(angle: Node): string {
  const sum = sumIn(angle);
  if (!sum || sum.joints.size === 0) return "";
  const joints = [...sum.joints].sort().map(([joint, count]) => `${count} ${joint}`);
  const turned = ((sum.constant % TURN) + TURN) % TURN;
  return [...joints, (turned > TURN - 1e-9 ? 0 : turned).toFixed(9)].join();
}

/** The angles of sines and cosines in some entries, each once. */
export function anglesIn(entries: readonly Node[]): Node[] {
  const found = new Map<string, Node>();
  for (const entry of entries)
    anyNode(entry, (each) => {
      const [angle] = each.args;
      if (isWave(each) && angle && angleText(angle)) found.set(angleText(angle), angle);
      return false;
    });
  return [...found.values()];
}

export function withAngle(wave: Node, old: Node, angle: Node): Node {
  return angleText(wave.args[0] as Node) === angleText(old) ? { ...wave, args: [angle] } : wave;
}

/** The angles that may be due: sums of successive joints, and this angle with a joint added, removed or reversed. */
export function otherAngles(angle: Node, angles: readonly Node[]): Node[] {
  const joints = angles.filter(({ kind }) => kind === "name");
  const sum = sumIn(angle);
  const turned = joints.flatMap((joint) => {
    const count = sum?.joints.get(joint.text) ?? 0;
    if (count === 0) return [];
    const twice = node("*", decimal(2 * Math.abs(count)), joint);
    return [node(count > 0 ? "-" : "+", angle, twice)];
  });
  const more = joints.flatMap((joint) => [node("+", angle, joint), node("-", angle, joint)]);
  const all = [...angles, ...withConstant(sum?.constant ?? 0, angles), ...more, ...turned];
  return all.filter(turns);
}

/** Whether an angle depends on a joint: theta1 - theta1 does not. */
function turns(angle: Node): boolean {
  const sum = sumIn(angle);
  return sum === null || [...sum.joints.values()].some((count) => count !== 0);
}

function withConstant(constant: number, angles: readonly Node[]): Node[] {
  return constant === 0 ? [] : angles.map((angle) => node("+", angle, decimal(constant)));
}

/** A twelfth of half a turn: constants of angles are so many of these. */
const STEP = Math.PI / 12;

/** The angle of a sine or cosine, worth `here`, with the constant that gives it a value; never a quarter turn. */
export function otherConstants(wave: Node, here: number, value: number): Node[] {
  if (!(Math.abs(value) <= 1)) return [];
  const first = wave.text === "sin" ? Math.asin(value) : Math.acos(value);
  return [first, wave.text === "sin" ? Math.PI - first : -first].flatMap((angle) => {
    const steps = (angle - here) / STEP;
    const isOne = Math.abs(steps - Math.round(steps)) < 1e-6 && Math.round(steps) % 6 !== 0;
    return isOne ? [node("+", wave.args[0] as Node, decimal(Math.round(steps) * STEP))] : [];
  });
}

/** The sine or cosine of the sum from joint `first` up to the last joint of this angle; null if there is none. */
export function countedFrom(first: Node, wave: Node, angles: readonly Node[]): Node | null {
  const [angle] = wave.args as [Node];
  const mine = sumIn(angle);
  const whole = angles.find((each) => {
    const joints = [...(sumIn(each)?.joints.keys() ?? [])];
    return joints[0] === first.text && mine && [...mine.joints.keys()].sort().at(-1) === joints.at(-1);
  });
  if (!whole || !mine) return null;
  const [due] = mine.constant === 0 ? [whole] : withConstant(mine.constant, [whole]);
  return due && isRelative(angle, due) ? { ...wave, args: [due] } : null;
}

/** Whether joints before it are missing in an angle that ends with the same joint, and nothing else. */
export function isRelative(typed: Node, due: Node): boolean {
  const [mine, theirs] = [sumIn(typed), sumIn(due)];
  if (!mine || !theirs || Math.abs(mine.constant - theirs.constant) > 1e-9) return false;
  const isIn = [...mine.joints].every(([joint, count]) => count === 1 && theirs.joints.get(joint) === 1);
  const lasts = [mine, theirs].map(({ joints }) => [...joints.keys()].sort().at(-1));
  return isIn && theirs.joints.size > mine.joints.size && lasts[0] === lasts[1];
}
