// Choose the next question. One answered wrongly returns after two minutes, then after a day, three days and a week
// (Leitner's boxes).

import type { Index, Listed } from "../bank.js";
import { randomNumbers } from "../random.js";
import { message, type Message } from "../text/text.js";

/** What the student wants to practise; an empty field means anything. */
export interface Wish {
  readonly family: string;
  readonly question: string;
  readonly difficulty: number | null;
  readonly variation: string;
  /** The seed of a set from an instructor: everyone with it practises the same problems in the same order. */
  readonly set: string;
  /** Maximum number of problems in a set. */
  readonly count: number;
}

/** The steps of exercises/common/variation.py. */
export const STEPS = ["chapter", "lengths", "zeros", "frames", "full"] as const;

export const ANYTHING: Wish = { family: "", question: "", difficulty: null, variation: "", set: "", count: 10 };

/** A question about an arm of the bank. */
export type Item = { readonly family: string; readonly key: string; readonly question: string };

/** The state of an item: the last result, its box, when it is due, and whether it was ever answered wrongly. */
export interface ItemState {
  readonly right: boolean;
  readonly missed?: boolean;
  readonly box: number;
  readonly due: number;
}

/** The states of items by name. */
export type Progress = Readonly<Record<string, ItemState>>;

const DAY = 24 * 3600 * 1000;
/** Waiting time until an item of a box is due. */
export const WAITS: readonly number[] = [2 * 60 * 1000, DAY, 3 * DAY, 7 * DAY, 30 * DAY];

export const nameOf = ({ family, key, question }: Item): string => `${family}/${key}/${question}`;

/** Return the variations of the bank's arms: the standard steps in their order, then an instructor's own. */
export function variationsIn(index: Index): string[] {
  const names = new Set(index.families.flatMap(({ problems }) => problems.map((problem) => problem.variation)));
  return [...STEPS.filter((step) => names.delete(step)), ...names];
}

/** Return every item that a wish allows, in the bank's order. */
export function itemsFor(index: Index, wish: Wish): Item[] {
  return index.families
    .filter((family) => !wish.family || family.name === wish.family)
    .flatMap((family) =>
      family.problems
        .filter((problem) => wish.difficulty === null || problem.difficulty === wish.difficulty)
        .filter((problem) => !wish.variation || problem.variation === wish.variation)
        .flatMap((problem) =>
          problem.questions
            .filter((question) => !wish.question || question === wish.question)
            .map((question) => ({ family: family.name, key: problem.key, question })),
        ),
    );
}

/** Return a function that finds the problem of an item in the index. */
export function problemsIn(index: Index): (item: Item) => Listed {
  const listed = new Map(
    index.families.flatMap(({ name, problems }) =>
      problems.map((problem): [string, Listed] => [`${name}/${problem.key}`, problem]),
    ),
  );
  return ({ family, key }) => listed.get(`${family}/${key}`)!;
}

/** Return by how many steps the arm of a problem varies from the chapter's. */
export const stepOf = ({ variation }: Listed): number => Math.max(0, (STEPS as readonly string[]).indexOf(variation));

/** Return the next item: a wrong one that is due, else a random new one; null if there is none. */
export function chooseNext(
  index: Index,
  wish: Wish,
  progress: Progress,
  now: number,
  random: () => number,
  last = "",
): Item | null {
  const allowed = itemsFor(index, wish);
  const others = allowed.filter((item) => nameOf(item) !== last);
  const due = others.filter((item) => (progress[nameOf(item)]?.due ?? Infinity) <= now);
  const wrong = due.filter((item) => isMissed(progress[nameOf(item)]));
  const fresh = others.filter((item) => !progress[nameOf(item)]);
  const easy = Object.keys(progress).length < EASY_START ? easiest(index, fresh) : [];
  const pool = [wrong, easy, fresh, due, others, allowed].find((candidates) => candidates.length > 0);
  return pool?.[Math.floor(random() * pool.length)] ?? null;
}

/** How many questions a beginner gets from the easy ones. */
const EASY_START = 3;
/** Questions answered by looking at the arm, or from a picture with two lengths and two angles. */
const PLAIN = ["joint-effect", "position", "speed", "velocity-component", "jacobian-size"];

/** Return the items on the easiest arms of the first family that has them; plain questions if there are any. */
function easiest(index: Index, some: readonly Item[]): Item[] {
  const problemOf = problemsIn(index);
  const hardness = (item: Item): number => 5 * stepOf(problemOf(item)) + Math.max(1, problemOf(item).difficulty);
  const least = Math.min(...some.map(hardness));
  const easy = some.filter((item) => hardness(item) === least);
  const first = easy.filter(({ family }) => family === easy[0]!.family);
  const plain = first.filter(({ question }) => PLAIN.includes(question));
  return plain.length > 0 ? plain : first;
}

/** Return the items that were answered wrongly and are due again, longest due first. */
export function dueItems(index: Index, progress: Progress, now: number): Item[] {
  const dueTime = (item: Item): number => progress[nameOf(item)]?.due ?? Infinity;
  return itemsFor(index, ANYTHING)
    .filter((item) => isMissed(progress[nameOf(item)]) && dueTime(item) <= now)
    .sort((a, b) => dueTime(a) - dueTime(b));
}

/** Return the place of a set at which to continue: its first new item, or its beginning. */
export function placeIn(order: readonly Item[], progress: Progress): number {
  return Math.max(
    0,
    order.findIndex((item) => !progress[nameOf(item)]),
  );
}

/** Return the items of a set in its order. */
export function itemsOfSet(index: Index, wish: Wish): Item[] {
  return shuffle(itemsFor(index, wish), wish.set).slice(0, wish.count);
}

/** Return items in an order that a seed determines. */
export function shuffle(items: readonly Item[], seed: string): Item[] {
  const random = randomFrom(seed);
  const shuffled = [...items];
  for (let i = shuffled.length - 1; i > 0; i -= 1) {
    const j = Math.floor(random() * (i + 1));
    [shuffled[i], shuffled[j]] = [shuffled[j] as Item, shuffled[i] as Item];
  }
  return shuffled;
}

/** Return the progress after an attempt: a right item moves one box up, a wrong one back to the first. */
export function progressAfter(progress: Progress, item: Item, right: boolean, now: number): Progress {
  const before = progress[nameOf(item)];
  const box = right ? Math.min((before?.box ?? 0) + 1, WAITS.length - 1) : 0;
  const missed = isMissed(before) || !right ? { missed: true } : {};
  return { ...progress, [nameOf(item)]: { right, ...missed, box, due: now + (WAITS[box] as number) } };
}

/** Return whether an item was ever answered wrongly, and has to be repeated. */
export const isMissed = (attempt: ItemState | undefined): boolean =>
  attempt !== undefined && (!attempt.right || attempt.missed === true);

/** Return a generator of random numbers from 0 to 1, seeded by a text. */
export const randomFrom = (seed: string): (() => number) =>
  randomNumbers([...seed].reduce((hash, sign) => Math.imul(hash ^ (sign.codePointAt(0) ?? 0), 0x01000193), 0x811c9dc5));

/** Write a wish as the end of an address. */
export function wishToLink({ family, question, difficulty, variation, set, count }: Wish): string {
  const parameters = Object.entries({
    ...{ arm: family, question, difficulty: String(difficulty ?? ""), variation, set },
    n: set && count !== ANYTHING.count ? String(count) : "",
  }).filter(([, value]) => value);
  return parameters.length > 0 ? `?${new URLSearchParams(parameters)}` : "";
}

/** Parse a wish from the end of an address; invalid values are ignored. */
export function wishFromLink(search: string): Wish {
  const parameters = new URLSearchParams(search);
  const difficulty = parameters.get("difficulty");
  const step = difficulty === null ? NaN : Number(difficulty);
  const count = Number(parameters.get("n") ?? NaN);
  return {
    family: parameters.get("arm") ?? "",
    question: parameters.get("question") ?? "",
    difficulty: Number.isInteger(step) && step >= 0 && step <= 4 ? step : null,
    variation: parameters.get("variation") ?? "",
    set: parameters.get("set") ?? "",
    count: Number.isInteger(count) && count > 0 ? count : ANYTHING.count,
  };
}

/** Return what is wrong with a wish that allows no problem, or with a link to something unknown; else null. */
export function faultOf(index: Index, wish: Wish, search: string): Message | null {
  const arm = index.families.find(({ name }) => name === wish.family);
  const question = index.questions.find(({ name }) => name === wish.question);
  const difficulty = new URLSearchParams(search).get("difficulty");
  const known = variationsIn(index);
  if (wish.family && !arm)
    return message("practice.unknown-arm", {
      name: wish.family,
      known: index.families.map(({ name }) => name).join(", "),
    });
  if (wish.question && !question) return message("practice.unknown-question", { name: wish.question });
  if (wish.variation && !known.includes(wish.variation))
    return message("practice.unknown-variation", { name: wish.variation, known: known.join(", ") });
  if (difficulty !== null && wish.difficulty === null)
    return message("practice.unknown-difficulty", { name: difficulty });
  if (itemsFor(index, wish).length > 0) return null;
  if (arm && question && itemsFor(index, { ...ANYTHING, family: arm.name, question: question.name }).length === 0)
    return message("practice.never-asked", { question: question.title, arm: arm.title });
  return message("practice.none");
}
