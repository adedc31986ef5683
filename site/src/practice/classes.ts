// Classes of arms: planar arms of the chapter, then spatial arms, then any. Each class is mastered separately.

import type { Index } from "../bank.js";
import { type Item, problemsIn, STEPS } from "./choice.js";
import { isDue, itemsOf, NEW_ROW, type Row, type Skill } from "./skills.js";
import type { Topic } from "./topics.js";

export const CLASSES = ["plain", "space", "any"] as const;
export type ArmClass = (typeof CLASSES)[number];

/** A class that a lesson has, with the questions about its arms, the easiest first. */
export type Stretch = { readonly name: ArmClass; readonly items: readonly Item[] };

/** Families of which every arm may be anything: asked once a lesson's own are known. */
const FURTHER = ["cylindrical", "spherical", "orthogonal-3r", "random-2", "random-3"];
/** The steps of variation that leave an arm as the chapter has it, but for its lengths. */
const PLAIN_STEPS: readonly string[] = STEPS.slice(0, 2);

/** The classes of a lesson of which the bank has arms, in their order. */
export function classesOf(index: Index, { questions, families }: Topic): readonly Stretch[] {
  const own = itemsOf(index, questions, families);
  const known = new Set(own.map(({ family }) => family));
  const further = FURTHER.filter((name) => !known.has(name));
  const more = index.families.some(({ name }) => further.includes(name))
    ? itemsOf(index, questions, further).filter(({ family }) => further.includes(family))
    : [];
  const problemOf = problemsIn(index);
  const classOf = (item: Item): ArmClass => {
    const { variation, flat } = problemOf(item);
    return !PLAIN_STEPS.includes(variation) ? "any" : flat ? "plain" : "space";
  };
  return CLASSES.map((name) => ({
    name,
    items: [...own.filter((item) => classOf(item) === name), ...(name === "any" ? more : [])],
  })).filter(({ items }) => items.length > 0);
}

/** How a class stands: that of the first one there is, is the skill's own, as it was kept before there were classes. */
export function rowOf(skill: Skill, classes: readonly Stretch[], at: number): Row {
  return at === 0 ? skill : (skill.beyond?.[classes[at]!.name] ?? NEW_ROW);
}

/** The skill with a row of a class. */
export function withRow(skill: Skill, classes: readonly Stretch[], at: number, row: Row): Skill {
  return at === 0 ? { ...skill, ...row } : { ...skill, beyond: { ...skill.beyond, [classes[at]!.name]: row } };
}

/** Which class is asked next: one that is due, else the first that is not learned yet, else the last. */
export function currentClass(skill: Skill, classes: readonly Stretch[], now: number): number {
  const rows = classes.map((_, at) => rowOf(skill, classes, at));
  const due = rows.findIndex((row) => isDue(row, now));
  if (due >= 0) return due;
  const open = rows.findIndex(({ learned }) => learned === undefined);
  return open >= 0 ? open : classes.length - 1;
}
