// The set of a package: places, of each of which every student has one arm, by the identifier that the platform knows.

import type { Index } from "../bank.js";
import { numbers } from "../practice/choice.js";
import type { Round } from "./round.js";

/** A place of a set that was exported: its questions with points and credit, of which arm each student has one. */
export interface Place {
  readonly name: string;
  readonly questions: readonly (readonly [name: string, points: number, credit: number])[];
}

/** What a package says of its set. */
export interface PackageSet {
  readonly key: string;
  readonly title: string;
  readonly tries: number;
  readonly pass: number | null;
  readonly places: readonly Place[];
}

/** The round of a student: of each place the arm that the student's identifier draws, with all of its questions. */
export function roundOf(set: PackageSet, index: Index, learner: string): Round {
  const asked = set.places.flatMap(({ name, questions }) => {
    const problems = index.families.find((family) => family.name === name)?.problems ?? [];
    const chosen = problems[Math.floor(numbers(`${set.key}/${name}/${learner}`)() * problems.length)];
    return chosen
      ? questions
          .filter(([question]) => chosen.questions.includes(question))
          .map(([question, points, credit]) => ({ item: { family: name, key: chosen.key, question }, points, credit }))
      : [];
  });
  return { name: set.title, seed: "", tries: set.tries, pass: set.pass, asked };
}
