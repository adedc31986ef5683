// The graph of lessons: what each lesson builds on, and the student's progress in the lesson and in its questions.

import type { Index } from "../bank.js";
import { ANY_WISH, listItems, nameItem, type Progress } from "../practice/choice.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { listClasses, findStreak, type ClassItems } from "../practice/classes.js";
import { isDue, NEEDED_ARMS, NEW_SKILL, type Streak, type Skill, type Skills } from "../practice/skills.js";

type LessonState = "new" | "begun" | "learned" | "due" | "mastered";

/** The student's progress in a question. */
export interface QuestionProgress {
  readonly name: string;
  readonly title: string;
  /** Code of the title's language; undefined for English. */
  readonly lang: string | undefined;
  /** On how many arms the last answer was right, up to `neededCount`. */
  readonly rightCount: number;
  readonly neededCount: number;
  /** Whether the last answer on some arm was wrong. */
  readonly hasWrongAnswer: boolean;
}

export interface LessonNode {
  readonly lesson: Lesson;
  readonly state: LessonState;
  /** Whether all lessons on which it builds are learned, but not the lesson itself. */
  readonly isNext: boolean;
  /** The lessons on which it builds and which are not learned yet. */
  readonly unlearnedNeeds: readonly Lesson[];
  /** The classes of its arms, with the progress in each. */
  readonly classes: readonly (readonly [ClassItems, Streak])[];
  readonly questions: readonly QuestionProgress[];
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
export function makeLessonNodes(index: Index, skills: Skills, progress: Progress, now: number): LessonNode[] {
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
      state: findLessonState(skill, now, laterStreaks),
      classes,
      isNext: unlearnedNeeds.length === 0 && !isLearned(lesson.id),
      unlearnedNeeds,
      questions: lesson.questions.flatMap((name) => findQuestionProgress(index, name, progress)),
    };
  });
}

/** Return the progress in a question as a list of one element; an empty list if the bank does not ask the question. */
function findQuestionProgress(index: Index, name: string, progress: Progress): QuestionProgress[] {
  const question = index.questions.find((entry) => entry.name === name);
  const items = listItems(index, { ...ANY_WISH, question: name });
  if (!question || items.length === 0) return [];
  const attempts = items.map((item) => progress[nameItem(item)]).filter((attempt) => attempt !== undefined);
  const needed = Math.min(NEEDED_ARMS, items.length);
  return [
    {
      name,
      title: question.title,
      lang: question.lang,
      rightCount: Math.min(needed, attempts.filter(({ right }) => right).length),
      neededCount: needed,
      hasWrongAnswer: attempts.some(({ right }) => !right),
    },
  ];
}
