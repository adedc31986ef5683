// What the bank says in English, in the language of the page where there is a translation of it.

import type { Index, Problem, Solutions, SolvedTexts, Texts, Titles } from "../bank.js";

/** The index with titles in a language; what has none there keeps its English one. */
export function titledIn(lang: string, index: Index, titles: Titles | null): Index {
  const titled = <T extends { name: string; title: string }>(all: readonly T[], by: Readonly<Record<string, string>>) =>
    all.map((one) => (by[one.name] ? { ...one, title: by[one.name] as string, lang } : one));
  if (!titles) return index;
  return {
    ...index,
    families: titled(index.families, titles.families),
    questions: titled(index.questions, titles.questions),
  };
}

/** A problem with its texts in a language; in English where they are missing, or are those of another problem. */
export function toldIn(lang: string, problem: Problem, texts: Texts | null): Problem {
  if (!texts || !fit(problem, texts)) return problem;
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

/** Solutions in a language; in English where they are missing, or are those of another problem. */
export function solvedIn(lang: string, solutions: Solutions, texts: SolvedTexts | null): Solutions {
  const { parts } = solutions;
  const same = texts?.parts.length === parts.length && texts.parts.every(({ name }, i) => name === parts[i]?.name);
  if (!texts || !same) return solutions;
  return { ...solutions, lang, parts: parts.map((part, i) => ({ ...part, ...texts.parts[i] })) };
}

function fit({ parts, said }: Problem, texts: Texts): boolean {
  return (
    texts.parts.length === parts.length &&
    texts.said.length === said.length &&
    texts.parts.every(
      ({ name, options }, i) => name === parts[i]?.name && options?.length === (parts[i]?.options ?? undefined)?.length,
    )
  );
}
