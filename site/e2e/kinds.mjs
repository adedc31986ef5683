// One page of each kind, and which of them `make test` looks at: all that differ, and the two examples once each.

export const KINDS = [
  "index.html",
  "learn.html",
  "learn.html?lesson=inverse",
  "practice.html?arm=planar-2r&question=jacobian",
  "practice.html?arm=planar-2r&set=a&sheet=2&key=1",
  "own.html",
  "accessibility.html",
  "examples/index.html",
  "examples/6-2.html",
  "examples/6-3.html",
  "examples/errata.html",
  "arms.html",
  "docs/index.html",
  "docs/students.html",
  "docs/commands.html",
];
const WHOLE = process.env.QDOT_SUITE === "whole";
/** Examples have one template: one with an arm in the plane, one with an arm in space. */
const LEFT_TO_WHOLE = { wide: ["examples/6-3.html"], phone: ["examples/6-2.html"] };
const taken = (where) => KINDS.filter((path) => WHOLE || !LEFT_TO_WHOLE[where].includes(path));

export const ON_WIDE = taken("wide");
export const ON_PHONE = taken("phone");
/** How many tests are left to `make whole`. */
export const LEFT = 2 * KINDS.length - ON_WIDE.length - ON_PHONE.length;
