// Count an answer outside of lessons for every lesson that asks its question, and list the classes due for review.

import type { Index } from "../bank.js";
import { type Message, textOf, say } from "../text/text.js";
import { type Item, nameItem } from "./choice.js";
import { type ClassItems, type ClassPlace, countInClass, findStreak, listClasses } from "./classes.js";
import { type Attempt, chooseItem, isDue, NEW_SKILL, type Skills, type Streak } from "./skills.js";
import { type Topic, TOPICS } from "./topics.js";

/** The classes of a topic's arms, and the index of the class of each item, by the item's name. */
type ClassesOfTopic = { readonly classes: readonly ClassItems[]; readonly classIndices: ReadonlyMap<string, number> };

type ClassFinder = (topic: Topic) => ClassesOfTopic;

/** Return a function that finds the classes of a topic, computed when first needed: a bank has very many items. */
export function makeClassFinder(index: Index): ClassFinder {
  const classesByTopic = new Map<Topic, ClassesOfTopic>();
  return (topic) => {
    const knownClasses = classesByTopic.get(topic);
    if (knownClasses) return knownClasses;
    const classes = listClasses(index, topic);
    const classIndices = new Map(
      classes.flatMap(({ items }, classIndex) => items.map((item) => [nameItem(item), classIndex] as const)),
    );
    classesByTopic.set(topic, { classes, classIndices });
    return { classes, classIndices };
  };
}

/** A class of a topic's arms. */
export type TopicClass = ClassPlace & { readonly topic: Topic };

/** Return the classes for which an answer counts; an arm that a topic does not list counts for its class "any". */
function findCreditedClasses(item: Item, findClasses: ClassFinder): TopicClass[] {
  return TOPICS.filter(({ questions }) => questions.includes(item.question)).flatMap((topic) => {
    const { classes, classIndices } = findClasses(topic);
    const classIndex = classIndices.get(nameItem(item)) ?? classes.findIndex(({ name }) => name === "any");
    return classIndex >= 0 ? [{ topic, classes, classIndex }] : [];
  });
}

/** The effect of an answer on a class, as a sentence. */
export type Outcome = { readonly topicClass: TopicClass; readonly outcome: Message };

type CountedAnswer = { readonly skills: Skills; readonly outcomes: readonly Outcome[] };

/** Return the skills after an answer, and its effects. */
export function countAnswer(
  skills: Skills,
  item: Item,
  attempt: Attempt & { now: number },
  findClasses: ClassFinder,
): CountedAnswer {
  let newSkills = skills;
  const outcomes: Outcome[] = [];
  for (const topicClass of findCreditedClasses(item, findClasses)) {
    const { id } = topicClass.topic;
    const { skill, outcome } = countInClass(newSkills[id] ?? NEW_SKILL, topicClass, item, attempt);
    if (skill !== (newSkills[id] ?? NEW_SKILL)) newSkills = { ...newSkills, [id]: skill };
    if (outcome) outcomes.push({ topicClass, outcome });
  }
  return { skills: newSkills, outcomes };
}

/** Return the classes due for review, in the order of lessons. */
export function listDueClasses(skills: Skills, now: number, findClasses: ClassFinder): TopicClass[] {
  return TOPICS.flatMap((topic) => {
    const skill = skills[topic.id];
    const streaks: readonly Streak[] = skill ? [skill, ...Object.values(skill.beyond ?? {})] : [];
    if (!streaks.some((streak) => isDue(streak, now))) return [];
    const { classes } = findClasses(topic);
    return classes.flatMap((_, classIndex) =>
      isDue(findStreak(skill!, classes, classIndex), now) ? [{ topic, classes, classIndex }] : [],
    );
  });
}

/** Choose a question about an arm of a class, if possible none of those asked before. */
export function chooseFromClass(
  topicClass: TopicClass,
  skills: Skills,
  askedNames: readonly string[],
  random: () => number,
): Item | null {
  const { topic, classes, classIndex } = topicClass;
  return chooseItem(
    classes[classIndex]!.items,
    findStreak(skills[topic.id] ?? NEW_SKILL, classes, classIndex),
    askedNames,
    random,
  );
}

/** Return a lesson's title with the class of its arms, if it has several classes. */
export function describeTopicClass({ topic, classes, classIndex }: TopicClass): string {
  const title = say(topic.title);
  if (classes.length < 2) return title;
  return say("practice.of-class", { title, arms: say(`classes.${classes[classIndex]!.name}`) });
}

/** Return the effects of an answer, one sentence for each class. */
export const describeOutcomes = (outcomes: readonly Outcome[]): string[] =>
  outcomes.map(({ topicClass, outcome }) =>
    say("practice.counts", { what: describeTopicClass(topicClass), outcome: textOf(outcome) }),
  );
