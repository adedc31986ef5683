// Is an arm singular in a pose? What sets of configurations are judged by.

import type { Problem } from "../bank.js";
import { armOf, measuresOf, stateAt } from "./model.js";

/** Smallest singular value of J, as a share of the largest, below which an arm counts as singular. */
const SINGULAR = 1e-5;

/** Tells of poses of a problem's arm whether they are singular; lengths have the values that go with the pose. */
export function singularIn({
  robot,
}: Pick<Problem, "robot">): (at: Readonly<Record<string, number>>) => boolean {
  return (at) => {
    const names = armOf(robot).joints.map(({ name }) => name);
    const lengths = Object.fromEntries(Object.entries(at).filter(([name]) => !names.includes(name)));
    const arm = armOf({ ...robot, values: { ...robot.values, ...lengths } });
    return (
      measuresOf(
        stateAt(
          arm,
          names.map((name) => at[name] ?? 0),
        ),
      ).ratio < SINGULAR
    );
  };
}
