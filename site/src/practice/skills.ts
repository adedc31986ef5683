// Progress in the lessons, per class of arms: learned after three right answers in a row without help, each for another
// arm; mastered after one more a day later.

import type { Index } from "../bank.js";
import { keepText, keptJson } from "../storage.js";
import { ANYTHING, type Item, items, nameOf, problemsIn, stepOf } from "./choice.js";
import { message, type Message } from "../text/text.js";

export const NEEDED = 3;
const DAY = 24 * 3600 * 1000;
const KEY = "qdot-lessons";

/** What is known of a lesson for a class of arms: the arms of the row, and when it was learned and mastered. */
export type Row = { readonly row: readonly string[]; readonly learned?: number; readonly mastered?: number };

/** What is known of a lesson: goals reached, the row for the first class of arms, and those for the classes beyond. */
export type Skill = Row & { readonly goals: readonly number[]; readonly beyond?: Readonly<Record<string, Row>> };

export type Skills = Readonly<Record<string, Skill>>;

export const NEW_ROW: Row = { row: [] };
export const NEW: Skill = { ...NEW_ROW, goals: [] };

/** The arm of an item; that of a set of short questions is the one whose number it has. */
const armOf = ({ family, key }: Item): string => `${family}/${key.replace(/-quiz$/, "")}`;

/** How a question was answered: `helped` by hints or the solution, `again` after another answer to it. */
export type Answered = { readonly right: boolean; readonly helped: boolean; readonly again: boolean };

/** The row after an answer; `most` is how many arms there are, where there are fewer than are needed. */
export function answered<R extends Row>(skill: R, item: Item, how: Answered & { now: number; most: number }): R {
  const { right, helped, again, now, most } = how;
  if (again) return skill;
  if (!right) return { ...skill, row: [] };
  if (helped) return skill;
  const row = skill.row.includes(armOf(item)) ? skill.row : [...skill.row, armOf(item)];
  if (skill.learned !== undefined)
    return now - skill.learned >= DAY && skill.mastered === undefined ? { ...skill, mastered: now } : skill;
  return row.length >= Math.min(NEEDED, most) ? { ...skill, row, learned: now } : { ...skill, row };
}

/** What comes of an answer, in words, of `most` arms; null if the lesson is learned, and no day has gone by. */
export function outcomeOf(before: Row, after: Row, how: Answered & { most: number }): Message | null {
  const { right, helped, again, most } = how;
  if (before.mastered !== undefined) return null;
  if (after.mastered !== undefined) return message("lesson.mastered");
  if (before.learned !== undefined && !right) return null;
  if (right && helped) return message("lesson.counts-not-helped");
  if (right && again) return message("lesson.counts-not-again");
  if (before.learned !== undefined) return null;
  if (after.learned !== undefined) return message("lesson.learned");
  if (!right && !again && before.row.length > 0) return message("lesson.row-broken");
  const needed = Math.min(NEEDED, most);
  return right ? message("lesson.state-row", { count: after.row.length, needed }) : null;
}

/** Whether what was learned is to be looked at again: a day has gone by, and it is not mastered yet. */
export function isDue(skill: Row | undefined, now: number): boolean {
  return skill?.learned !== undefined && skill.mastered === undefined && now - skill.learned >= DAY;
}

/** The questions of a lesson about its arms, the easiest first: chapter arms before rotated and offset ones. */
export function itemsOf(index: Index, questions: readonly string[], families: readonly string[]): Item[] {
  const problemOf = problemsIn(index);
  const asked = items(index, ANYTHING).filter(({ question }) => questions.includes(question));
  const own = asked.filter(({ family }) => families.includes(family));
  return (own.length > 0 ? own : asked)
    .map((item) => {
      const place = own.length > 0 ? families.indexOf(item.family) : 0;
      const hardness = 2 * stepOf(problemOf(item)) + place + questions.indexOf(item.question);
      return { item, place, hardness };
    })
    .sort((a, b) => a.hardness - b.hardness || a.place - b.place)
    .map(({ item }) => item);
}

/** The shares of the ordered items between which the next is drawn, by how many of the row are right. */
const CLIMB = [
  [0, 0],
  [0, 0.25],
  [0.15, 0.5],
] as const;
const FEW = 3;

/** The next item, harder as the row grows: if possible about an arm that is new in the row, and not yet `asked`. */
export function nextIn(all: readonly Item[], skill: Row, asked: readonly string[], random: () => number): Item | null {
  const fresh = all.filter((item) => !skill.row.includes(armOf(item)));
  const about = fresh.length > 0 ? fresh : all;
  const unasked = about.filter((item) => !asked.includes(nameOf(item)));
  const others = unasked.length > 0 ? unasked : about.filter((item) => nameOf(item) !== asked.at(-1));
  const pool = others.length > 0 ? others : all;
  const [from, to] = CLIMB[Math.min(skill.learned === undefined ? skill.row.length : 2, 2)]!;
  const start = Math.min(Math.floor(from * pool.length), pool.length - 1);
  const some = pool.slice(start, Math.max(start + FEW, Math.ceil(to * pool.length)));
  return some[Math.floor(random() * some.length)] ?? null;
}

/** How many arms a lesson's items are about. */
export const armsIn = (all: readonly Item[]): number => new Set(all.map(armOf)).size;

export const keptSkills = (storage: Storage | null): Skills => keptJson(storage, KEY, checkedSkills);

export const keepSkills = (storage: Storage | null, skills: Skills): void =>
  keepText(storage, KEY, JSON.stringify(skills));

/** What of it are skills. */
export function checkedSkills(content: unknown): Skills {
  return Object.fromEntries(Object.entries(content ?? {}).filter(([, skill]) => isSkill(skill)));
}

/** Both together: all goals that were reached, and of each row the one that is further. */
export function mergedSkills(mine: Skills, other: Skills): Skills {
  const found: Record<string, Skill> = { ...mine };
  for (const [name, skill] of Object.entries(other)) {
    const own = found[name];
    found[name] = own ? mergedSkill(own, skill) : skill;
  }
  return found;
}

function mergedSkill(own: Skill, other: Skill): Skill {
  const goals = [...new Set([...own.goals, ...other.goals])];
  const classes = new Set([...Object.keys(own.beyond ?? {}), ...Object.keys(other.beyond ?? {})]);
  const beyond = Object.fromEntries(
    [...classes].map((name) => [name, further(own.beyond?.[name] ?? NEW_ROW, other.beyond?.[name] ?? NEW_ROW)]),
  );
  return { ...further(own, other), goals, ...(classes.size > 0 ? { beyond } : {}) };
}

/** Of two rows the one that is mastered, else learned, else longer, the first where both are alike. */
function further(own: Row, other: Row): Row {
  const lengthOf = ({ row, learned, mastered }: Row): number =>
    (mastered !== undefined ? 2000 : learned !== undefined ? 1000 : 0) + row.length;
  return lengthOf(other) > lengthOf(own) ? other : own;
}

function isSkill(skill: unknown): skill is Skill {
  if (!isRow(skill)) return false;
  const { goals, beyond = {} } = skill as Partial<Record<keyof Skill, unknown>>;
  return (
    Array.isArray(goals) &&
    goals.every(Number.isInteger) &&
    typeof beyond === "object" &&
    Object.values(beyond ?? {}).every(isRow)
  );
}

function isRow(found: unknown): found is Row {
  if (typeof found !== "object" || found === null) return false;
  const { row, learned, mastered } = found as Partial<Record<keyof Row, unknown>>;
  const time = (value: unknown): boolean => value === undefined || Number.isFinite(value);
  return Array.isArray(row) && row.every((each) => typeof each === "string") && time(learned) && time(mastered);
}
