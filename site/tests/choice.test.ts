// What comes next: what went wrong again, sets in one order for all, links that lead back to the same wish.
import { expect, test } from "vitest";

import type { Index } from "../src/bank.js";
import {
  ANY_WISH,
  findFault,
  writeWish,
  updateProgress,
  parseWish,
  listSetItems,
  type Item,
  listItems,
  nameItem,
  chooseNext,
  findFirstNew,
  listVariations,
  BOX_DELAYS,
} from "../src/practice/choice.js";
import { parseEntries, isUnfinished, writeMatrix } from "../src/practice/entries.js";
import {
  type StoredState,
  writeFile,
  parseFile,
  keepOtherChanges,
  loadState,
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
  expect(listItems(INDEX, ANY_WISH)).toHaveLength(4);
  expect(listItems(INDEX, { ...ANY_WISH, family: "scara" }).map(nameItem)).toEqual(["scara/001/determinant"]);
  expect(listItems(INDEX, { ...ANY_WISH, question: "position", difficulty: 2 }).map(nameItem)).toEqual([
    "planar-2r/002/position",
  ]);
  expect(listItems(INDEX, { ...ANY_WISH, variation: "full" }).map(nameItem)).toEqual(["planar-2r/002/position"]);
  expect(listVariations(INDEX)).toEqual(["chapter", "full", "lengths+base"]);
  expect(chooseNext(INDEX, { ...ANY_WISH, question: "twist" }, {}, 0, Math.random)).toBeNull();
});

test("a wrong question returns soon, before new ones; a right one returns later each time", () => {
  const [item] = listItems(INDEX, ANY_WISH);
  if (!item) throw new Error("no item");
  let progress = updateProgress({}, item, false, 1000);
  const at = (now: number) => chooseNext(INDEX, ANY_WISH, progress, now, () => 0);
  expect(nameItem(at(1000) ?? item)).not.toBe(nameItem(item));
  expect(nameItem(at(1000 + (BOX_DELAYS[0] ?? 0)) ?? item)).toBe(nameItem(item));
  progress = updateProgress(progress, item, true, 0);
  expect(progress[nameItem(item)]).toEqual({ right: true, missed: true, box: 1, due: BOX_DELAYS[1] });
  progress = updateProgress(updateProgress(progress, item, true, 0), item, false, 0);
  expect(progress[nameItem(item)]?.box).toBe(0);
});

test("beginners first get plain questions about the easiest arm that they wish for", () => {
  const drawn = (wish = ANY_WISH, progress = {}) =>
    new Set([0, 0.3, 0.6, 0.999].map((luck) => nameItem(chooseNext(INDEX, wish, progress, 0, () => luck)!)));
  expect(drawn()).toEqual(new Set(["planar-2r/001/position"]));
  expect(drawn({ ...ANY_WISH, question: "position" })).toEqual(new Set(["planar-2r/001/position"]));
  expect(drawn({ ...ANY_WISH, family: "scara" })).toEqual(new Set(["scara/001/determinant"]));
  const later = Object.fromEntries(["a", "b", "c"].map((name) => [name, { right: true, box: 1, due: 9e9 }]));
  expect(drawn(ANY_WISH, later).size).toBeGreaterThan(2);
});

test("a set has the same order for everyone, and another order for another seed", () => {
  const wish = { ...ANY_WISH, set: "week-3" };
  expect(listSetItems(INDEX, wish)).toEqual(listSetItems(INDEX, wish));
  const orders = ["a", "b", "c", "d", "e"].map((set) =>
    listSetItems(INDEX, { ...ANY_WISH, set })
      .map(nameItem)
      .join(),
  );
  expect(new Set(orders).size).toBeGreaterThan(1);
});

test("a link contains the wish, and invalid values in it are ignored", () => {
  const wish = { family: "scara", question: "position", difficulty: 0, variation: "frames", set: "x", count: 7 };
  expect(parseWish(writeWish(wish))).toEqual(wish);
  expect(writeWish({ ...ANY_WISH, set: "x" })).toBe("?set=x");
  expect(parseWish("?set=x&n=-3").count).toBe(ANY_WISH.count);
  expect(parseWish("")).toEqual(ANY_WISH);
  expect(parseWish("?difficulty=9").difficulty).toBeNull();
});

test("a set has the number of problems in its link, or ten", () => {
  const many = { ...INDEX, families: Array.from({ length: 5 }, () => INDEX.families).flat() };
  expect(listSetItems(many, { ...ANY_WISH, set: "a" })).toHaveLength(10);
  expect(listSetItems(many, { ...ANY_WISH, set: "a", count: 3 })).toHaveLength(3);
});

test("if a link asks for something missing, the choices are listed", () => {
  const question = { name: "position", title: "Position", source: "6.1", form: "" };
  const known = { ...INDEX, questions: [question] };
  const fault = (search: string) => findFault(known, parseWish(search), search)?.key ?? null;
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
  expect(parseFile(writeFile(ALL))).toEqual(ALL);
  expect(parseFile("{}")).toBeNull();
  expect(parseFile("no JSON")).toBeNull();
  const wrong = '{"qdot": "progress", "progress": {"a": {"right": 1}}, "lessons": {"b": 1}}';
  expect(parseFile(wrong)).toEqual(EMPTY_STATE);
});

test("a file of version 1 adds to the progress, and removes none from the lessons", () => {
  const old = parseFile(JSON.stringify({ qdot: "progress", version: 1, progress: ALL.progress }))!;
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

test("what another tab has stored is kept; of the same item, this tab's change counts", () => {
  const [old, mine, other] = [1, 2, 3].map((box) => ({ right: true, box, due: box }));
  const before = { progress: { a: old!, b: old! }, lessons: {} };
  const after = { progress: { ...before.progress, a: mine! }, lessons: {} };
  const stored = { progress: { a: other!, b: other!, c: other! }, lessons: {} };
  expect(keepOtherChanges(before, after, stored).progress).toEqual({ a: mine, b: other, c: other });
  expect(keepOtherChanges(before, after, EMPTY_STATE)).toEqual(after); // the browser stores nothing
});

test("a stored state is found again, and a change of one part keeps the other", () => {
  const store = new Map<string, string>();
  const storage = {
    getItem: (key: string) => store.get(key) ?? null,
    setItem: (key: string, text: string) => void store.set(key, text),
  } as unknown as Storage;
  storeState(storage, ALL);
  expect(loadState(storage)).toEqual(ALL);
  storeState(storage, { lessons: {} });
  expect(loadState(storage)).toEqual({ ...ALL, lessons: {} });
  storeState(storage, EMPTY_STATE);
  expect(loadState(storage)).toEqual(EMPTY_STATE);
  expect(loadState(null)).toEqual(EMPTY_STATE);
});

test("a question that was once wrong comes before new ones when it is due for review; other questions do not", () => {
  const [first, second] = listItems(INDEX, ANY_WISH) as [Item, Item, ...Item[]];
  const DAY = BOX_DELAYS[1] as number;
  const once = updateProgress(updateProgress({}, first, false, 0), first, true, 0);
  expect(nameItem(chooseNext(INDEX, ANY_WISH, once, DAY, () => 0) as Item)).toBe(nameItem(first));
  expect(nameItem(chooseNext(INDEX, ANY_WISH, updateProgress({}, first, true, 0), DAY, () => 0) as Item)).toBe(
    nameItem(second),
  );
  const back = parseFile(writeFile({ ...EMPTY_STATE, progress: once }))!.progress;
  expect(nameItem(chooseNext(INDEX, ANY_WISH, back, DAY, () => 0) as Item)).toBe(nameItem(first));
  const wrong = '{"qdot":"progress","progress":{"a/1/b":{"right":true,"box":99,"due":0}}}';
  expect(parseFile(wrong)).toEqual(EMPTY_STATE);
});

test("a set continues at its first unanswered question", () => {
  const order = listSetItems(INDEX, { ...ANY_WISH, set: "x" });
  expect(findFirstNew(order, {})).toBe(0);
  expect(findFirstNew(order, updateProgress({}, order[0] as Item, false, 0))).toBe(1);
  expect(findFirstNew(order, Object.assign({}, ...order.map((item) => updateProgress({}, item, true, 0))))).toBe(0);
});

test("entries are written as a text, and parsed from it", () => {
  const entries = ["a1*cos(theta1)", "", "atan2(1, 2)", "0,5"];
  const text = writeMatrix(entries, 2);
  expect(text).toBe("[[a1*cos(theta1), blank], [atan2(1, 2), 0.5]]");
  expect(parseEntries(text, 2, 2)).toEqual(["a1*cos(theta1)", "", "atan2(1, 2)", "0.5"]);
  expect(parseEntries("Matrix([[1], [f(2, 3)]])", 2, 1)).toEqual(["1", "f(2, 3)"]);
  expect(parseEntries("Matrix([\n  [1, 2],\n])", 1, 2)).toEqual(["1", "2"]);
  expect(parseEntries("[1, 2]", 2, 1)).toEqual(["1", "2"]);
  expect(parseEntries("[[1, 2], [3]]", 2, 2)).toBeNull();
  expect(parseEntries("a1 + 2", 1, 2)).toBeNull();
  expect(writeMatrix(["", " "], 2)).toBe("");
});

test.each(["[a, b; c, d]", "a, b\nc, d", "[a b\n c d]", "J = [a b; c d];"])(
  "%j becomes the entries of the grid",
  (text) => expect(parseEntries(text, 2, 2)).toEqual(["a", "b", "c", "d"]),
);

test("Enter begins another line until all rows are typed", () => {
  expect(isUnfinished("a, b", 2, 2)).toBe(true);
  expect(isUnfinished("a, b\nc, d", 2, 2)).toBe(false);
  expect(isUnfinished("a, b; c, d", 2, 2)).toBe(false);
  expect(isUnfinished("a*c1", 2, 1)).toBe(true);
  expect(isUnfinished("a, b", 2, 1)).toBe(false);
  for (const bracketed of ["[[1, 2", "J = [1", "Matrix([1"]) expect(isUnfinished(bracketed, 2, 2)).toBe(false);
});
