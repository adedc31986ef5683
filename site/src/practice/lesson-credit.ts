// Count an answer outside of lessons for every lesson that asks its question, and list the classes due for review.

import type { Index } from "../bank.js";
import { type Message, textOf, say } from "../text/text.js";
import { type Item, nameOf } from "./choice.js";
import { classesOf, streakIn, type ClassItems, withStreak } from "./classes.js";
import {
  type Attempt,
  streakAfter,
  armCountOf,
  isDue,
  NEW_SKILL,
  nextIn,
  outcomeOf,
  type Streak,
  type Skills,
} from "./skills.js";
import { type Topic, TOPICS } from "./topics.js";

/** The classes of a topic's arms, and the index of the class of each item, by the item's name. */
type ClassesOfTopic = { readonly classes: readonly ClassItems[]; readonly places: ReadonlyMap<string, number> };

export type ClassFinder = (topic: Topic) => ClassesOfTopic;

/** Return a function that finds the classes of a topic, computed when first needed: a bank has very many items. */
export function classFinderOf(index: Index): ClassFinder {
  const known = new Map<Topic, ClassesOfTopic>();
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
export type TopicClass = { readonly topic: Topic; readonly classes: readonly ClassItems[]; readonly at: number };

/** Return the classes for which an answer counts; an arm that a topic does not list counts for its class "any". */
function classesFor(item: Item, findClasses: ClassFinder): TopicClass[] {
  return TOPICS.filter(({ questions }) => questions.includes(item.question)).flatMap((topic) => {
    const { classes, places } = findClasses(topic);
    const at = places.get(nameOf(item)) ?? classes.findIndex(({ name }) => name === "any");
    return at >= 0 ? [{ topic, classes, at }] : [];
  });
}

/** The effect of an answer on a class, as a sentence. */
export type Outcome = { readonly topicClass: TopicClass; readonly outcome: Message };

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
  for (const topicClass of classesFor(item, findClasses)) {
    const { topic, classes, at } = topicClass;
    const skill = after[topic.id] ?? NEW_SKILL;
    const before = streakIn(skill, classes, at);
    const armCount = armCountOf(classes[at]!.items);
    const streak = streakAfter(before, item, { ...attempt, armCount });
    const outcome = outcomeOf(before, streak, { ...attempt, armCount });
    if (streak !== before) after = { ...after, [topic.id]: withStreak(skill, classes, at, streak) };
    if (outcome) outcomes.push({ topicClass, outcome });
  }
  return { skills: after, outcomes };
}

/** Return the classes due for review, in the order of lessons. */
export function dueClasses(skills: Skills, now: number, findClasses: ClassFinder): TopicClass[] {
  return TOPICS.flatMap((topic) => {
    const skill = skills[topic.id];
    const streaks: readonly Streak[] = skill ? [skill, ...Object.values(skill.beyond ?? {})] : [];
    if (!streaks.some((streak) => isDue(streak, now))) return [];
    const { classes } = findClasses(topic);
    return classes.flatMap((_, at) => (isDue(streakIn(skill!, classes, at), now) ? [{ topic, classes, at }] : []));
  });
}

/** Choose a question about an arm of a class, if possible none of those in `asked`. */
export function chooseFrom(
  topicClass: TopicClass,
  skills: Skills,
  asked: readonly string[],
  random: () => number,
): Item | null {
  const { topic, classes, at } = topicClass;
  return nextIn(classes[at]!.items, streakIn(skills[topic.id] ?? NEW_SKILL, classes, at), asked, random);
}

/** Return a lesson's title with the class of its arms, if it has several classes. */
export function classInWords({ topic, classes, at }: TopicClass): string {
  const title = say(topic.title);
  if (classes.length < 2) return title;
  return say("practice.of-class", { title, arms: say(`classes.${classes[at]!.name}`) });
}

/** Return the effects of an answer, one sentence for each class. */
export const outcomesInWords = (outcomes: readonly Outcome[]): string[] =>
  outcomes.map(({ topicClass, outcome }) =>
    say("practice.counts", { what: classInWords(topicClass), outcome: textOf(outcome) }),
  );
