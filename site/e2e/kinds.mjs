/** One page of each kind. */
export const KINDS = [
  "index.html",
  "learn.html",
  "learn.html?lesson=inverse",
  "practice.html?arm=planar-2r&question=jacobian",
  "practice.html?arm=planar-2r&set=a&sheet=2&key=1",
  "own.html",
  "check.html",
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
