// What comes next: what went wrong again, sets in one order for all, links that lead back to the same wish.
import { expect, test } from "vitest";

import type { Index } from "../src/bank.js";
import {
  ANYTHING,
  asLink,
  attempted,
  fromLink,
  inOrder,
  items,
  nameOf,
  next,
  WAITS,
} from "../src/practice/choice.js";
import { asFile, fromFile, kept, merged } from "../src/practice/progress.js";

const INDEX: Index = {
  format: 1,
  families: [
    {
      name: "planar-2r",
      title: "Planar 2R",
      source: "6.1",
      problems: [
        { key: "001", title: "A", difficulty: 1, questions: ["position", "jacobian"] },
        { key: "002", title: "B", difficulty: 2, questions: ["position"] },
      ],
    },
    {
      name: "scara",
      title: "SCARA",
      source: "6.6",
      problems: [{ key: "001", title: "C", difficulty: 1, questions: ["determinant"] }],
    },
  ],
  questions: [],
};

test("a wish narrows down what is practised", () => {
  expect(items(INDEX, ANYTHING)).toHaveLength(4);
  expect(items(INDEX, { ...ANYTHING, family: "scara" }).map(nameOf)).toEqual(["scara/001/determinant"]);
  expect(items(INDEX, { ...ANYTHING, question: "position", difficulty: 2 }).map(nameOf)).toEqual([
    "planar-2r/002/position",
  ]);
  expect(next(INDEX, { ...ANYTHING, question: "twist" }, {}, 0, Math.random)).toBeNull();
});

test("what went wrong comes again after a while, before anything new; what went right, later and later", () => {
  const [item] = items(INDEX, ANYTHING);
  if (!item) throw new Error("no item");
  let progress = attempted({}, item, false, 1000);
  const at = (now: number) => next(INDEX, ANYTHING, progress, now, () => 0);
  expect(nameOf(at(1000) ?? item)).not.toBe(nameOf(item));
  expect(nameOf(at(1000 + (WAITS[0] ?? 0)) ?? item)).toBe(nameOf(item));
  progress = attempted(progress, item, true, 0);
  expect(progress[nameOf(item)]).toEqual({ right: true, box: 1, due: WAITS[1] });
  progress = attempted(attempted(progress, item, true, 0), item, false, 0);
  expect(progress[nameOf(item)]?.box).toBe(0);
});

test("a set is the same order for all, and another for another name", () => {
  const wish = { ...ANYTHING, set: "week-3" };
  expect(inOrder(INDEX, wish)).toEqual(inOrder(INDEX, wish));
  const orders = ["a", "b", "c", "d", "e"].map((set) =>
    inOrder(INDEX, { ...ANYTHING, set })
      .map(nameOf)
      .join(),
  );
  expect(new Set(orders).size).toBeGreaterThan(1);
});

test("a link leads back to the same wish, and nonsense in it to any", () => {
  const wish = { family: "scara", question: "position", difficulty: 0, set: "x" };
  expect(fromLink(asLink(wish))).toEqual(wish);
  expect(fromLink("")).toEqual(ANYTHING);
  expect(fromLink("?difficulty=9").difficulty).toBeNull();
});

test("progress survives a file, and a file of something else is refused", () => {
  const progress = { "scara/001/determinant": { right: true, box: 2, due: 5 } };
  expect(fromFile(asFile(progress))).toEqual(progress);
  expect(fromFile("{}")).toBeNull();
  expect(fromFile("no JSON")).toBeNull();
  expect(fromFile('{"qdot": "progress", "progress": {"a": {"right": 1}}}')).toEqual({});
  expect(merged(progress, { "scara/001/determinant": { right: false, box: 0, due: 1 } })).toEqual(progress);
  expect(kept(null)).toEqual({});
});
