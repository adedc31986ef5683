// How far one is in the lessons: right answers in a row without help, each to another arm; learned at three of them, and
// mastered with one more after a day. Kept in this browser.

import type { Index } from "../bank.js";
import { type Item, items, ANYTHING, nameOf, STEPS } from "../practice/choice.js";

export const NEEDED = 3;
const DAY = 24 * 3600 * 1000;
const KEY = "qdot-lessons";

/** What is known of a lesson: the arms of the row, when it was learned and mastered, and which of its goals were reached. */
export interface Skill {
  readonly row: readonly string[];
  readonly learned?: number;
  readonly mastered?: number;
  readonly goals: readonly number[];
}

export type Skills = Readonly<Record<string, Skill>>;

export const NEW: Skill = { row: [], goals: [] };

const armOf = ({ family, key }: Item): string => `${family}/${key}`;

/** The skill after an answer; `most` is how many arms there are, where there are fewer than are needed. */
export function answered(
  skill: Skill,
  item: Item,
  { right, helped, now, most }: { right: boolean; helped: boolean; now: number; most: number },
): Skill {
  if (!right) return { ...skill, row: [] };
  if (helped) return skill;
  const row = skill.row.includes(armOf(item)) ? skill.row : [...skill.row, armOf(item)];
  if (skill.learned !== undefined)
    return now - skill.learned >= DAY && skill.mastered === undefined ? { ...skill, mastered: now } : skill;
  return row.length >= Math.min(NEEDED, most) ? { ...skill, row, learned: now } : { ...skill, row };
}

/** Whether a lesson that was learned is to be looked at again: a day has gone by, and it is not mastered yet. */
export function isDue(skill: Skill | undefined, now: number): boolean {
  return skill?.learned !== undefined && skill.mastered === undefined && now - skill.learned >= DAY;
}

/** The items of a lesson: its questions about its arms, those first that are next to the chapter's. */
export function itemsOf(index: Index, questions: readonly string[], families: readonly string[]): Item[] {
  const steps: readonly string[] = STEPS;
  const ranked = items(index, ANYTHING)
    .filter(({ question }) => questions.includes(question))
    .map((item) => {
      const family = families.indexOf(item.family);
      const listed = index.families
        .find(({ name }) => name === item.family)
        ?.problems.find(({ key }) => key === item.key);
      return {
        item,
        family: family < 0 ? families.length : family,
        step: steps.indexOf(listed?.variation ?? ""),
        question: questions.indexOf(item.question),
      };
    });
  const own = ranked.filter(({ family }) => family < families.length);
  return (own.length > 0 ? own : ranked)
    .sort((a, b) => a.family - b.family || a.step - b.step || a.question - b.question)
    .map(({ item }) => item);
}

/** The next item: from the plainest arms to the others as the row grows, an arm that is not in it if there is one. */
export function nextIn(all: readonly Item[], skill: Skill, last: string, random: () => number): Item | null {
  const fresh = all.filter((item) => !skill.row.includes(armOf(item)));
  const others = (fresh.length > 0 ? fresh : all).filter((item) => nameOf(item) !== last);
  const pool = others.length > 0 ? others : all;
  const part = Math.ceil(pool.length / NEEDED);
  const start = Math.min(skill.learned === undefined ? skill.row.length : NEEDED - 1, NEEDED - 1) * part;
  const some = pool.slice(start, start + part);
  const chosen = some.length > 0 ? some : pool;
  return chosen[Math.floor(random() * chosen.length)] ?? null;
}

/** How many arms a lesson's items are about. */
export const armsIn = (all: readonly Item[]): number => new Set(all.map(armOf)).size;

export function keptSkills(storage: Storage | null): Skills {
  try {
    const found: unknown = JSON.parse(storage?.getItem(KEY) ?? "{}");
    return Object.fromEntries(Object.entries(found ?? {}).filter(([, skill]) => isSkill(skill)));
  } catch {
    return {};
  }
}

export function keepSkills(storage: Storage | null, skills: Skills): void {
  try {
    storage?.setItem(KEY, JSON.stringify(skills));
  } catch {
    // A browser that keeps nothing: one goes on all the same.
  }
}

function isSkill(skill: unknown): skill is Skill {
  if (typeof skill !== "object" || skill === null) return false;
  const { row, goals, learned, mastered } = skill as Partial<Record<keyof Skill, unknown>>;
  const time = (value: unknown): boolean => value === undefined || Number.isFinite(value);
  return (
    Array.isArray(row) &&
    row.every((each) => typeof each === "string") &&
    Array.isArray(goals) &&
    goals.every(Number.isInteger) &&
    time(learned) &&
    time(mastered)
  );
}
