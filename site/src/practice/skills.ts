// Progress in the lessons, for each class of arms: learned after three right answers in a row without help, each about
// another arm; mastered after one more a day later.

import type { Index } from "../bank.js";
import { ANY_WISH, DAY, type Item, listItems, nameItem, makeProblemFinder, findVariationStep } from "./choice.js";
import { message, type Message } from "../text/text.js";

/** The number of arms with right answers in a row that make a class learned, if the class has so many. */
const NEEDED_ARMS = 3;

/**
 * Progress in a class of arms, as it is stored: `row` has the arms ("FAMILY/KEY") answered rightly in a row; `learned`
 * and `mastered` are the times at which the class was learned and mastered (ms since 1970).
 */
export type Streak = { readonly row: readonly string[]; readonly learned?: number; readonly mastered?: number };

/**
 * Progress in a lesson, as it is stored: the streak in its first class of arms, the indices of the goals reached, the
 * index of the option that was predicted, and the streaks in the other classes, by their names (`beyond`).
 */
export type Skill = Streak & {
  readonly goals: readonly number[];
  readonly predicted?: number;
  readonly beyond?: Readonly<Record<string, Streak>>;
};

/** Progress in all lessons, by their ids. */
export type Skills = Readonly<Record<string, Skill>>;

export const NO_STREAK: Streak = { row: [] };
export const NEW_SKILL: Skill = { ...NO_STREAK, goals: [] };

/** Return the name of an item's arm. FAMILY/KEY-quiz has short questions about the arm in FAMILY/KEY. */
const nameArm = ({ family, key }: Item): string => `${family}/${key.replace(/-quiz$/, "")}`;

/** How a question was answered. `isHelped`: after hints or the solution; `isRepeated`: after an earlier answer. */
export type Attempt = { readonly isRight: boolean; readonly isHelped: boolean; readonly isRepeated: boolean };

/** Return the streak after an answer at the time `now` (ms); `armCount` is the number of the class's arms. */
export function updateStreak<R extends Streak>(
  streak: R,
  item: Item,
  attempt: Attempt & { now: number; armCount: number },
): R {
  const { isRight, isHelped, isRepeated, now, armCount } = attempt;
  if (isRepeated) return streak;
  if (!isRight) return { ...streak, row: [] };
  if (isHelped) return streak;
  const row = streak.row.includes(nameArm(item)) ? streak.row : [...streak.row, nameArm(item)];
  if (streak.learned !== undefined)
    return now - streak.learned >= DAY && streak.mastered === undefined ? { ...streak, mastered: now } : streak;
  return row.length >= Math.min(NEEDED_ARMS, armCount) ? { ...streak, row, learned: now } : { ...streak, row };
}

/** Return the effect of an answer on a class as a message; null if the answer changes nothing worth telling. */
export function describeOutcome(
  before: Streak,
  after: Streak,
  attempt: Attempt & { armCount: number },
): Message | null {
  const { isRight, isHelped, isRepeated, armCount } = attempt;
  if (before.mastered !== undefined) return null;
  if (after.mastered !== undefined) return message("lesson.mastered");
  if (before.learned !== undefined && !isRight) return null;
  const needed = Math.min(NEEDED_ARMS, armCount);
  if (isRight && isHelped) return message("lesson.counts-not-helped", { needed });
  if (isRight && isRepeated) return message("lesson.counts-not-again", { needed });
  if (before.learned !== undefined) return null;
  if (after.learned !== undefined) return message("lesson.learned");
  if (!isRight && !isRepeated && before.row.length > 0) return message("lesson.row-broken");
  return isRight ? message("lesson.state-row", { count: after.row.length, needed }) : null;
}

/** Return whether a learned class is due for review: after a day, until it is mastered. */
export function isDue(streak: Streak | undefined, now: number): boolean {
  return streak?.learned !== undefined && streak.mastered === undefined && now - streak.learned >= DAY;
}

/**
 * Return the items with some questions, easiest first: arms of the chapter before arms that vary. The items are about
 * the given families, or about all families if the bank has none of these.
 */
export function listLessonItems(index: Index, questions: readonly string[], families: readonly string[]): Item[] {
  const findProblem = makeProblemFinder(index);
  const allItems = listItems(index, ANY_WISH).filter(({ question }) => questions.includes(question));
  const familyItems = allItems.filter(({ family }) => families.includes(family));
  return (familyItems.length > 0 ? familyItems : allItems)
    .map((item) => {
      const familyIndex = familyItems.length > 0 ? families.indexOf(item.family) : 0;
      const difficulty = 2 * findVariationStep(findProblem(item)) + familyIndex + questions.indexOf(item.question);
      return { item, familyIndex, difficulty };
    })
    .sort((a, b) => a.difficulty - b.difficulty || a.familyIndex - b.familyIndex)
    .map(({ item }) => item);
}

/** Return an item for each of the questions, in their order, all about the easiest arm that has the most of them. */
export function listGuidedItems(items: readonly Item[], questions: readonly string[]): Item[] {
  let best: Item[] = [];
  for (const arm of new Set(items.map(nameArm))) {
    const steps = questions.flatMap((name) =>
      items.filter((item) => item.question === name && nameArm(item) === arm).slice(0, 1),
    );
    if (steps.length > best.length) best = steps;
  }
  return best;
}

/** For each number of right answers in a row, the shares of the ordered items between which the next item is. */
const DIFFICULTY_RANGES = [
  [0, 0],
  [0, 0.25],
  [0.15, 0.5],
] as const;
/** The minimum number of items among which one is chosen at random. */
const MIN_CANDIDATES = 3;

/** Choose a class's next item, harder as the streak grows; if possible about a new arm, and not asked before. */
export function chooseItem(
  items: readonly Item[],
  streak: Streak,
  askedNames: readonly string[],
  random: () => number,
): Item | null {
  const withNewArms = items.filter((item) => !streak.row.includes(nameArm(item)));
  const preferred = withNewArms.length > 0 ? withNewArms : items;
  const unasked = preferred.filter((item) => !askedNames.includes(nameItem(item)));
  const notLast = unasked.length > 0 ? unasked : preferred.filter((item) => nameItem(item) !== askedNames.at(-1));
  const pool = notLast.length > 0 ? notLast : items;
  const [startShare, endShare] = DIFFICULTY_RANGES[Math.min(streak.learned === undefined ? streak.row.length : 2, 2)]!;
  const start = Math.min(Math.floor(startShare * pool.length), pool.length - 1);
  const candidates = pool.slice(start, Math.max(start + MIN_CANDIDATES, Math.ceil(endShare * pool.length)));
  return candidates[Math.floor(random() * candidates.length)] ?? null;
}

/** Return the number of different arms in items. */
export const countArms = (items: readonly Item[]): number => new Set(items.map(nameArm)).size;

/** Return the number of arms with right answers in a row that make a class with these items learned. */
export const countNeededArms = (items: readonly Item[]): number => Math.min(NEEDED_ARMS, countArms(items));

/** Return the valid entries of stored skills. */
export function checkSkills(content: unknown): Skills {
  return Object.fromEntries(Object.entries(content ?? {}).filter(([, skill]) => isSkill(skill)));
}

/** Merge the skills of a lesson: all goals reached, and of each class the better streak. */
export function mergeSkill(mine: Skill, other: Skill): Skill {
  const goals = [...new Set([...mine.goals, ...other.goals])];
  const streakOf = ({ beyond }: Skill, name: string): Streak => beyond?.[name] ?? NO_STREAK;
  const classes = Object.keys({ ...mine.beyond, ...other.beyond });
  const streaks = classes.map((name) => [name, betterStreak(streakOf(mine, name), streakOf(other, name))]);
  const beyond = classes.length > 0 ? { beyond: Object.fromEntries(streaks) } : {};
  const predicted = mine.predicted ?? other.predicted;
  return { ...betterStreak(mine, other), goals, ...(predicted === undefined ? {} : { predicted }), ...beyond };
}

/** Return the streak that is mastered, else learned, else longer; the first one if both are equal. */
function betterStreak(mine: Streak, other: Streak): Streak {
  const rateStreak = ({ row, learned, mastered }: Streak): number =>
    (mastered !== undefined ? 2000 : learned !== undefined ? 1000 : 0) + row.length;
  return rateStreak(other) > rateStreak(mine) ? other : mine;
}

function isSkill(content: unknown): content is Skill {
  if (!isStreak(content)) return false;
  const { goals, predicted = 0, beyond = {} } = content as Partial<Record<keyof Skill, unknown>>;
  return (
    Number.isInteger(predicted) &&
    Array.isArray(goals) &&
    goals.every(Number.isInteger) &&
    typeof beyond === "object" &&
    Object.values(beyond ?? {}).every(isStreak)
  );
}

function isStreak(content: unknown): content is Streak {
  if (typeof content !== "object" || content === null) return false;
  const { row, learned, mastered } = content as Partial<Record<keyof Streak, unknown>>;
  const isTime = (value: unknown): boolean => value === undefined || Number.isFinite(value);
  return Array.isArray(row) && row.every((arm) => typeof arm === "string") && isTime(learned) && isTime(mastered);
}
