// Choose the next question. One answered wrongly returns after two minutes, then after a day, three days and a week
// (Leitner's boxes).

import type { Index, ProblemEntry } from "../bank.js";
import { makeRandomNumbers } from "../random.js";
import { message, type Message } from "../text/text.js";

/** What the student wants to practise; "" or null means anything. */
export interface Wish {
  readonly family: string;
  readonly question: string;
  /** From 0 to 4. */
  readonly difficulty: number | null;
  /** As in `ProblemEntry.variation`. */
  readonly variation: string;
  /** The seed of a set of problems: everyone with this seed practises the same problems in the same order. */
  readonly set: string;
  /** Maximum number of problems in a set. */
  readonly count: number;
}

/** The steps of exercises/common/variation.py. */
export const VARIATION_STEPS = ["chapter", "lengths", "zeros", "frames", "full"] as const;

export const ANY_WISH: Wish = { family: "", question: "", difficulty: null, variation: "", set: "", count: 10 };

/** A question about an arm of the bank. */
export type Item = { readonly family: string; readonly key: string; readonly question: string };

/** The state of an item, as it is stored. */
export interface ItemState {
  /** Whether the last answer was right. */
  readonly right: boolean;
  /** Whether an answer was ever wrong. */
  readonly missed?: boolean;
  /** An index in `BOX_DELAYS`. */
  readonly box: number;
  /** When the item is to be answered again (ms since 1970). */
  readonly due: number;
}

/** The states of answered items, by the names that `nameItem` returns. */
export type Progress = Readonly<Record<string, ItemState>>;

/** In milliseconds. */
export const DAY = 24 * 3600 * 1000;
/** For each box, the time until its items are due (ms). */
export const BOX_DELAYS: readonly number[] = [2 * 60 * 1000, DAY, 3 * DAY, 7 * DAY, 30 * DAY];

export const nameItem = ({ family, key, question }: Item): string => `${family}/${key}/${question}`;

/** Return whether an item is in the index. */
export const isInIndex = (index: Index, { family, key, question }: Item): boolean =>
  index.families.some(({ name, problems }) =>
    problems.some((problem) => name === family && problem.key === key && problem.questions.includes(question)),
  );

/** Return the variations of the bank's arms: the standard steps in their order, then an instructor's own. */
export function listVariations(index: Index): string[] {
  const names = new Set(index.families.flatMap(({ problems }) => problems.map((problem) => problem.variation)));
  return [...VARIATION_STEPS.filter((step) => names.delete(step)), ...names];
}

/** Return every item that a wish allows, in the bank's order. */
export function listItems(index: Index, wish: Wish): Item[] {
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
export function makeProblemFinder(index: Index): (item: Item) => ProblemEntry {
  const entryByName = new Map(
    index.families.flatMap(({ name, problems }) =>
      problems.map((problem): [string, ProblemEntry] => [`${name}/${problem.key}`, problem]),
    ),
  );
  return ({ family, key }) => entryByName.get(`${family}/${key}`)!;
}

/** Return by how many steps the arm of a problem varies from the chapter's; 0 for properties that are no step. */
export const findVariationStep = ({ variation }: ProblemEntry): number =>
  Math.max(0, (VARIATION_STEPS as readonly string[]).indexOf(variation));

/**
 * Choose the next item: one answered wrongly that is due, else a new one (an easy one for beginners), else any. If
 * possible, it is not the one named `lastName`. Return null if no item fits the wish.
 */
export function chooseNext(
  index: Index,
  wish: Wish,
  progress: Progress,
  now: number,
  random: () => number,
  lastName = "",
): Item | null {
  const allItems = listItems(index, wish);
  const otherItems = allItems.filter((item) => nameItem(item) !== lastName);
  const dueAgain = otherItems.filter((item) => (progress[nameItem(item)]?.due ?? Infinity) <= now);
  const dueMissed = dueAgain.filter((item) => needsRepetition(progress[nameItem(item)]));
  const newItems = otherItems.filter((item) => !progress[nameItem(item)]);
  const easyItems = Object.keys(progress).length < EASY_COUNT ? selectEasiest(index, newItems) : [];
  const pool = [dueMissed, easyItems, newItems, dueAgain, otherItems, allItems].find(
    (candidates) => candidates.length > 0,
  );
  return pool?.[Math.floor(random() * pool.length)] ?? null;
}

/** A student with fewer answered questions is a beginner. */
const EASY_COUNT = 3;
/** Questions answered by looking at the arm, or from a picture with two lengths and two angles. */
const PLAIN_QUESTIONS = ["joint-effect", "position", "speed", "velocity-component", "jacobian-size"];

/** Return the items about the easiest arms, of one family only; those with plain questions if there are any. */
function selectEasiest(index: Index, items: readonly Item[]): Item[] {
  const findProblem = makeProblemFinder(index);
  /** The step of variation counts most; 5 is more than the largest difficulty. */
  const rateHardness = (item: Item): number =>
    5 * findVariationStep(findProblem(item)) + Math.max(1, findProblem(item).difficulty);
  const minHardness = Math.min(...items.map(rateHardness));
  const easiest = items.filter((item) => rateHardness(item) === minHardness);
  const inFirstFamily = easiest.filter(({ family }) => family === easiest[0]!.family);
  const plainItems = inFirstFamily.filter(({ question }) => PLAIN_QUESTIONS.includes(question));
  return plainItems.length > 0 ? plainItems : inFirstFamily;
}

/** Return the items that were answered wrongly and are due again, longest due first. */
export function listDueItems(index: Index, progress: Progress, now: number): Item[] {
  const dueTime = (item: Item): number => progress[nameItem(item)]?.due ?? Infinity;
  return listItems(index, ANY_WISH)
    .filter((item) => needsRepetition(progress[nameItem(item)]) && dueTime(item) <= now)
    .sort((a, b) => dueTime(a) - dueTime(b));
}

/** Return the index of the first new item in a set; 0 if there is none. */
export function findFirstNew(orderedItems: readonly Item[], progress: Progress): number {
  return Math.max(
    0,
    orderedItems.findIndex((item) => !progress[nameItem(item)]),
  );
}

/** Return the items of a set in its order. */
export function listSetItems(index: Index, wish: Wish): Item[] {
  return shuffle(listItems(index, wish), wish.set).slice(0, wish.count);
}

/** Return items in an order that a seed determines. */
export function shuffle(items: readonly Item[], seed: string): Item[] {
  const random = makeRandomGenerator(seed);
  const shuffled = [...items];
  for (let i = shuffled.length - 1; i > 0; i -= 1) {
    const j = Math.floor(random() * (i + 1));
    [shuffled[i], shuffled[j]] = [shuffled[j] as Item, shuffled[i] as Item];
  }
  return shuffled;
}

/** Return the progress after an answer at the time `now`: a right item moves one box up, a wrong one to the first. */
export function updateProgress(progress: Progress, item: Item, isRight: boolean, now: number): Progress {
  const earlier = progress[nameItem(item)];
  const box = isRight ? Math.min((earlier?.box ?? 0) + 1, BOX_DELAYS.length - 1) : 0;
  const missed = needsRepetition(earlier) || !isRight ? { missed: true } : {};
  return { ...progress, [nameItem(item)]: { right: isRight, ...missed, box, due: now + (BOX_DELAYS[box] as number) } };
}

/** Return whether an item has to be repeated, because it was ever answered wrongly. */
export const needsRepetition = (attempt: ItemState | undefined): boolean =>
  attempt !== undefined && (!attempt.right || attempt.missed === true);

/** Return a generator of random numbers from 0 to 1, seeded by a text. */
export const makeRandomGenerator = (seed: string): (() => number) =>
  makeRandomNumbers(
    [...seed].reduce((hash, sign) => Math.imul(hash ^ (sign.codePointAt(0) ?? 0), 0x01000193), 0x811c9dc5),
  );

/** Write a wish as the end of an address. */
export function writeWish({ family, question, difficulty, variation, set, count }: Wish): string {
  const parameters = Object.entries({
    ...{ arm: family, question, difficulty: String(difficulty ?? ""), variation, set },
    n: set && count !== ANY_WISH.count ? String(count) : "",
  }).filter(([, value]) => value);
  return parameters.length > 0 ? `?${new URLSearchParams(parameters)}` : "";
}

/** Parse a wish from the end of an address; invalid values are ignored. */
export function parseWish(search: string): Wish {
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
    count: Number.isInteger(count) && count > 0 ? count : ANY_WISH.count,
  };
}

/**
 * Return what is wrong with a wish: it names something unknown, or no item fits it; null if it is fine. The end of the
 * address (`search`) shows whether its difficulty was ignored as invalid.
 */
export function findFault(index: Index, wish: Wish, search: string): Message | null {
  const family = index.families.find(({ name }) => name === wish.family);
  const question = index.questions.find(({ name }) => name === wish.question);
  const difficulty = new URLSearchParams(search).get("difficulty");
  const known = listVariations(index);
  if (wish.family && !family)
    return message("practice.unknown-arm", {
      name: wish.family,
      known: index.families.map(({ name }) => name).join(", "),
    });
  if (wish.question && !question) return message("practice.unknown-question", { name: wish.question });
  if (wish.variation && !known.includes(wish.variation))
    return message("practice.unknown-variation", { name: wish.variation, known: known.join(", ") });
  if (difficulty !== null && wish.difficulty === null)
    return message("practice.unknown-difficulty", { name: difficulty });
  if (listItems(index, wish).length > 0) return null;
  if (
    family &&
    question &&
    listItems(index, { ...ANY_WISH, family: family.name, question: question.name }).length === 0
  )
    return message("practice.never-asked", { question: question.title, arm: family.title });
  return message("practice.none");
}
