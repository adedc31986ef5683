// Progress in the lessons, for each class of arms: learned after three right answers in a row without help, each about
// another arm; mastered after one more a day later.

import type { Index } from "../bank.js";
import { ANYTHING, type Item, itemsFor, nameOf, problemsIn, stepOf } from "./choice.js";
import { message, type Message } from "../text/text.js";

export const NEEDED = 3;
const DAY = 24 * 3600 * 1000;

/** Progress in a class of arms: the arms answered rightly in a row, and when the class was learned and mastered. */
export type Streak = { readonly row: readonly string[]; readonly learned?: number; readonly mastered?: number };

/** Progress in a lesson: goals reached, the streak in the first class of arms, and those in the other classes. */
export type Skill = Streak & { readonly goals: readonly number[]; readonly beyond?: Readonly<Record<string, Streak>> };

export type Skills = Readonly<Record<string, Skill>>;

export const NO_STREAK: Streak = { row: [] };
export const NEW_SKILL: Skill = { ...NO_STREAK, goals: [] };

/** Return the arm of an item; a set of short questions belongs to the arm with the same number. */
const armOf = ({ family, key }: Item): string => `${family}/${key.replace(/-quiz$/, "")}`;

/** How a question was answered: `helped` by hints or the solution, `again` after another answer to it. */
export type Attempt = { readonly right: boolean; readonly helped: boolean; readonly again: boolean };

/** Return the streak after an answer; `armCount` is the number of arms, which may be smaller than needed. */
export function streakAfter<R extends Streak>(
  skill: R,
  item: Item,
  attempt: Attempt & { now: number; armCount: number },
): R {
  const { right, helped, again, now, armCount } = attempt;
  if (again) return skill;
  if (!right) return { ...skill, row: [] };
  if (helped) return skill;
  const row = skill.row.includes(armOf(item)) ? skill.row : [...skill.row, armOf(item)];
  if (skill.learned !== undefined)
    return now - skill.learned >= DAY && skill.mastered === undefined ? { ...skill, mastered: now } : skill;
  return row.length >= Math.min(NEEDED, armCount) ? { ...skill, row, learned: now } : { ...skill, row };
}

/** Return the effect of an answer as a message; null if the lesson is learned, and less than a day ago. */
export function outcomeOf(before: Streak, after: Streak, attempt: Attempt & { armCount: number }): Message | null {
  const { right, helped, again, armCount } = attempt;
  if (before.mastered !== undefined) return null;
  if (after.mastered !== undefined) return message("lesson.mastered");
  if (before.learned !== undefined && !right) return null;
  if (right && helped) return message("lesson.counts-not-helped");
  if (right && again) return message("lesson.counts-not-again");
  if (before.learned !== undefined) return null;
  if (after.learned !== undefined) return message("lesson.learned");
  if (!right && !again && before.row.length > 0) return message("lesson.row-broken");
  const needed = Math.min(NEEDED, armCount);
  return right ? message("lesson.state-row", { count: after.row.length, needed }) : null;
}

/** Return whether a learned class is due for review: after a day, until it is mastered. */
export function isDue(skill: Streak | undefined, now: number): boolean {
  return skill?.learned !== undefined && skill.mastered === undefined && now - skill.learned >= DAY;
}

/** Return a lesson's questions, easiest first: arms of the chapter before rotated and offset ones. */
export function itemsOf(index: Index, questions: readonly string[], families: readonly string[]): Item[] {
  const problemOf = problemsIn(index);
  const asked = itemsFor(index, ANYTHING).filter(({ question }) => questions.includes(question));
  const ofFamilies = asked.filter(({ family }) => families.includes(family));
  return (ofFamilies.length > 0 ? ofFamilies : asked)
    .map((item) => {
      const place = ofFamilies.length > 0 ? families.indexOf(item.family) : 0;
      const difficulty = 2 * stepOf(problemOf(item)) + place + questions.indexOf(item.question);
      return { item, place, difficulty };
    })
    .sort((a, b) => a.difficulty - b.difficulty || a.place - b.place)
    .map(({ item }) => item);
}

/** The next item is between these shares of the ordered items, by the number of right answers in the row. */
const DIFFICULTY_RANGES = [
  [0, 0],
  [0, 0.25],
  [0.15, 0.5],
] as const;
const MIN_CANDIDATES = 3;

/** Return the next item, harder as the row grows; if possible about a new arm, and not in `asked`. */
export function nextIn(
  all: readonly Item[],
  skill: Streak,
  asked: readonly string[],
  random: () => number,
): Item | null {
  const newArms = all.filter((item) => !skill.row.includes(armOf(item)));
  const preferred = newArms.length > 0 ? newArms : all;
  const unasked = preferred.filter((item) => !asked.includes(nameOf(item)));
  const others = unasked.length > 0 ? unasked : preferred.filter((item) => nameOf(item) !== asked.at(-1));
  const pool = others.length > 0 ? others : all;
  const [from, to] = DIFFICULTY_RANGES[Math.min(skill.learned === undefined ? skill.row.length : 2, 2)]!;
  const start = Math.min(Math.floor(from * pool.length), pool.length - 1);
  const candidates = pool.slice(start, Math.max(start + MIN_CANDIDATES, Math.ceil(to * pool.length)));
  return candidates[Math.floor(random() * candidates.length)] ?? null;
}

/** Return the number of arms in a lesson's items. */
export const armCountOf = (all: readonly Item[]): number => new Set(all.map(armOf)).size;

/** Return the valid entries of stored skills. */
export function checkSkills(content: unknown): Skills {
  return Object.fromEntries(Object.entries(content ?? {}).filter(([, skill]) => isSkill(skill)));
}

/** Merge two sets of skills: all goals reached, and of each class the better streak. */
export function mergeSkills(mine: Skills, other: Skills): Skills {
  const merged: Record<string, Skill> = { ...mine };
  for (const [name, skill] of Object.entries(other)) {
    const mySkill = merged[name];
    merged[name] = mySkill ? mergeSkill(mySkill, skill) : skill;
  }
  return merged;
}

function mergeSkill(mine: Skill, other: Skill): Skill {
  const goals = [...new Set([...mine.goals, ...other.goals])];
  const streakOf = ({ beyond }: Skill, name: string): Streak => beyond?.[name] ?? NO_STREAK;
  const classes = Object.keys({ ...mine.beyond, ...other.beyond });
  const streaks = classes.map((name) => [name, betterStreak(streakOf(mine, name), streakOf(other, name))]);
  const beyond = classes.length > 0 ? { beyond: Object.fromEntries(streaks) } : {};
  return { ...betterStreak(mine, other), goals, ...beyond };
}

/** Return the streak that is mastered, else learned, else longer; the first one if both are equal. */
function betterStreak(mine: Streak, other: Streak): Streak {
  const lengthOf = ({ row, learned, mastered }: Streak): number =>
    (mastered !== undefined ? 2000 : learned !== undefined ? 1000 : 0) + row.length;
  return lengthOf(other) > lengthOf(mine) ? other : mine;
}

function isSkill(skill: unknown): skill is Skill {
  if (!isStreak(skill)) return false;
  const { goals, beyond = {} } = skill as Partial<Record<keyof Skill, unknown>>;
  return (
    Array.isArray(goals) &&
    goals.every(Number.isInteger) &&
    typeof beyond === "object" &&
    Object.values(beyond ?? {}).every(isStreak)
  );
}

function isStreak(found: unknown): found is Streak {
  if (typeof found !== "object" || found === null) return false;
  const { row, learned, mastered } = found as Partial<Record<keyof Streak, unknown>>;
  const time = (value: unknown): boolean => value === undefined || Number.isFinite(value);
  return Array.isArray(row) && row.every((arm) => typeof arm === "string") && time(learned) && time(mastered);
}
