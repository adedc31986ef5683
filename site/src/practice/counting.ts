// Count an answer outside of lessons for every lesson that asks its question, and list the classes due for review.

import type { Index } from "../bank.js";
import { type Message, said, say } from "../text/text.js";
import { type Item, nameOf } from "./choice.js";
import { classesOf, rowOf, type Stretch, withRow } from "./classes.js";
import { type Answered, answered, armsIn, isDue, NEW, nextIn, outcomeOf, type Row, type Skills } from "./skills.js";
import { type Topic, TOPICS } from "./topics.js";

/** The classes of a topic's arms, and in which of them an item is, by its name. */
type Sorted = { readonly classes: readonly Stretch[]; readonly places: ReadonlyMap<string, number> };

export type Sorting = (topic: Topic) => Sorted;

/** How the items of a bank are sorted, each topic's once it is asked for: a bank has tens of thousands. */
export function sortingOf(index: Index): Sorting {
  const known = new Map<Topic, Sorted>();
  return (topic) => {
    let found = known.get(topic);
    if (!found) {
      const classes = classesOf(index, topic);
      const places = new Map(
        classes.flatMap(({ items }, at) => items.map((item): [string, number] => [nameOf(item), at])),
      );
      known.set(topic, (found = { classes, places }));
    }
    return found;
  };
}

/** A class of a topic, by its place among the topic's classes. */
export type ClassOfTopic = { readonly topic: Topic; readonly classes: readonly Stretch[]; readonly at: number };

/** The classes that an answer to an item counts for; an arm of which a topic does not speak is among its any arms. */
function classesFor(item: Item, sorting: Sorting): ClassOfTopic[] {
  return TOPICS.filter(({ questions }) => questions.includes(item.question)).flatMap((topic) => {
    const { classes, places } = sorting(topic);
    const at = places.get(nameOf(item)) ?? classes.findIndex(({ name }) => name === "any");
    return at >= 0 ? [{ topic, classes, at }] : [];
  });
}

/** What came of an answer for a class; null where nothing is to be said of it. */
export type Outcome = { readonly of: ClassOfTopic; readonly outcome: Message };

type Counted = { readonly skills: Skills; readonly outcomes: readonly Outcome[] };

/** The skills after an answer, and what came of it. */
export function counted(skills: Skills, item: Item, how: Answered & { now: number }, sorting: Sorting): Counted {
  let after = skills;
  const outcomes: Outcome[] = [];
  for (const of of classesFor(item, sorting)) {
    const { topic, classes, at } = of;
    const skill = after[topic.id] ?? NEW;
    const before = rowOf(skill, classes, at);
    const most = armsIn(classes[at]!.items);
    const row = answered(before, item, { ...how, most });
    const outcome = outcomeOf(before, row, { ...how, most });
    if (row !== before) after = { ...after, [topic.id]: withRow(skill, classes, at, row) };
    if (outcome) outcomes.push({ of, outcome });
  }
  return { skills: after, outcomes };
}

/** The classes that are to be looked at again, those of the first lessons first. */
export function dueClasses(skills: Skills, now: number, sorting: Sorting): ClassOfTopic[] {
  return TOPICS.flatMap((topic) => {
    const skill = skills[topic.id];
    const rows: readonly Row[] = skill ? [skill, ...Object.values(skill.beyond ?? {})] : [];
    if (!rows.some((row) => isDue(row, now))) return [];
    const { classes } = sorting(topic);
    return classes.flatMap((_, at) => (isDue(rowOf(skill!, classes, at), now) ? [{ topic, classes, at }] : []));
  });
}

/** A question about an arm of a class: none of those that were `asked` while there are others. */
export function drawnFrom(
  of: ClassOfTopic,
  skills: Skills,
  asked: readonly string[],
  random: () => number,
): Item | null {
  const { topic, classes, at } = of;
  return nextIn(classes[at]!.items, rowOf(skills[topic.id] ?? NEW, classes, at), asked, random);
}

/** A lesson and, where it has several, the class of its arms, in words. */
export function classInWords({ topic, classes, at }: ClassOfTopic): string {
  const title = say(topic.title);
  if (classes.length < 2) return title;
  return say("practice.of-class", { title, arms: say(`classes.${classes[at]!.name}`) });
}

/** What came of an answer, in a line for each class. */
export const outcomesInWords = (outcomes: readonly Outcome[]): string[] =>
  outcomes.map(({ of, outcome }) => say("practice.counts", { what: classInWords(of), outcome: said(outcome) }));
