// The graph of lessons: what each lesson builds on, and the student's progress in the lesson and in its questions.

import type { Index } from "../bank.js";
import { ANYTHING, itemsFor, nameOf, type Progress } from "../practice/choice.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { classesOf, streakIn, type ClassItems } from "../practice/classes.js";
import { isDue, NEEDED, NEW_SKILL, type Streak, type Skill, type Skills } from "../practice/skills.js";

export type Standing = "new" | "begun" | "learned" | "due" | "mastered";

/** A question of a lesson: on how many of the needed arms the last answer was right, and whether one was wrong. */
export interface QuestionProgress {
  readonly name: string;
  readonly title: string;
  readonly lang: string | undefined;
  readonly right: number;
  readonly needed: number;
  readonly missed: boolean;
}

export interface LessonNode {
  readonly lesson: Lesson;
  readonly standing: Standing;
  /** Whether everything the lesson builds on is learned, but not the lesson itself. */
  readonly next: boolean;
  /** Lessons it builds on that are not learned yet. */
  readonly missing: readonly Lesson[];
  /** The classes of its arms, with the progress in each. */
  readonly classes: readonly (readonly [ClassItems, Streak])[];
  readonly asked: readonly QuestionProgress[];
}

/** Return the state of a lesson, which is mastered if all classes are; `others` are the classes after the first. */
export function standingOf(skill: Skill, now: number, others: readonly Streak[] = []): Standing {
  if ([skill, ...others].some((row) => isDue(row, now))) return "due";
  if ([skill, ...others].every(({ mastered }) => mastered !== undefined)) return "mastered";
  if (skill.learned !== undefined) return "learned";
  return [skill, ...others].some(({ row }) => row.length > 0) || skill.goals.length > 0 ? "begun" : "new";
}

/** Return the graph of all lessons. */
export function lessonStates(index: Index, skills: Skills, progress: Progress, now: number): LessonNode[] {
  const isLearned = (id: string): boolean => skills[id]?.learned !== undefined;
  return LESSONS.map((lesson) => {
    const missing = lesson.needs
      .filter((need) => !isLearned(need))
      .map((need) => LESSONS.find(({ id }) => id === need)!);
    const skill = skills[lesson.id] ?? NEW_SKILL;
    const armClasses = classesOf(index, lesson);
    const classes = armClasses.map((armClass, at) => [armClass, streakIn(skill, armClasses, at)] as const);
    const laterStreaks = classes.slice(1).map(([, row]) => row);
    return {
      lesson,
      standing: standingOf(skill, now, laterStreaks),
      classes,
      next: missing.length === 0 && !isLearned(lesson.id),
      missing,
      asked: lesson.questions.flatMap((name) => questionProgress(index, name, progress)),
    };
  });
}

/** Return the progress in a question; an empty list if the bank does not ask it. */
function questionProgress(index: Index, name: string, progress: Progress): QuestionProgress[] {
  const question = index.questions.find((listed) => listed.name === name);
  const items = itemsFor(index, { ...ANYTHING, question: name });
  if (!question || items.length === 0) return [];
  const tried = items.map((item) => progress[nameOf(item)]).filter((attempt) => attempt !== undefined);
  const needed = Math.min(NEEDED, items.length);
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
