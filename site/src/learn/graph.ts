// The graph of lessons: what each lesson builds on, and the student's progress.

import type { Index } from "../bank.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { listClasses, findStreak, type ClassItems } from "../practice/classes.js";
import { isDue, NEW_SKILL, type Streak, type Skill, type Skills } from "../practice/skills.js";

type LessonState = "new" | "begun" | "learned" | "due" | "mastered";

export interface LessonNode {
  readonly lesson: Lesson;
  readonly skill: Skill;
  readonly state: LessonState;
  /** Whether all lessons on which it builds are learned, but not the lesson itself. */
  readonly isNext: boolean;
  /** The lessons on which it builds and which are not learned yet. */
  readonly unlearnedNeeds: readonly Lesson[];
  /** The classes of its arms, with the progress in each. */
  readonly classes: readonly (readonly [ClassItems, Streak])[];
}

/**
 * Return the state of a lesson at a time (ms since 1970), from the progress in the first class of arms (`skill`) and in
 * the later classes. A lesson is mastered if all its classes are.
 */
export function findLessonState(skill: Skill, now: number, laterStreaks: readonly Streak[] = []): LessonState {
  if ([skill, ...laterStreaks].some((streak) => isDue(streak, now))) return "due";
  if ([skill, ...laterStreaks].every(({ mastered }) => mastered !== undefined)) return "mastered";
  if (skill.learned !== undefined) return "learned";
  return [skill, ...laterStreaks].some(({ row }) => row.length > 0) || skill.goals.length > 0 ? "begun" : "new";
}

/** Return all lessons with their states at a time (ms since 1970), in their order. */
export function makeLessonNodes(index: Index, skills: Skills, now: number): LessonNode[] {
  const isLearned = (id: string): boolean => skills[id]?.learned !== undefined;
  return LESSONS.map((lesson) => {
    const unlearnedNeeds = lesson.needs
      .filter((need) => !isLearned(need))
      .map((need) => LESSONS.find(({ id }) => id === need)!);
    const skill = skills[lesson.id] ?? NEW_SKILL;
    const armClasses = listClasses(index, lesson);
    const classes = armClasses.map(
      (armClass, classIndex) => [armClass, findStreak(skill, armClasses, classIndex)] as const,
    );
    const laterStreaks = classes.slice(1).map(([, streak]) => streak);
    return {
      lesson,
      skill,
      state: findLessonState(skill, now, laterStreaks),
      classes,
      isNext: unlearnedNeeds.length === 0 && !isLearned(lesson.id),
      unlearnedNeeds,
    };
  });
}
