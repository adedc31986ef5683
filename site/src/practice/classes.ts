// Classes of arms: planar arms of the chapter, then spatial arms, then any. Each class is mastered separately.

import type { Index } from "../bank.js";
import { type Item, problemsIn, STEPS } from "./choice.js";
import { isDue, itemsOf, NO_STREAK, type Streak, type Skill } from "./skills.js";
import type { Topic } from "./topics.js";

export const CLASSES = ["plain", "space", "any"] as const;
export type ArmClass = (typeof CLASSES)[number];

/** A class of arms in a lesson, with the questions about its arms, easiest first. */
export type ClassItems = { readonly name: ArmClass; readonly items: readonly Item[] };

/** Families with arms of all kinds, which are asked after a lesson's own arms are known. */
const FURTHER = ["cylindrical", "spherical", "orthogonal-3r", "random-2", "random-3"];
/** The steps of variation that change only lengths of the chapter's arm. */
const PLAIN_STEPS: readonly string[] = STEPS.slice(0, 2);

/** Return the classes of a lesson for which the bank has arms, in their order. */
export function classesOf(index: Index, { questions, families }: Topic): readonly ClassItems[] {
  const lessonItems = itemsOf(index, questions, families);
  const known = new Set(lessonItems.map(({ family }) => family));
  const additional = FURTHER.filter((name) => !known.has(name));
  const more = index.families.some(({ name }) => additional.includes(name))
    ? itemsOf(index, questions, additional).filter(({ family }) => additional.includes(family))
    : [];
  const problemOf = problemsIn(index);
  const classOf = (item: Item): ArmClass => {
    const { variation, flat } = problemOf(item);
    return !PLAIN_STEPS.includes(variation) ? "any" : flat ? "plain" : "space";
  };
  return CLASSES.map((name) => ({
    name,
    items: [...lessonItems.filter((item) => classOf(item) === name), ...(name === "any" ? more : [])],
  })).filter(({ items }) => items.length > 0);
}

/** Return the progress in a class; that of the first class is stored in the skill itself, for older progress files. */
export function streakIn(skill: Skill, classes: readonly ClassItems[], at: number): Streak {
  return at === 0 ? skill : (skill.beyond?.[classes[at]!.name] ?? NO_STREAK);
}

/** Return the skill with the progress in a class. */
export function withStreak(skill: Skill, classes: readonly ClassItems[], at: number, streak: Streak): Skill {
  return at === 0 ? { ...skill, ...streak } : { ...skill, beyond: { ...skill.beyond, [classes[at]!.name]: streak } };
}

/** Return the class to ask next: one that is due, else the first that is not learned, else the last. */
export function currentClass(skill: Skill, classes: readonly ClassItems[], now: number): number {
  const streaks = classes.map((_, at) => streakIn(skill, classes, at));
  const firstDue = streaks.findIndex((streak) => isDue(streak, now));
  if (firstDue >= 0) return firstDue;
  const open = streaks.findIndex(({ learned }) => learned === undefined);
  return open >= 0 ? open : classes.length - 1;
}
