// Answers by letters of options: one, several, or one per item; true or false. The rules of ../../../grader/judging/choices.py.

import type { LettersKey } from "../bank.js";
import { message, type Message } from "../text/text.js";
import { correct, verdictOf, missing, type Slip, type Verdict, wrong } from "./verdict.js";

const LETTERS = "ABCDEFGH";
const EMPTY_ANSWERS = new Set(["", "blank", "ellipsis", "none"]);

export function judgeLetters(answer: string, key: LettersKey): Verdict {
  const text = normalize(answer.slice(0, 1000))
    .trim()
    .replace(/^["'()[\]{}. ]+|["'()[\]{}. ]+$/g, "");
  if (EMPTY_ANSWERS.has(text)) return missing();
  const chosenLetters = parseLetters(answer, key.options);
  const expectedCount = key.type === "choice" ? 1 : key.type === "matching" ? key.items : null;
  if (!chosenLetters || (expectedCount !== null && chosenLetters.length !== expectedCount)) {
    return wrong("verdict.no-letter", {
      said: answer.slice(0, 40),
      letters: [...LETTERS.slice(0, key.options)].join(", "),
    });
  }
  if (key.type === "matching") return judgeMatching(chosenLetters, key);
  return key.type === "choice" ? judgeChoice(chosenLetters[0] as number, key) : judgeSelection(chosenLetters, key);
}

function judgeChoice(option: number, { right, option_mistakes }: LettersKey): Verdict {
  if (right.includes(option)) return correct();
  const verdict = wrong("verdict.letter", { letter: LETTERS[option] ?? "" });
  const mistakes = option_mistakes[option] ?? [];
  return mistakes.length > 1
    ? { ...verdict, slips: mistakes.map((mistake) => ({ mistake })) }
    : { ...verdict, mistake: mistakes[0] };
}

/** A wrong letter, and where it is in the answer. */
interface WrongLetter {
  /** The index of the option, from 0. */
  readonly option: number;
  readonly where: Message;
}

/** Return the mistakes that lead to wrong letters, each once, and with its place if it was made in one place only. */
function findSlipsBehindLetters(
  wrongLetters: readonly WrongLetter[],
  { option_mistakes }: LettersKey,
): readonly Slip[] | undefined {
  const placesByMistake = new Map<number, Message[]>();
  for (const { option, where } of wrongLetters)
    for (const mistake of option_mistakes[option] ?? [])
      placesByMistake.set(mistake, [...(placesByMistake.get(mistake) ?? []), where]);
  const slips = [...placesByMistake].map(([mistake, [firstPlace, ...otherPlaces]]) =>
    firstPlace && otherPlaces.length === 0 ? { mistake, where: firstPlace } : { mistake },
  );
  return slips.length > 0 ? slips : undefined;
}

/** Judge several letters: the share of right letters chosen, minus the share of wrong letters chosen; at least 0. */
function judgeSelection(chosenLetters: readonly number[], key: LettersKey): Verdict {
  const chosenOptions = [...new Set(chosenLetters)];
  const wrongOptions = chosenOptions.filter((option) => !key.right.includes(option));
  const [hits, misses] = [chosenOptions.length - wrongOptions.length, wrongOptions.length];
  if (hits === key.right.length && misses === 0) return correct();
  const wrongLetters = wrongOptions.map((option) => ({
    option,
    where: message("slip.option", { letter: LETTERS[option] ?? "" }),
  }));
  const share = hits / key.right.length - misses / Math.max(key.options - key.right.length, 1);
  return verdictOf(Math.max(share, 0), [message("verdict.letters", { hits, misses })], {
    slips: findSlipsBehindLetters(wrongLetters, key),
  });
}

/** Judge one letter per item: each right pair counts, unless its letter is chosen for another item, too. */
function judgeMatching(letters: readonly number[], key: LettersKey): Verdict {
  const { right: correctLetters } = key;
  const isChosenOnce = (letter: number) => letters.indexOf(letter) === letters.lastIndexOf(letter);
  const wrongItems = correctLetters.flatMap((expected, i) =>
    letters[i] === expected && isChosenOnce(expected) ? [] : [i + 1],
  );
  if (wrongItems.length === 0) return correct();
  const misplacedItems = wrongItems.filter((item) => letters[item - 1] !== correctLetters[item - 1]);
  const wrongLetters = misplacedItems.map((item) => ({
    option: letters[item - 1] as number,
    where: message("slip.item", { item }),
  }));
  const reasons = [message("verdict.matching", { items: wrongItems.join(", ") })];
  const share = (correctLetters.length - wrongItems.length) / correctLetters.length;
  return verdictOf(share, reasons, { slips: findSlipsBehindLetters(wrongLetters, key) });
}

/** Return the indices of the letters in an answer, with or without separators; null if it has anything else. */
export function parseLetters(answer: string, options: number): number[] | null {
  const text = normalize(answer.slice(0, 200)).replace(
    /\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|["'()[\]{}.,;&+\s]/g,
    "",
  );
  const letters = LETTERS.slice(0, options).toLowerCase();
  const indices = [...text].map((letter) => letters.indexOf(letter));
  return indices.length > 0 && !indices.includes(-1) ? indices : null;
}

/** Return a text in lower case, with compatible letters in their plain form and without invisible characters. */
function normalize(text: string): string {
  return text
    .replace(/\p{Cf}/gu, "")
    .normalize("NFKC")
    .toLowerCase();
}
