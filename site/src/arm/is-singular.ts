// Decide whether an arm is singular in a pose, to judge answers that are sets of configurations.

import type { NamedPose, Problem } from "../bank.js";
import { type Arm, armOf, measuresOf, stateAt } from "./model.js";

/** Smallest singular value of J, as a share of the largest, below which an arm counts as singular. */
const MAX_SINGULAR_RATIO = 1e-5;

/** Return a predicate that decides whether a configuration of a problem's arm, possibly with lengths, is singular. */
export function createSingularityTest({ robot }: Pick<Problem, "robot">): (configuration: NamedPose) => boolean {
  const { joints } = armOf(robot);
  const names = new Set(joints.map(({ name }) => name));
  let cached: { readonly lengths: string; readonly arm: Arm } | null = null; // parsing the table takes longest
  const armWith = (lengths: readonly (readonly [name: string, value: number])[]): Arm => {
    const key = JSON.stringify(lengths);
    if (cached?.lengths !== key)
      cached = { lengths: key, arm: armOf({ ...robot, values: { ...robot.values, ...Object.fromEntries(lengths) } }) };
    return cached.arm;
  };
  return (configuration) => {
    const arm = armWith(Object.entries(configuration).filter(([name]) => !names.has(name)));
    const pose = joints.map(({ name }) => configuration[name] ?? 0);
    return measuresOf(arm, stateAt(arm, pose)).ratio < MAX_SINGULAR_RATIO;
  };
}
