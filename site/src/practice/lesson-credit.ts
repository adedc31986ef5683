// Count an answer outside of lessons for every lesson that asks its question, and list the classes due for review.

import type { Index } from "../bank.js";
import { type Message, textOf, say } from "../text/text.js";
import { type Item, nameOf } from "./choice.js";
import { classesOf, rowOf, type ClassItems, withRow } from "./classes.js";
import { type Attempt, rowAfter, armCountOf, isDue, NEW, nextIn, outcomeOf, type Row, type Skills } from "./skills.js";
import { type Topic, TOPICS } from "./topics.js";

/** The classes of a topic's arms, and the index of the class of each item, by the item's name. */
type TopicClasses = { readonly classes: readonly ClassItems[]; readonly places: ReadonlyMap<string, number> };

export type ClassFinder = (topic: Topic) => TopicClasses;

/** Return a function that finds the classes of a topic, computed when first needed: a bank has very many items. */
export function classFinderOf(index: Index): ClassFinder {
  const known = new Map<Topic, TopicClasses>();
  return (topic) => {
    const earlier = known.get(topic);
    if (earlier) return earlier;
    const classes = classesOf(index, topic);
    const places = new Map(classes.flatMap(({ items }, at) => items.map((item) => [nameOf(item), at] as const)));
    known.set(topic, { classes, places });
    return { classes, places };
  };
}

/** A class of a topic, by its index among the topic's classes. */
export type ClassOfTopic = { readonly topic: Topic; readonly classes: readonly ClassItems[]; readonly at: number };

/** Return the classes for which an answer counts; an arm that a topic does not list counts for its class "any". */
function classesFor(item: Item, findClasses: ClassFinder): ClassOfTopic[] {
  return TOPICS.filter(({ questions }) => questions.includes(item.question)).flatMap((topic) => {
    const { classes, places } = findClasses(topic);
    const at = places.get(nameOf(item)) ?? classes.findIndex(({ name }) => name === "any");
    return at >= 0 ? [{ topic, classes, at }] : [];
  });
}

/** The effect of an answer on a class, as a sentence. */
export type Outcome = { readonly of: ClassOfTopic; readonly outcome: Message };

type Counted = { readonly skills: Skills; readonly outcomes: readonly Outcome[] };

/** Return the skills after an answer, and its effects. */
export function countAnswer(
  skills: Skills,
  item: Item,
  attempt: Attempt & { now: number },
  findClasses: ClassFinder,
): Counted {
  let after = skills;
  const outcomes: Outcome[] = [];
  for (const of of classesFor(item, findClasses)) {
    const { topic, classes, at } = of;
    const skill = after[topic.id] ?? NEW;
    const before = rowOf(skill, classes, at);
    const armCount = armCountOf(classes[at]!.items);
    const row = rowAfter(before, item, { ...attempt, armCount });
    const outcome = outcomeOf(before, row, { ...attempt, armCount });
    if (row !== before) after = { ...after, [topic.id]: withRow(skill, classes, at, row) };
    if (outcome) outcomes.push({ of, outcome });
  }
  return { skills: after, outcomes };
}

/** Return the classes due for review, in the order of lessons. */
export function dueClasses(skills: Skills, now: number, findClasses: ClassFinder): ClassOfTopic[] {
  return TOPICS.flatMap((topic) => {
    const skill = skills[topic.id];
    const rows: readonly Row[] = skill ? [skill, ...Object.values(skill.beyond ?? {})] : [];
    if (!rows.some((row) => isDue(row, now))) return [];
    const { classes } = findClasses(topic);
    return classes.flatMap((_, at) => (isDue(rowOf(skill!, classes, at), now) ? [{ topic, classes, at }] : []));
  });
}

/** Choose a question about an arm of a class, if possible none of those in `asked`. */
export function chooseFrom(
  of: ClassOfTopic,
  skills: Skills,
  asked: readonly string[],
  random: () => number,
): Item | null {
  const { topic, classes, at } = of;
  return nextIn(classes[at]!.items, rowOf(skills[topic.id] ?? NEW, classes, at), asked, random);
}

/** Return a lesson's title with the class of its arms, if it has several classes. */
export function classInWords({ topic, classes, at }: ClassOfTopic): string {
  const title = say(topic.title);
  if (classes.length < 2) return title;
  return say("practice.of-class", { title, arms: say(`classes.${classes[at]!.name}`) });
}

/** Return the effects of an answer, one sentence for each class. */
export const outcomesInWords = (outcomes: readonly Outcome[]): string[] =>
  outcomes.map(({ of, outcome }) => say("practice.counts", { what: classInWords(of), outcome: textOf(outcome) }));
