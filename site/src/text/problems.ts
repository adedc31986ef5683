// Translate the texts of the bank into the page's language, if there is a translation.

import type { Index, Problem, Solutions, TranslatedSolutions, TranslatedTexts, TranslatedTitles } from "../bank.js";

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

/** Return a problem with translated texts; in English if they are missing or belong to another problem. */
export function translateProblem(lang: string, problem: Problem, texts: TranslatedTexts | null): Problem {
  if (!texts || !doTextsFit(problem, texts)) return problem;
  return {
    ...problem,
    lang,
    title: texts.title,
    statement: texts.statement,
    robot: { ...problem.robot, title: texts.title },
    parts: problem.parts.map((part, i) => ({ ...part, ...texts.parts[i] })),
    said: texts.said,
  };
}

/** Return translated solutions; in English if they are missing or belong to another problem. */
export function translateSolutions(lang: string, solutions: Solutions, texts: TranslatedSolutions | null): Solutions {
  const { parts } = solutions;
  const isSameProblem =
    texts?.parts.length === parts.length && texts.parts.every(({ name }, i) => name === parts[i]?.name);
  if (!texts || !isSameProblem) return solutions;
  return { ...solutions, lang, parts: parts.map((part, i) => ({ ...part, ...texts.parts[i] })) };
}

/** Return whether texts belong to a problem. */
function doTextsFit({ parts, said }: Problem, texts: TranslatedTexts): boolean {
  return (
    texts.parts.length === parts.length &&
    texts.said.length === said.length &&
    texts.parts.every(
      ({ name, options }, i) => name === parts[i]?.name && options?.length === (parts[i]?.options ?? undefined)?.length,
    )
  );
}
