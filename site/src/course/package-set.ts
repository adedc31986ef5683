// The set of a SCORM package. At each place of the set, a student's identifier on the platform selects one arm.

import type { Index } from "../bank.js";
import { makeRandomGenerator } from "../practice/choice.js";
import type { Round } from "./round.js";

/** A place of an exported set: the questions about its arm, with points and partial credit. */
export interface Place {
  readonly name: string;
  readonly questions: readonly (readonly [name: string, points: number, credit: number])[];
}

/** The set of a package. */
export interface PackageSet {
  readonly key: string;
  readonly title: string;
  readonly tries: number;
  readonly pass: number | null;
  readonly places: readonly Place[];
}

/** Return the round of a student: of each place, the arm that the student's identifier selects, with its questions. */
export function roundOf(set: PackageSet, index: Index, learner: string): Round {
  const asked = set.places.flatMap(({ name, questions }) => {
    const problems = index.families.find((family) => family.name === name)?.problems ?? [];
    const chosen = problems[Math.floor(makeRandomGenerator(`${set.key}/${name}/${learner}`)() * problems.length)];
    return chosen
      ? questions
          .filter(([question]) => chosen.questions.includes(question))
          .map(([question, points, credit]) => ({ item: { family: name, key: chosen.key, question }, points, credit }))
      : [];
  });
  return { name: set.title, seed: "", tries: set.tries, pass: set.pass, asked };
}
