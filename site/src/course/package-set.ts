// The set of a SCORM package. At each place of the set, a student's identifier on the platform selects one arm.

import type { Index } from "../bank.js";
import { makeRandomGenerator } from "../practice/choice.js";
import type { Round } from "./round.js";

/** A place of an exported set: its name in the bank, and the questions with points and the factor of partial credit. */
export interface Place {
  readonly name: string;
  readonly questions: readonly (readonly [name: string, points: number, credit: number])[];
}

/** The set of a package. */
export interface PackageSet {
  readonly key: string;
  readonly title: string;
  /** As in `Round`. */
  readonly tries: number;
  /** As `Round.passShare`. */
  readonly pass: number | null;
  readonly places: readonly Place[];
}

/** Return the round of a student: of each place, the arm that the student's identifier selects, with its questions. */
export function selectRound(set: PackageSet, index: Index, learner: string): Round {
  const questions = set.places.flatMap(({ name, questions }) => {
    const problems = index.families.find((family) => family.name === name)?.problems ?? [];
    const selectedProblem =
      problems[Math.floor(makeRandomGenerator(`${set.key}/${name}/${learner}`)() * problems.length)];
    return selectedProblem
      ? questions
          .filter(([question]) => selectedProblem.questions.includes(question))
          .map(([question, points, credit]) => ({
            item: { family: name, key: selectedProblem.key, question },
            points,
            credit,
          }))
      : [];
  });
  return { name: set.title, seed: "", tries: set.tries, passShare: set.pass, questions };
}
