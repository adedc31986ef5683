// What comes next: what went wrong again, sets in one order for all, links that lead back to the same wish.
import { expect, test } from "vitest";

import type { Index } from "../src/bank.js";
import {
  ANYTHING,
  faultOf,
  wishToLink,
  progressAfter,
  wishFromLink,
  itemsOfSet,
  type Item,
  itemsFor,
  nameOf,
  chooseNext,
  placeIn,
  variationsIn,
  WAITS,
} from "../src/practice/choice.js";
import { entriesOf, isUnfinished, matrixText } from "../src/practice/entries.js";
import {
  type StoredState,
  asFile,
  fromFile,
  storedState,
  storeState,
  mergeStates,
  EMPTY_STATE,
} from "../src/practice/stored-state.js";

const INDEX: Index = {
  format: 1,
  feedback: "solutions",
  families: [
    {
      name: "planar-2r",
      title: "Planar 2R",
      source: "6.1",
      problems: [
        { key: "001", title: "A", difficulty: 1, variation: "chapter", questions: ["position", "jacobian"] },
        { key: "002", title: "B", difficulty: 2, variation: "full", questions: ["position"] },
      ],
    },
    {
      name: "scara",
      title: "SCARA",
      source: "6.6",
      problems: [{ key: "001", title: "C", difficulty: 1, variation: "lengths+base", questions: ["determinant"] }],
    },
  ],
  questions: [],
};

test("a wish restricts which questions are asked", () => {
  expect(itemsFor(INDEX, ANYTHING)).toHaveLength(4);
  expect(itemsFor(INDEX, { ...ANYTHING, family: "scara" }).map(nameOf)).toEqual(["scara/001/determinant"]);
  expect(itemsFor(INDEX, { ...ANYTHING, question: "position", difficulty: 2 }).map(nameOf)).toEqual([
    "planar-2r/002/position",
  ]);
  expect(itemsFor(INDEX, { ...ANYTHING, variation: "full" }).map(nameOf)).toEqual(["planar-2r/002/position"]);
  expect(variationsIn(INDEX)).toEqual(["chapter", "full", "lengths+base"]);
  expect(chooseNext(INDEX, { ...ANYTHING, question: "twist" }, {}, 0, Math.random)).toBeNull();
});

test("a wrong question returns soon, before new ones; a right one returns later each time", () => {
  const [item] = itemsFor(INDEX, ANYTHING);
  if (!item) throw new Error("no item");
  let progress = progressAfter({}, item, false, 1000);
  const at = (now: number) => chooseNext(INDEX, ANYTHING, progress, now, () => 0);
  expect(nameOf(at(1000) ?? item)).not.toBe(nameOf(item));
  expect(nameOf(at(1000 + (WAITS[0] ?? 0)) ?? item)).toBe(nameOf(item));
  progress = progressAfter(progress, item, true, 0);
  expect(progress[nameOf(item)]).toEqual({ right: true, missed: true, box: 1, due: WAITS[1] });
  progress = progressAfter(progressAfter(progress, item, true, 0), item, false, 0);
  expect(progress[nameOf(item)]?.box).toBe(0);
});

test("beginners first get plain questions about the easiest arm that they wish for", () => {
  const drawn = (wish = ANYTHING, progress = {}) =>
    new Set([0, 0.3, 0.6, 0.999].map((luck) => nameOf(chooseNext(INDEX, wish, progress, 0, () => luck)!)));
  expect(drawn()).toEqual(new Set(["planar-2r/001/position"]));
  expect(drawn({ ...ANYTHING, question: "position" })).toEqual(new Set(["planar-2r/001/position"]));
  expect(drawn({ ...ANYTHING, family: "scara" })).toEqual(new Set(["scara/001/determinant"]));
  const later = Object.fromEntries(["a", "b", "c"].map((name) => [name, { right: true, box: 1, due: 9e9 }]));
  expect(drawn(ANYTHING, later).size).toBeGreaterThan(2);
});

test("a set has the same order for everyone, and another order for another seed", () => {
  const wish = { ...ANYTHING, set: "week-3" };
  expect(itemsOfSet(INDEX, wish)).toEqual(itemsOfSet(INDEX, wish));
  const orders = ["a", "b", "c", "d", "e"].map((set) =>
    itemsOfSet(INDEX, { ...ANYTHING, set })
      .map(nameOf)
      .join(),
  );
  expect(new Set(orders).size).toBeGreaterThan(1);
});

test("a link contains the wish, and invalid values in it are ignored", () => {
  const wish = { family: "scara", question: "position", difficulty: 0, variation: "frames", set: "x", count: 7 };
  expect(wishFromLink(wishToLink(wish))).toEqual(wish);
  expect(wishToLink({ ...ANYTHING, set: "x" })).toBe("?set=x");
  expect(wishFromLink("?set=x&n=-3").count).toBe(ANYTHING.count);
  expect(wishFromLink("")).toEqual(ANYTHING);
  expect(wishFromLink("?difficulty=9").difficulty).toBeNull();
});

test("a set has the number of problems in its link, or ten", () => {
  const many = { ...INDEX, families: Array.from({ length: 5 }, () => INDEX.families).flat() };
  expect(itemsOfSet(many, { ...ANYTHING, set: "a" })).toHaveLength(10);
  expect(itemsOfSet(many, { ...ANYTHING, set: "a", count: 3 })).toHaveLength(3);
});

test("if a link asks for something missing, the choices are listed", () => {
  const question = { name: "position", title: "Position", source: "6.1", form: "" };
  const known = { ...INDEX, questions: [question] };
  const fault = (search: string) => faultOf(known, wishFromLink(search), search)?.key ?? null;
  expect(fault("?arm=scara")).toBeNull();
  expect(fault("?arm=foo")).toBe("practice.unknown-arm");
  expect(fault("?question=foo")).toBe("practice.unknown-question");
  expect(fault("?variation=foo")).toBe("practice.unknown-variation");
  expect(fault("?difficulty=9")).toBe("practice.unknown-difficulty");
  expect(fault("?arm=scara&question=position")).toBe("practice.never-asked");
});

const ALL: StoredState = {
  progress: { "scara/001/determinant": { right: true, box: 2, due: 5 } },
  lessons: { columns: { goals: [0, 2], row: ["scara/001"], learned: 7, beyond: { space: { row: ["elbow-3r/001"] } } } },
};

test("a file contains all progress, in problems and lessons; other files are refused", () => {
  expect(fromFile(asFile(ALL))).toEqual(ALL);
  expect(fromFile("{}")).toBeNull();
  expect(fromFile("no JSON")).toBeNull();
  const wrong = '{"qdot": "progress", "progress": {"a": {"right": 1}}, "lessons": {"b": 1}}';
  expect(fromFile(wrong)).toEqual(EMPTY_STATE);
});

test("a file of version 1 adds to the progress, and removes none from the lessons", () => {
  const old = fromFile(JSON.stringify({ qdot: "progress", version: 1, progress: ALL.progress }))!;
  expect(old).toEqual({ ...EMPTY_STATE, progress: ALL.progress });
  expect(mergeStates({ ...ALL, progress: {} }, old)).toEqual(ALL);
});

test("if stored and loaded progress differ, the better one is used", () => {
  const less: StoredState = {
    progress: { "scara/001/determinant": { right: false, box: 0, due: 1 } },
    lessons: { columns: { goals: [1], row: [], beyond: { any: { row: ["a", "b"] } } } },
  };
  const both = {
    ...ALL,
    lessons: {
      columns: {
        ...ALL.lessons["columns"],
        goals: [0, 2, 1],
        beyond: { space: { row: ["elbow-3r/001"] }, any: { row: ["a", "b"] } },
      },
    },
  };
  expect(mergeStates(ALL, less)).toEqual(both);
  expect(mergeStates(less, ALL).lessons["columns"]).toMatchObject({ row: ["scara/001"], learned: 7 });
});

test("a stored state is found again, and a change of one part keeps the other", () => {
  const store = new Map<string, string>();
  const storage = {
    getItem: (key: string) => store.get(key) ?? null,
    setItem: (key: string, text: string) => void store.set(key, text),
  } as unknown as Storage;
  storeState(storage, ALL);
  expect(storedState(storage)).toEqual(ALL);
  storeState(storage, { lessons: {} });
  expect(storedState(storage)).toEqual({ ...ALL, lessons: {} });
  storeState(storage, EMPTY_STATE);
  expect(storedState(storage)).toEqual(EMPTY_STATE);
  expect(storedState(null)).toEqual(EMPTY_STATE);
});

test("a question that was once wrong comes before new ones when it is due for review; other questions do not", () => {
  const [first, second] = itemsFor(INDEX, ANYTHING) as [Item, Item, ...Item[]];
  const DAY = WAITS[1] as number;
  const once = progressAfter(progressAfter({}, first, false, 0), first, true, 0);
  expect(nameOf(chooseNext(INDEX, ANYTHING, once, DAY, () => 0) as Item)).toBe(nameOf(first));
  expect(nameOf(chooseNext(INDEX, ANYTHING, progressAfter({}, first, true, 0), DAY, () => 0) as Item)).toBe(
    nameOf(second),
  );
  const back = fromFile(asFile({ ...EMPTY_STATE, progress: once }))!.progress;
  expect(nameOf(chooseNext(INDEX, ANYTHING, back, DAY, () => 0) as Item)).toBe(nameOf(first));
  const wrong = '{"qdot":"progress","progress":{"a/1/b":{"right":true,"box":99,"due":0}}}';
  expect(fromFile(wrong)).toEqual(EMPTY_STATE);
});

test("a set continues at its first unanswered question", () => {
  const order = itemsOfSet(INDEX, { ...ANYTHING, set: "x" });
  expect(placeIn(order, {})).toBe(0);
  expect(placeIn(order, progressAfter({}, order[0] as Item, false, 0))).toBe(1);
  expect(placeIn(order, Object.assign({}, ...order.map((item) => progressAfter({}, item, true, 0))))).toBe(0);
});

test("entries are written as a text, and parsed from it", () => {
  const entries = ["a1*cos(theta1)", "", "atan2(1, 2)", "0,5"];
  const text = matrixText(entries, 2);
  expect(text).toBe("[[a1*cos(theta1), blank], [atan2(1, 2), 0.5]]");
  expect(entriesOf(text, 2, 2)).toEqual(["a1*cos(theta1)", "", "atan2(1, 2)", "0.5"]);
  expect(entriesOf("Matrix([[1], [f(2, 3)]])", 2, 1)).toEqual(["1", "f(2, 3)"]);
  expect(entriesOf("Matrix([\n  [1, 2],\n])", 1, 2)).toEqual(["1", "2"]);
  expect(entriesOf("[1, 2]", 2, 1)).toEqual(["1", "2"]);
  expect(entriesOf("[[1, 2], [3]]", 2, 2)).toBeNull();
  expect(entriesOf("a1 + 2", 1, 2)).toBeNull();
  expect(matrixText(["", " "], 2)).toBe("");
});

test.each(["[a, b; c, d]", "a, b\nc, d", "[a b\n c d]", "J = [a b; c d];"])(
  "%j becomes the entries of the grid",
  (text) => expect(entriesOf(text, 2, 2)).toEqual(["a", "b", "c", "d"]),
);

test("Enter begins another line until all rows are typed", () => {
  expect(isUnfinished("a, b", 2, 2)).toBe(true);
  expect(isUnfinished("a, b\nc, d", 2, 2)).toBe(false);
  expect(isUnfinished("a, b; c, d", 2, 2)).toBe(false);
  expect(isUnfinished("a*c1", 2, 1)).toBe(true);
  expect(isUnfinished("a, b", 2, 1)).toBe(false);
  for (const bracketed of ["[[1, 2", "J = [1", "Matrix([1"]) expect(isUnfinished(bracketed, 2, 2)).toBe(false);
});
