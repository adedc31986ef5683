// The graph of lessons: what each lesson builds on, and the student's progress in the lesson and in its questions.

import type { Index } from "../bank.js";
import { ANYTHING, items, nameOf, type Progress } from "../practice/choice.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { classesOf, rowOf, type ClassItems } from "../practice/classes.js";
import { isDue, NEEDED, NEW, type Row, type Skill, type Skills } from "../practice/skills.js";

export type Standing = "new" | "begun" | "learned" | "due" | "mastered";

/** A question of a lesson: on how many of the needed arms the last answer was right, and whether one was wrong. */
export interface Asked {
  readonly name: string;
  readonly title: string;
  readonly lang: string | undefined;
  readonly right: number;
  readonly needed: number;
  readonly missed: boolean;
}

export interface Place {
  readonly lesson: Lesson;
  readonly standing: Standing;
  /** Whether everything the lesson builds on is learned, but not the lesson itself. */
  readonly next: boolean;
  /** Lessons it builds on that are not learned yet. */
  readonly missing: readonly Lesson[];
  /** The classes of its arms, with the progress in each. */
  readonly classes: readonly (readonly [ClassItems, Row])[];
  readonly asked: readonly Asked[];
}

/** Return the state of a lesson, which is mastered if all classes are; `rows` are the classes after the first. */
export function standingOf(skill: Skill, now: number, rows: readonly Row[] = []): Standing {
  if ([skill, ...rows].some((row) => isDue(row, now))) return "due";
  if ([skill, ...rows].every(({ mastered }) => mastered !== undefined)) return "mastered";
  if (skill.learned !== undefined) return "learned";
  return [skill, ...rows].some(({ row }) => row.length > 0) || skill.goals.length > 0 ? "begun" : "new";
}

/** Return the graph of all lessons. */
export function placesOf(index: Index, skills: Skills, progress: Progress, now: number): Place[] {
  const isLearned = (id: string): boolean => skills[id]?.learned !== undefined;
  return LESSONS.map((lesson) => {
    const missing = lesson.needs
      .filter((need) => !isLearned(need))
      .map((need) => LESSONS.find(({ id }) => id === need)!);
    const skill = skills[lesson.id] ?? NEW;
    const all = classesOf(index, lesson);
    const classes = all.map((armClass, at) => [armClass, rowOf(skill, all, at)] as const);
    const beyond = classes.slice(1).map(([, row]) => row);
    return {
      lesson,
      standing: standingOf(skill, now, beyond),
      classes,
      next: missing.length === 0 && !isLearned(lesson.id),
      missing,
      asked: lesson.questions.flatMap((name) => askedOf(index, name, progress)),
    };
  });
}

/** Return the progress in a question; an empty list if the bank does not ask it. */
function askedOf(index: Index, name: string, progress: Progress): Asked[] {
  const question = index.questions.find((listed) => listed.name === name);
  const all = items(index, { ...ANYTHING, question: name });
  if (!question || all.length === 0) return [];
  const tried = all.map((item) => progress[nameOf(item)]).filter((attempt) => attempt !== undefined);
  const needed = Math.min(NEEDED, all.length);
  return [
    {
      name,
      title: question.title,
      lang: question.lang,
      right: Math.min(needed, tried.filter(({ right }) => right).length),
      needed,
      missed: tried.some(({ right }) => !right),
    },
  ];
}
