// Classes of arms: which there are of a lesson, each with a row of its own, and which of them is asked next.
import { describe, expect, test } from "vitest";

import type { Index, ProblemEntry } from "../src/bank.js";
import { listClasses, chooseClassIndex, findStreak, replaceStreak } from "../src/practice/classes.js";
import { LESSONS } from "../src/learn/lessons.js";
import { updateStreak, NEW_SKILL, type Skill } from "../src/practice/skills.js";
import { VARIATION_STEPS } from "../src/practice/choice.js";

const DAY = 24 * 3600 * 1000;
const LESSON = LESSONS.find(({ id }) => id === "differentiation")!;
const arms = (name: string, flat: boolean) => ({
  name,
  title: name,
  source: "",
  problems: VARIATION_STEPS.map((variation): ProblemEntry => {
    const listed = { key: variation, title: "", difficulty: 1, variation, questions: ["jacobian"] };
    return flat ? { ...listed, flat: true } : listed;
  }),
});
const indexOf = (...families: Index["families"]): Index => ({
  format: 1,
  feedback: "solutions",
  questions: [],
  families,
});
const INDEX = indexOf(arms("random-3", false), arms("elbow-3r", false), arms("planar-2r", true));
const CLASSES = listClasses(INDEX, LESSON);

describe("the classes of a lesson", () => {
  test("are the chapter's planar arms, its spatial arms, and any arms: varied ones, and further families", () => {
    const named = CLASSES.map(({ name, items }) => [name, items.map(({ family, key }) => `${family}/${key}`)]);
    expect(named.slice(0, 2)).toEqual([
      ["plain", ["planar-2r/chapter", "planar-2r/lengths"]],
      ["space", ["elbow-3r/chapter", "elbow-3r/lengths"]],
    ]);
    const any = named[2]![1]!;
    expect(any).toHaveLength(3 + 3 + 5);
    expect(any).toContain("planar-2r/full");
    expect(any).toContain("random-3/chapter");
  });

  test("are only those for which the bank has arms", () => {
    expect(listClasses(indexOf(arms("elbow-3r", false)), LESSON).map(({ name }) => name)).toEqual(["space", "any"]);
    expect(listClasses(indexOf(), LESSON)).toEqual([]);
    // an instructor's own arms, in families of their own names
    expect(listClasses(indexOf(arms("place-1", false)), LESSON).map(({ name }) => name)).toEqual(["space", "any"]);
  });

  test("contain each arm once if the bank has only random arms", () => {
    const all = listClasses(indexOf(arms("random-3", false)), LESSON).flatMap(({ items }) => items);
    expect(all).toHaveLength(VARIATION_STEPS.length);
  });
});

test("progress stored before there were classes counts for the first class, and the next one is asked", () => {
  const old: Skill = { row: ["a/1", "a/2", "a/3"], learned: 1, mastered: 2 * DAY, goals: [0] };
  expect(CLASSES.map((_, at) => findStreak(old, CLASSES, at).mastered)).toEqual([2 * DAY, undefined, undefined]);
  expect(chooseClassIndex(old, CLASSES, 9 * DAY)).toBe(1);
});

test("each class has its own streak: a wrong answer about a spatial arm keeps that of planar arms", () => {
  const plain: Skill = { ...NEW_SKILL, row: ["planar-2r/chapter"], learned: 0, mastered: DAY };
  const attempt = { isHelped: false, isRepeated: false, now: 2 * DAY, armCount: 2 };
  const right = (skill: Skill, at: number, key: string, isRight = true): Skill => {
    const item = { family: "elbow-3r", key, question: "jacobian" };
    return replaceStreak(
      skill,
      CLASSES,
      at,
      updateStreak(findStreak(skill, CLASSES, at), item, { ...attempt, isRight: isRight }),
    );
  };
  const begun = right(plain, 1, "chapter");
  expect(findStreak(begun, CLASSES, 1).row).toEqual(["elbow-3r/chapter"]);
  const wrong = right(begun, 1, "lengths", false);
  expect([findStreak(wrong, CLASSES, 1).row, wrong.mastered]).toEqual([[], DAY]);
  const learned = right(begun, 1, "lengths");
  expect(findStreak(learned, CLASSES, 1).learned).toBe(2 * DAY);
  expect(chooseClassIndex(learned, CLASSES, 2 * DAY)).toBe(2); // the next class, until this one is due for review
  expect(chooseClassIndex(learned, CLASSES, 3 * DAY)).toBe(1);
});
