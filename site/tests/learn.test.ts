// The way through the chapter: rows of right answers, what is due, which item comes next; and that every goal of every
// lesson can be reached, and is not reached as the arm stands first.
import { expect, test } from "vitest";

import type { Robot, ValuesKey } from "../src/bank.js";
import { kindOfSingularity } from "../src/arm/descriptions.js";
import { armOf, measuresOf, reachOf, stateAt } from "../src/arm/model.js";
import type { Stage } from "../src/arm/stage.js";
import { firstWeld, journeyOf, type Weld } from "../src/arm/weld.js";
import { LESSONS, type GoalState, type Lesson } from "../src/learn/lessons.js";
import {
  updateStreak,
  countArms,
  isDue,
  listGuidedItems,
  listLessonItems,
  NEW_SKILL,
  chooseItem,
  describeOutcome,
  type Skill,
} from "../src/practice/skills.js";
import { loadState, storeState } from "../src/practice/stored-state.js";
import { computeRates, computeVelocity, FIRST_DIALS } from "../src/learn/tools.js";
import { type Item, VARIATION_STEPS } from "../src/practice/choice.js";
import { parse } from "../src/read/reader.js";
import { evaluateRealTree } from "../src/read/real.js";
import { resultOrNull } from "../src/storage.js";
import en from "../src/text/en.json" with { type: "json" };
import forms from "./forms.json" with { type: "json" };

const item = (key: string, question = "jacobian"): Item => ({ family: "planar-2r", key, question });
const right = (skill: Skill, key: string, now = 0, isHelped = false, armCount = 9, isRepeated = false) =>
  updateStreak(skill, item(key), { isRight: true, isHelped, isRepeated, now, armCount });
const DAY = 24 * 3600 * 1000;

test("three arms in a row without help make a class learned, and one more after a day makes it mastered", () => {
  let skill = right(right(NEW_SKILL, "001"), "001");
  expect(skill.row).toHaveLength(1);
  skill = right(skill, "002", 0, true);
  expect(skill.row).toHaveLength(1);
  skill = right(right(skill, "002"), "003", 7);
  expect(skill.learned).toBe(7);
  expect(isDue(skill, 7 + DAY - 1)).toBe(false);
  expect(right(skill, "004", 8).mastered).toBeUndefined();
  expect(isDue(skill, 7 + DAY)).toBe(true);
  skill = right(skill, "004", 7 + DAY);
  expect(skill.mastered).toBe(7 + DAY);
  expect(isDue(skill, 9 * DAY)).toBe(false);
});

test("a wrong answer ends the streak, and in a bank of two arms two are enough", () => {
  const row = right(right(NEW_SKILL, "001"), "002");
  expect(
    updateStreak(row, item("003"), { isRight: false, isHelped: false, isRepeated: false, now: 0, armCount: 9 }).row,
  ).toEqual([]);
  expect(right(right(NEW_SKILL, "001", 0, false, 2), "002", 5, false, 2).learned).toBe(5);
});

test("the next question is about an arm that is not in the streak, plain arms first", () => {
  const all = ["001", "002", "003"].map((key) => item(key));
  expect(chooseItem(all, NEW_SKILL, [], () => 0)?.key).toBe("001");
  const row = right(NEW_SKILL, "001");
  expect(chooseItem(all, row, ["planar-2r/001/jacobian"], () => 0.99)?.key).not.toBe("001");
  expect(chooseItem([item("001")], row, ["planar-2r/001/jacobian"], () => 0)?.key).toBe("001");
  expect(chooseItem([], NEW_SKILL, [], () => 0)).toBeNull();
});

test("a question already asked in this visit is not asked again while there are others", () => {
  const all = ["001", "002", "003"].map((key) => item(key));
  const names = all.map(({ key }) => `planar-2r/${key}/jacobian`);
  for (const luck of [0, 0.5, 0.999]) {
    expect(chooseItem(all, NEW_SKILL, [names[0]!, names[2]!], () => luck)?.key).toBe("002");
    expect(chooseItem(all, NEW_SKILL, names, () => luck)?.key).not.toBe("003");
  }
});

test("short questions count for their arm only", () => {
  expect(right(right(NEW_SKILL, "001"), "001-quiz").row).toEqual(["planar-2r/001"]);
  expect(
    listGuidedItems(
      ["001", "001-quiz"].map((key) => item(key, key)),
      ["001-quiz", "001", "position"],
    ),
  ).toEqual([item("001-quiz", "001-quiz"), item("001", "001")]);
  expect(countArms(["001", "001-quiz", "002"].map((key) => item(key)))).toBe(2);
});

test("a question first answered wrong counts for nothing, and a message gives the reason", () => {
  const how = (isRight: boolean, isHelped = false, isRepeated = false) => ({ isRight, isHelped, isRepeated });
  const row = right(NEW_SKILL, "001");
  expect(right(row, "002", 0, false, 9, true)).toEqual(row);
  const learned: Skill = { ...NEW_SKILL, row: ["a", "b", "c"], learned: 0 };
  expect(right(learned, "004", 2 * DAY, false, 9, true).mastered).toBeUndefined();
  const outcomeKey = (before: Skill, after: Skill, was: ReturnType<typeof how>) =>
    describeOutcome(before, after, { ...was, armCount: 9 })?.key;
  expect(outcomeKey(NEW_SKILL, row, how(true))).toBe("lesson.state-row");
  expect(outcomeKey(row, NEW_SKILL, how(false))).toBe("lesson.row-broken");
  expect(outcomeKey(NEW_SKILL, NEW_SKILL, how(false))).toBeUndefined();
  expect(outcomeKey(NEW_SKILL, NEW_SKILL, how(true, true))).toBe("lesson.counts-not-helped");
  expect(outcomeKey(learned, learned, how(true, false, true))).toBe("lesson.counts-not-again");
  const one: Skill = { goals: [], row: ["planar-2r/001"] };
  const tried = { isRight: false, isHelped: false, isRepeated: true, now: 0, armCount: 9 };
  expect(updateStreak(one, item("001"), tried)).toEqual(one); // the first answer was right
  expect(outcomeKey(one, one, tried)).toBe(undefined);
  expect(outcomeKey(row, learned, how(true))).toBe("lesson.learned");
  expect(outcomeKey(learned, { ...learned, mastered: 9 }, how(true))).toBe("lesson.mastered");
});

test("the difficulty rises with the streak, from the chapter's plainest arms", () => {
  const families = ["planar-2r", "elbow"];
  const index = {
    format: 1,
    feedback: "solutions",
    questions: [],
    families: [...families]
      .reverse()
      .map((name) => ({
        name,
        title: name,
        source: "",
        problems: [...VARIATION_STEPS]
          .reverse()
          .flatMap((variation) =>
            ["1", "2", "3"].map((number) => ({
              key: `${variation} ${number}`,
              title: "",
              difficulty: 1,
              variation,
              questions: ["velocity", "joint-effect"],
            })),
          ),
      })),
  } as const;
  const all = listLessonItems(index, ["joint-effect", "velocity"], families);
  const rows = [[], ["a/1"], ["a/1", "a/2"]];
  const [first, second, third] = rows.map((row) =>
    [0, 0.5, 0.999].map((luck) => all.indexOf(chooseItem(all, { row }, [], () => luck)!)),
  ) as [number[], number[], number[]];
  for (const place of first)
    expect(all[place]).toMatchObject({
      family: "planar-2r",
      question: "joint-effect",
      key: expect.stringMatching(/^chapter/),
    });
  expect(second[2]).toBeGreaterThan(first[2]!);
  expect(third[1]).toBeGreaterThan(second[1]!);
  expect(third[2]).toBeLessThan(0.6 * all.length);
});

test("a lesson asks about its own families, or about others if the bank has none of them", () => {
  const listed = (variation: string) => ({
    key: variation,
    title: "",
    difficulty: 1,
    variation,
    questions: ["rank", "twist"],
  });
  const family = (name: string) => ({ name, title: name, source: "", problems: [listed("full"), listed("chapter")] });
  const index = { format: 1, feedback: "solutions", questions: [], families: [family("b"), family("a")] } as const;
  expect(listLessonItems(index, ["rank"], ["a", "b"]).map((each) => each.family + each.key)).toEqual([
    "achapter",
    "bchapter",
    "afull",
    "bfull",
  ]);
  expect(listLessonItems(index, ["rank"], ["c"])).toHaveLength(4);
  expect(listLessonItems(index, ["position"], ["a"])).toEqual([]);
});

test("stored skills are restored, and invalid entries are ignored", () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
  } as unknown as Storage;
  const skills = {
    rates: { row: ["a/1"], goals: [0], learned: 3 },
    columns: { row: [], goals: [], predicted: 1, beyond: { space: { row: ["b/1"], learned: 4 } } },
  };
  storeState(storage, { lessons: skills });
  expect(loadState(storage).lessons).toEqual(skills);
  kept.set(
    [...kept.keys()][0]!,
    '{"rates": {"row": 3}, "path": 7, "kinds": {"row": [], "goals": [], "beyond": {"space": 1}}}',
  );
  expect(loadState(storage).lessons).toEqual({});
  kept.set([...kept.keys()][0]!, "no JSON");
  expect(loadState(storage).lessons).toEqual({});
});

const row = (a: string, alpha: string, d: string, i: number) =>
  ({ kind: "R", theta: `theta${i}`, d, a, alpha }) as const;
const robot = (joints: Robot["joints"], task: Robot["task"], values: Robot["values"]): Robot => ({
  name: "arm",
  title: "arm",
  joints,
  base: { position: ["0", "0", "0"], yaw: "0", tilt: "0" },
  point: { frame: joints.length, offset: ["0", "0", "0"] },
  task,
  values,
});
const PLAIN = armOf(robot([row("a1", "0", "0", 1), row("a2", "0", "0", 2)], ["vx", "vy"], { a1: 0.4, a2: 0.34 }));
const ELBOW = armOf(
  robot([row("a1", "pi/2", "d1", 1), row("a2", "0", "0", 2), row("a3", "0", "0", 3)], ["vx", "vy", "vz"], {
    a1: 0.2,
    a2: 0.34,
    a3: 0.288,
    d1: 0.4,
  }),
);
const degrees = (...angles: number[]) => angles.map((angle) => (angle * Math.PI) / 180);

/** What is seen of an arm in a pose. */
function seen(
  arm: typeof PLAIN,
  pose: number[],
  more: { rates?: number[]; weld?: Weld; place?: number } = {},
): GoalState {
  const state = stateAt(arm, pose);
  const rates = more.rates ?? [];
  const welding = more.weld ? { weld: more.weld, journey: journeyOf(arm, more.weld), place: more.place ?? 0 } : null;
  const stage = {
    arm,
    pose,
    state,
    settledState: state,
    reach: reachOf(arm),
    measures: measuresOf(arm, state),
    welding,
  };
  return { stage: stage as unknown as Stage, rates, velocity: computeVelocity(arm, state, rates) };
}

const wanted = (pose: number[], direction: number) =>
  seen(PLAIN, pose, { rates: [...computeRates("wanted", { rates: [], direction }, stateAt(PLAIN, pose))] });
const pushing = (pose: number[], direction: number) =>
  seen(PLAIN, pose, { rates: [...computeRates("force", { rates: [], direction }, stateAt(PLAIN, pose))] });
/** The direction (degrees) of P at the rates 1 and -1. */
const equalRatesDirection = (pose: number[]): number => {
  const { velocity } = seen(PLAIN, pose, { rates: [1, -1] });
  return (Math.atan2(velocity[1], velocity[0]) * 180) / Math.PI;
};
const FIRST = degrees(60, 100);
const weld = { ...firstWeld(PLAIN, FIRST, reachOf(PLAIN)), revoluteLimit: 20 };
const short: Weld = { ...weld, target: stateAt(PLAIN, degrees(62, 98)).point, speed: 0.02 };
/** Of each goal: a way to reach it. */
const WAYS: Readonly<Record<string, readonly GoalState[]>> = {
  rates: [
    seen(PLAIN, FIRST, { rates: [0, 0.5] }),
    seen(PLAIN, degrees(0, 90), { rates: [0.5, -0.5] }),
    wanted(FIRST, 180 + (Math.atan2(0.463, -0.119) * 180) / Math.PI),
  ],
  columns: [seen(PLAIN, degrees(-90, 90)), seen(PLAIN, degrees(0, 180)), seen(PLAIN, degrees(20, 0.2))],
  differentiation: [seen(PLAIN, degrees(0, 0)), seen(PLAIN, degrees(30, 60))],
  propagation: [seen(PLAIN, degrees(10, 148.2)), seen(PLAIN, degrees(10, 0))],
  links: [
    seen(PLAIN, FIRST, { rates: [0.5, -0.5] }),
    seen(PLAIN, FIRST, { rates: [0, 0.5] }),
    seen(PLAIN, degrees(0, 0), { rates: [0.5, 0.0882] }),
  ],
  numbers: [
    wanted(FIRST, 180),
    wanted(degrees(20, 110), equalRatesDirection(degrees(20, 110))),
    wanted(degrees(0, 90), -90),
  ],
  workspace: [
    seen(ELBOW, degrees(20, 30, 0)),
    seen(ELBOW, degrees(20, 30, 180)),
    seen(ELBOW, [0.3, 2.2, innerAngle(2.2)]),
  ],
  torques: [
    pushing(FIRST, (Math.atan2(stateAt(PLAIN, FIRST).point[1], stateAt(PLAIN, FIRST).point[0]) * 180) / Math.PI),
    pushing(degrees(30, 0), 30),
    pushing(degrees(30, 0), 120),
  ],
  inverse: [wanted(degrees(0, 90), 180), wanted(degrees(0, 1), 0)],
  singular: [seen(PLAIN, degrees(5, 1)), seen(PLAIN, degrees(5, -179.5)), seen(PLAIN, degrees(5, 90))],
  kinds: [seen(ELBOW, degrees(20, 30, 0)), seen(ELBOW, [0.3, 2.2, innerAngle(2.2)])],
  path: [
    seen(PLAIN, FIRST, { weld, place: 10 }),
    seen(PLAIN, FIRST, { weld: { ...weld, revoluteLimit: 0.05 } }),
    seen(PLAIN, FIRST, { weld: short }),
  ],
};

test("the folded elbow arm is singular inside its workspace, as the lesson on the workspace says", () => {
  const [outer, folded] = [degrees(20, 30, 0), degrees(20, 30, 180)].map((pose) =>
    kindOfSingularity(ELBOW, stateAt(ELBOW, pose)),
  );
  expect([outer, folded]).toEqual(["boundary", "internal"]);
});

/** theta3 for which P is above joint 1: a1 + a2 c2 + a3 c23 = 0. */
function innerAngle(theta2: number): number {
  return Math.acos((-0.2 - 0.34 * Math.cos(theta2)) / 0.288) - theta2;
}

for (const lesson of LESSONS)
  test(`every goal of the lesson ${lesson.id} can be reached, and is not reached by the first pose`, () => {
    const arm = lesson.arm === "plain" ? PLAIN : ELBOW;
    const pose = lesson.start ? degrees(...lesson.start) : lesson.arm === "plain" ? FIRST : degrees(40, 30, 60);
    const rates = computeRates(lesson.tool, FIRST_DIALS, stateAt(arm, pose));
    const first = seen(arm, pose, { rates: [...rates], weld: { ...weld, revoluteLimit: 0.6 } });
    const { prediction, intro, idea, example } = lesson;
    for (const text of [intro, ...idea, example, prediction.question, ...prediction.options, prediction.outcome])
      expect(en).toHaveProperty([text]);
    expect(prediction.options[prediction.right]).toBeDefined();
    expect(lesson.goals[prediction.goal]).toBeDefined();
    lesson.goals.forEach(({ isReached, text }, i) => {
      expect(en).toHaveProperty([text]);
      expect(isReached(WAYS[lesson.id]![i]!), text).toBe(true);
      if (lesson.id !== "path") expect(isReached(first), text).toBe(false);
    });
    expect(WAYS[lesson.id]).toHaveLength(lesson.goals.length);
  });

test("the arm of the lesson on singularities is first far from all poses that its prediction is about", () => {
  const { start, prediction } = LESSONS.find(({ id }) => id === "singular")!;
  const offered = prediction.options.map((key) => Number(/^\d+/.exec(en[key])![0]));
  for (const angle of [...offered, 180]) expect(Math.abs(start![1]! - angle)).toBeGreaterThan(30);
});

/** The formulas in a text: each side of an equation, and each component of a vector, with and without a bracket. */
const formulasIn = (text: string): string[] =>
  [...text.matchAll(/\$(.*?)\$/g)]
    .flatMap(([, latex]) => latex!.replaceAll(/\{(\d) (\d)\}/g, "{$1$2}").split(/=|, /))
    .flatMap((side) => [side, side.replace(/^ *\(/, ""), side.replace(/\) *$/, "")]);

const [PLANAR] = forms.problems;
for (const lesson of LESSONS)
  for (const question of lesson.questions)
    test(`the texts of the lesson ${lesson.id} don't contain the answer to ${question}`, () => {
      const texts = Object.entries(en).flatMap(([key, text]) => (key.startsWith(`lesson.${lesson.id}.`) ? [text] : []));
      for (const { kind, key } of PLANAR!.parts) {
        if (kind !== question || key.type !== "values") continue;
        const { symbols, points, right, moving } = key as unknown as ValuesKey;
        for (const formula of texts.flatMap(formulasIn)) {
          const tree = resultOrNull(() => parse(formula, new Set(symbols)));
          if (!tree || tree.kind === "name") continue; // a symbol alone gives nothing away
          const values = points.map((point) =>
            resultOrNull(() => evaluateRealTree(tree, Object.fromEntries(symbols.map((name, i) => [name, point[i]!])))),
          );
          for (const entry of moving ?? [])
            expect(
              values.every((value, i) => Math.abs(value! - right[entry]![i]!) < 1e-9),
              formula,
            ).toBe(false);
        }
      }
    });

test("det J is shown from the first lesson on that mentions it", () => {
  const mentionsIt = ({ id }: Lesson): boolean =>
    Object.entries(en).some(([key, text]) => key.startsWith(`lesson.${id}.`) && /det\b/.test(String(text)));
  const first = LESSONS.findIndex(mentionsIt);
  expect(first).toBeGreaterThan(1);
  expect(LESSONS.map(({ unknown }) => unknown === null)).toEqual(LESSONS.map((_, i) => i >= first));
});
