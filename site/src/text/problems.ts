// Translate the texts of the bank into the page's language, if there is a translation.

import type { Index, Part, Problem, TranslatedArm, TranslatedQuestion, TranslatedTitles } from "../bank.js";

/** Return the index with translated titles; titles without a translation stay English. */
export function translateIndex(lang: string, index: Index, titles: TranslatedTitles | null): Index {
  if (!titles) return index;
  const translate = <T extends { name: string }>(entries: readonly T[], titlesByName: TranslatedTitles["families"]) =>
    entries.map((entry) => ({
      ...entry,
      ...(titlesByName[entry.name] ? { title: titlesByName[entry.name]!, lang } : {}),
    }));
  return {
    ...index,
    families: translate(index.families, titles.families),
    questions: translate(index.questions, titles.questions),
  };
}

/** Return a problem with translated texts; in English if some are missing or belong to another problem. */
export function translateProblem(
  lang: string,
  problem: Problem,
  arm: TranslatedArm | null,
  question: TranslatedQuestion | null,
): Problem {
  const part = problem.parts[0];
  if (!arm || !question || !part || !doTextsFit(problem, part, question)) return problem;
  const { said, solved, ...texts } = question;
  return {
    ...problem,
    lang,
    title: arm.title,
    statement: arm.statement,
    robot: { ...problem.robot, title: arm.title },
    parts: [{ ...part, ...texts, ...(part.solved && { solved: { ...part.solved, ...solved } }) }],
    said,
  };
}

/** Return whether texts belong to a question of a problem. */
const doTextsFit = ({ said }: Problem, { name, options }: Part, texts: TranslatedQuestion): boolean =>
  name === texts.name &&
  options?.length === texts.options?.length &&
  Object.keys(said).join() === Object.keys(texts.said).join();
