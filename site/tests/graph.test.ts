// The map of what one knows: layers by what builds on what, how lessons and questions stand.
import { describe, expect, test } from "vitest";

import type { Index } from "../src/bank.js";
import { makeLessonNodes, findLessonState } from "../src/learn/graph.js";
import { LESSONS } from "../src/learn/lessons.js";
import { NEW_SKILL } from "../src/practice/skills.js";

const DAY = 24 * 3600 * 1000;
const INDEX: Index = {
  format: 1,
  feedback: "solutions",
  families: [
    {
      name: "planar-2r",
      title: "",
      source: "",
      problems: ["1", "2", "3", "4"].map((key) => ({
        key,
        title: "",
        difficulty: 0,
        variation: "chapter",
        questions: key === "4" ? ["rank"] : ["jacobian", "determinant"],
      })),
    },
  ],
  questions: ["jacobian", "determinant", "rank"].map((name) => ({ name, title: name, source: "", form: "" })),
};

describe("the graph", () => {
  test("shows a lesson as begun that was practised only for a later class of arms", () => {
    expect(findLessonState(NEW_SKILL, 0, [{ row: [] }])).toBe("new");
    expect(findLessonState(NEW_SKILL, 0, [{ row: ["elbow-3r/1"] }])).toBe("begun");
  });

  test("has every lesson after those it needs, and only known lessons", () => {
    const layers = new Map(LESSONS.map(({ id, position }) => [id, position.layer]));
    for (const { id, needs } of LESSONS)
      for (const need of needs) expect(layers.get(need), `${id} needs ${need}`).toBeLessThan(layers.get(id)!);
  });

  test("places the lessons of a layer beside each other, around its middle", () => {
    const positions = LESSONS.map(({ position }) => position);
    expect(new Set(positions.map(({ layer, offset }) => `${layer} ${offset}`)).size).toBe(LESSONS.length);
    for (const { layer } of positions) {
      const inLayer = positions.filter((position) => position.layer === layer);
      expect(inLayer.reduce((sum, { offset }) => sum + offset, 0)).toBe(0);
    }
  });

  test("shows which lesson comes next, and which lessons are missing before it", () => {
    const first = makeLessonNodes(INDEX, {}, 0);
    expect(first.filter(({ isNext }) => isNext).map(({ lesson }) => lesson.id)).toEqual(["rates"]);
    const learned = { ...NEW_SKILL, learned: 1 };
    const later = makeLessonNodes(INDEX, { rates: learned, columns: learned }, 0);
    expect(later.filter(({ isNext }) => isNext).map(({ lesson }) => lesson.id)).toEqual([
      "differentiation",
      "propagation",
      "links",
    ]);
    const inverse = later.find(({ lesson }) => lesson.id === "inverse")!;
    expect(inverse.unlearnedNeeds.map(({ id }) => id)).toEqual(["differentiation", "propagation"]);
  });
});

test.each([
  [NEW_SKILL, "new"],
  [{ ...NEW_SKILL, goals: [0] }, "begun"],
  [{ ...NEW_SKILL, row: ["a/1"] }, "begun"],
  [{ ...NEW_SKILL, learned: 5 * DAY }, "learned"],
  [{ ...NEW_SKILL, learned: 4 * DAY }, "due"],
  [{ ...NEW_SKILL, learned: 1, mastered: 2 * DAY }, "mastered"],
] as const)("%o is %s", (skill, due) => expect(findLessonState(skill, 5 * DAY)).toBe(due));

test("a lesson is mastered if all classes of arms are, and due for review if one class is", () => {
  const mastered = { ...NEW_SKILL, learned: 1, mastered: 2 * DAY };
  expect(findLessonState(mastered, 5 * DAY, [mastered])).toBe("mastered");
  expect(findLessonState(mastered, 5 * DAY, [{ row: ["a/1"] }])).toBe("learned");
  expect(findLessonState(mastered, 5 * DAY, [{ row: [], learned: 4 * DAY }])).toBe("due");
});
