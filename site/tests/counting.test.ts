// The classes of arms for which an answer in free practice counts, and the classes due for review.
import { describe, expect, test } from "vitest";

import type { Index, ProblemEntry } from "../src/bank.js";
import { VARIATION_STEPS } from "../src/practice/choice.js";
import {
  describeTopicClass,
  countAnswer,
  chooseFromClass,
  listDueClasses,
  describeOutcomes,
  makeClassFinder,
} from "../src/practice/lesson-credit.js";
import { NEW_SKILL, type Skills } from "../src/practice/skills.js";

const DAY = 24 * 3600 * 1000;
const QUESTIONS = ["jacobian", "joint-effect", "position"];
const arms = (name: string, flat: boolean) => ({
  name,
  title: name,
  source: "",
  problems: VARIATION_STEPS.map((variation): ProblemEntry => {
    const listed = { key: variation, title: "", difficulty: 1, variation, questions: QUESTIONS };
    return flat ? { ...listed, flat: true } : listed;
  }),
});
const INDEX: Index = {
  format: 1,
  feedback: "solutions",
  questions: [],
  families: [arms("planar-2r", true), arms("elbow-3r", false), arms("puma-560", false)],
};
const sorting = makeClassFinder(INDEX);
const right = { isRight: true, isHelped: false, isRepeated: false, now: 7 };
const item = (arm: string, question = "jacobian") => {
  const [family, key] = arm.split("/") as [string, string];
  return { family, key, question };
};
/** The skills after answers to questions about some arms. */
const after = (skills: Skills, how: Partial<typeof right>, ...all: string[]): Skills =>
  all.reduce((now, arm) => countAnswer(now, item(arm), { ...right, ...how }, sorting).skills, skills);

describe("an answer in free practice", () => {
  test("counts for the class of its arm, and for no other", () => {
    const skills = after({}, {}, "elbow-3r/chapter");
    expect(skills).toEqual({ differentiation: { ...NEW_SKILL, beyond: { space: { row: ["elbow-3r/chapter"] } } } });
    const more = after(skills, {}, "planar-2r/chapter", "planar-2r/full");
    expect(more["differentiation"]).toEqual({
      goals: [],
      row: ["planar-2r/chapter"],
      beyond: { space: { row: ["elbow-3r/chapter"] }, any: { row: ["planar-2r/full"] } },
    });
  });

  test("about an arm in no lesson counts for the class of any arms", () => {
    expect(after({}, {}, "puma-560/chapter")["differentiation"]!.beyond).toEqual({
      any: { row: ["puma-560/chapter"] },
    });
  });

  test("to a question in several lessons counts for all of them; to a question in none, for nothing", () => {
    const of = (question: string) =>
      Object.keys(countAnswer({}, item("planar-2r/chapter", question), right, sorting).skills);
    expect(of("joint-effect")).toEqual(["rates", "columns", "differentiation"]);
    expect(of("joint-torques")).toEqual([]);
  });

  test("counts as in a lesson: not with help or at a second try; a wrong one ends only its class's streak", () => {
    expect(after({}, { isHelped: true }, "planar-2r/chapter")).toEqual({});
    expect(after({}, { isRepeated: true }, "planar-2r/chapter")).toEqual({});
    const row = after({}, {}, "planar-2r/chapter", "elbow-3r/chapter");
    const wrong = after(row, { isRight: false }, "elbow-3r/lengths");
    expect(wrong["differentiation"]!.row).toEqual(["planar-2r/chapter"]);
    expect(wrong["differentiation"]!.beyond).toEqual({ space: { row: [] } });
    const learned = after(row, {}, "elbow-3r/lengths"); // there are two arms of this class
    expect(learned["differentiation"]!.beyond!["space"]!.learned).toBe(7);
    expect(learned["differentiation"]!.learned).toBeUndefined();
  });

  test("is reported with lesson and class", () => {
    const { outcomes } = countAnswer({}, item("elbow-3r/chapter"), right, sorting);
    expect(describeOutcomes(outcomes)).toEqual(["By differentiation, spatial arms: 1 of 2 right in a row"]);
    const again = countAnswer({}, item("elbow-3r/chapter"), { ...right, isRepeated: true }, sorting).outcomes;
    expect(describeOutcomes(again)).toEqual([
      "By differentiation, spatial arms: Correct this time. Only first tries count towards the 2 in a row.",
    ]);
  });
});

describe("a class", () => {
  const skills: Skills = {
    singular: { ...NEW_SKILL, row: [], learned: 1 }, // of which this bank asks nothing
    differentiation: {
      goals: [],
      row: ["planar-2r/chapter", "planar-2r/lengths"],
      learned: 1,
      mastered: DAY + 1,
      beyond: { space: { row: ["elbow-3r/chapter", "elbow-3r/lengths"], learned: 5 } },
    },
  };

  test("is due for review a day after its class is learned, until one more answer of that class is right", () => {
    expect(listDueClasses(skills, DAY, sorting)).toEqual([]);
    const due = listDueClasses(skills, DAY + 5, sorting);
    expect(due.map(describeTopicClass)).toEqual(["By differentiation, spatial arms"]);
    const asked = chooseFromClass(due[0]!, skills, [], () => 0)!;
    expect(asked.family).toBe("elbow-3r");
    expect(["chapter", "lengths"]).toContain(asked.key);
    const now = DAY + 5;
    const other = after(skills, { now }, "planar-2r/chapter", "elbow-3r/full");
    expect(listDueClasses(other, now, sorting)).toHaveLength(1);
    expect(listDueClasses(after(other, { now }, "elbow-3r/lengths"), now, sorting)).toEqual([]);
  });
});
