// Choose the next question. One answered wrongly returns after two others, then after a day, three days, a week
// (Leitner's boxes).

import type { Index, Listed } from "../bank.js";
import { randomNumbers } from "../random.js";
import { message, type Message } from "../text/text.js";

/** What the student wants to practise; empty means any. */
export interface Wish {
  readonly family: string;
  readonly question: string;
  readonly difficulty: number | null;
  readonly variation: string;
  /** The seed of a set that an instructor gave out: all who have it practise the same problems in the same order. */
  readonly set: string;
  /** How many problems a set has at most. */
  readonly count: number;
}

/** The steps of exercises/common/variation.py. */
export const STEPS = ["chapter", "lengths", "zeros", "frames", "full"] as const;

export const ANYTHING: Wish = { family: "", question: "", difficulty: null, variation: "", set: "", count: 10 };

/** A question about an arm of the bank. */
export type Item = { readonly family: string; readonly key: string; readonly question: string };

/** How an item stands: whether the last attempt was right, its box, when it is due, and whether it ever went wrong. */
export interface Attempted {
  readonly right: boolean;
  readonly missed?: boolean;
  readonly box: number;
  readonly due: number;
}

/** Attempts by item's name. */
export type Progress = Readonly<Record<string, Attempted>>;

const DAY = 24 * 3600 * 1000;
/** How long until an item of a box comes again. */
export const WAITS: readonly number[] = [2 * 60 * 1000, DAY, 3 * DAY, 7 * DAY, 30 * DAY];

export const nameOf = ({ family, key, question }: Item): string => `${family}/${key}/${question}`;

/** How far arms of the bank vary: the steps in their order, then what an instructor named. */
export function variations(index: Index): string[] {
  const found = new Set(index.families.flatMap(({ problems }) => problems.map((problem) => problem.variation)));
  return [...STEPS.filter((step) => found.delete(step)), ...found];
}

/** Every item that a wish allows, in the bank's order. */
export function items(index: Index, wish: Wish): Item[] {
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

/** What the bank says of the problem of an item. */
export function problemsIn(index: Index): (item: Item) => Listed {
  const listed = new Map(
    index.families.flatMap(({ name, problems }) =>
      problems.map((problem): [string, Listed] => [`${name}/${problem.key}`, problem]),
    ),
  );
  return ({ family, key }) => listed.get(`${family}/${key}`)!;
}

/** How many steps the arm of a problem is from the chapter's. */
export const stepOf = ({ variation }: Listed): number => Math.max(0, (STEPS as readonly string[]).indexOf(variation));

/** The item to ask next: one that went wrong and is due, else a new one by the luck of `random`; null without any. */
export function next(
  index: Index,
  wish: Wish,
  progress: Progress,
  now: number,
  random: () => number,
  last = "",
): Item | null {
  const all = items(index, wish);
  const others = all.filter((item) => nameOf(item) !== last);
  const due = others.filter((item) => (progress[nameOf(item)]?.due ?? Infinity) <= now);
  const wrong = due.filter((item) => isMissed(progress[nameOf(item)]));
  const fresh = others.filter((item) => !progress[nameOf(item)]);
  const easy = Object.keys(progress).length < BEGINNING ? easiest(index, fresh) : [];
  const pool = [wrong, easy, fresh, due, others, all].find((each) => each.length > 0);
  return pool?.[Math.floor(random() * pool.length)] ?? null;
}

/** So many questions of a beginner are easy ones. */
const BEGINNING = 3;
/** What can be seen on the arm, or worked out of a picture with two lengths and two angles. */
const PLAIN = ["joint-effect", "position", "speed", "velocity-component", "jacobian-size"];

/** Of some items those about the easiest arms of the first family that has them, plain questions if there are any. */
function easiest(index: Index, some: readonly Item[]): Item[] {
  const problemOf = problemsIn(index);
  const of = (item: Item): number => 5 * stepOf(problemOf(item)) + Math.max(1, problemOf(item).difficulty);
  const least = Math.min(...some.map(of));
  const easy = some.filter((item) => of(item) === least);
  const first = easy.filter(({ family }) => family === easy[0]!.family);
  const plain = first.filter(({ question }) => PLAIN.includes(question));
  return plain.length > 0 ? plain : first;
}

/** What went wrong before and is due again, of what the bank has, the longest due first. */
export function dueItems(index: Index, progress: Progress, now: number): Item[] {
  const due = (item: Item): number => progress[nameOf(item)]?.due ?? Infinity;
  return items(index, ANYTHING)
    .filter((item) => isMissed(progress[nameOf(item)]) && due(item) <= now)
    .sort((a, b) => due(a) - due(b));
}

/** Where to go on in a set: at its first item that was not tried yet, or at its beginning. */
export function placeIn(order: readonly Item[], progress: Progress): number {
  return Math.max(
    0,
    order.findIndex((item) => !progress[nameOf(item)]),
  );
}

/** The items of a set in its order. */
export function inOrder(index: Index, wish: Wish): Item[] {
  return shuffled(items(index, wish), wish.set).slice(0, wish.count);
}

/** Items in the order that a seed decides. */
export function shuffled(items: readonly Item[], seed: string): Item[] {
  const random = numbers(seed);
  const all = [...items];
  for (let i = all.length - 1; i > 0; i -= 1) {
    const j = Math.floor(random() * (i + 1));
    [all[i], all[j]] = [all[j] as Item, all[i] as Item];
  }
  return all;
}

/** Progress after an attempt: a right one goes a box up, a wrong one back to the first. */
export function attempted(progress: Progress, item: Item, right: boolean, now: number): Progress {
  const before = progress[nameOf(item)];
  const box = right ? Math.min((before?.box ?? 0) + 1, WAITS.length - 1) : 0;
  const missed = isMissed(before) || !right ? { missed: true } : {};
  return { ...progress, [nameOf(item)]: { right, ...missed, box, due: now + (WAITS[box] as number) } };
}

/** Whether an item went wrong once, and has to come again. */
export const isMissed = (attempt: Attempted | undefined): boolean =>
  attempt !== undefined && (!attempt.right || attempt.missed === true);

/** Random numbers from 0 to 1 that a text decides. */
export const numbers = (seed: string): (() => number) =>
  randomNumbers([...seed].reduce((hash, sign) => Math.imul(hash ^ (sign.codePointAt(0) ?? 0), 0x01000193), 0x811c9dc5));

/** A wish as the end of an address, to be handed on; and back. */
export function asLink(wish: Wish): string {
  const found = new URLSearchParams();
  if (wish.family) found.set("arm", wish.family);
  if (wish.question) found.set("question", wish.question);
  if (wish.difficulty !== null) found.set("difficulty", String(wish.difficulty));
  if (wish.variation) found.set("variation", wish.variation);
  if (wish.set) found.set("set", wish.set);
  if (wish.set && wish.count !== ANYTHING.count) found.set("n", String(wish.count));
  return found.size > 0 ? `?${found}` : "";
}

export function fromLink(search: string): Wish {
  const found = new URLSearchParams(search);
  const difficulty = found.get("difficulty");
  const step = difficulty === null ? NaN : Number(difficulty);
  const count = Number(found.get("n") ?? NaN);
  return {
    family: found.get("arm") ?? "",
    question: found.get("question") ?? "",
    difficulty: Number.isInteger(step) && step >= 0 && step <= 4 ? step : null,
    variation: found.get("variation") ?? "",
    set: found.get("set") ?? "",
    count: Number.isInteger(count) && count > 0 ? count : ANYTHING.count,
  };
}

/** What is wrong with a wish that allows no problem, or with a link that names what is not here; else null. */
export function faultOf(index: Index, wish: Wish, search: string): Message | null {
  const arm = index.families.find(({ name }) => name === wish.family);
  const question = index.questions.find(({ name }) => name === wish.question);
  const difficulty = new URLSearchParams(search).get("difficulty");
  const known = variations(index);
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
  if (items(index, wish).length > 0) return null;
  if (arm && question && items(index, { ...ANYTHING, family: arm.name, question: question.name }).length === 0)
    return message("practice.never-asked", { question: question.title, arm: arm.title });
  return message("practice.none");
}
