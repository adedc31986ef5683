// Classes of arms: planar arms of the chapter, then spatial arms, then any. Each class is mastered separately.

import type { Index } from "../bank.js";
import { type Item, makeProblemFinder, VARIATION_STEPS } from "./choice.js";
import type { Message } from "../text/text.js";
import type { Attempt, Skill, Streak } from "./skills.js";
import { countArms, describeOutcome, isDue, listLessonItems, NO_STREAK, updateStreak } from "./skills.js";
import type { Topic } from "./topics.js";

/** "plain": planar arms of the chapter; "space": its other arms; "any": arms that vary, and additional families. */
export const CLASSES = ["plain", "space", "any"] as const;
type ArmClass = (typeof CLASSES)[number];

/** A class of arms in a lesson, with the questions about its arms, easiest first. */
export type ClassItems = { readonly name: ArmClass; readonly items: readonly Item[] };

/** A class of arms, by its index among a lesson's classes. */
export type ClassPlace = { readonly classes: readonly ClassItems[]; readonly classIndex: number };

/** Families with arms of all kinds. A lesson asks about them in its last class, in addition to its own families. */
const ADDITIONAL_FAMILIES = ["cylindrical", "spherical", "orthogonal-3r", "random-2", "random-3"];
/** The steps of variation that change only lengths of the chapter's arm. */
const PLAIN_STEPS: readonly string[] = VARIATION_STEPS.slice(0, 2);

/** Return the classes of a lesson for which the bank has arms, in their order. */
export function listClasses(index: Index, { questions, families }: Topic): readonly ClassItems[] {
  const lessonItems = listLessonItems(index, questions, families);
  const lessonFamilies = new Set(lessonItems.map(({ family }) => family));
  const additionalFamilies = ADDITIONAL_FAMILIES.filter((name) => !lessonFamilies.has(name));
  const additionalItems = index.families.some(({ name }) => additionalFamilies.includes(name))
    ? listLessonItems(index, questions, additionalFamilies).filter(({ family }) => additionalFamilies.includes(family))
    : [];
  const findProblem = makeProblemFinder(index);
  const findClass = (item: Item): ArmClass => {
    const { variation, flat } = findProblem(item);
    return !PLAIN_STEPS.includes(variation) ? "any" : flat ? "plain" : "space";
  };
  return CLASSES.map((name) => ({
    name,
    items: [...lessonItems.filter((item) => findClass(item) === name), ...(name === "any" ? additionalItems : [])],
  })).filter(({ items }) => items.length > 0);
}

/** Return the progress in a class. That in the first class is the skill itself, because old files have no classes. */
export function findStreak(skill: Skill, classes: readonly ClassItems[], classIndex: number): Streak {
  return classIndex === 0 ? skill : (skill.beyond?.[classes[classIndex]!.name] ?? NO_STREAK);
}

/** Return the skill with the progress in a class. */
export function replaceStreak(skill: Skill, classes: readonly ClassItems[], classIndex: number, streak: Streak): Skill {
  return classIndex === 0
    ? { ...skill, ...streak }
    : { ...skill, beyond: { ...skill.beyond, [classes[classIndex]!.name]: streak } };
}

/** Return the skill after an answer about an arm of a class, and the answer's effect; null if it has no effect. */
export function countInClass(
  skill: Skill,
  { classes, classIndex }: ClassPlace,
  item: Item,
  attempt: Attempt & { now: number },
): { readonly skill: Skill; readonly outcome: Message | null } {
  const armCount = countArms(classes[classIndex]!.items);
  const streak = findStreak(skill, classes, classIndex);
  const newStreak = updateStreak(streak, item, { ...attempt, armCount });
  return {
    skill: newStreak === streak ? skill : replaceStreak(skill, classes, classIndex, newStreak),
    outcome: describeOutcome(streak, newStreak, { ...attempt, armCount }),
  };
}

/** Return the index of the class to ask next: the first one due, else the first not learned yet, else the last. */
export function chooseClassIndex(skill: Skill, classes: readonly ClassItems[], now: number): number {
  const streaks = classes.map((_, classIndex) => findStreak(skill, classes, classIndex));
  const firstDue = streaks.findIndex((streak) => isDue(streak, now));
  if (firstDue >= 0) return firstDue;
  const firstUnlearned = streaks.findIndex(({ learned }) => learned === undefined);
  return firstUnlearned >= 0 ? firstUnlearned : classes.length - 1;
}
