// Answers by letters of options: one, several, or one per item; true or false. The rules of ../../../grader/judging/choices.py.

import type { LettersKey } from "../bank.js";
import { message, type Message } from "../text/text.js";
import { correct, isVerdict, verdictOf, missing, type Slip, type Verdict, wrong } from "./verdict.js";

const LETTERS = "ABCDEFGH";
const EMPTY_ANSWERS = new Set(["", "blank", "ellipsis", "none"]);

export function judgeLetters(answer: string, key: LettersKey): Verdict {
  const chosenLetters = readLetters(answer, key);
  if (isVerdict(chosenLetters)) return chosenLetters;
  if (key.type === "matching") return judgeMatching(chosenLetters, key);
  return key.type === "choice" ? judgeChoice(chosenLetters[0] as number, key) : judgeSelection(chosenLetters, key);
}

/** Return the indices of the chosen options, or the verdict on another text; `texts` are those of the options, if known. */
export function readLetters(
  answer: string,
  { type, options, items }: Pick<LettersKey, "type" | "options" | "items">,
  texts: readonly string[] = [],
): readonly number[] | Verdict {
  if (EMPTY_ANSWERS.has(stripLabel(answer))) return missing();
  const chosenLetters =
    type === "choice" && texts.length > 0 ? findOption(answer, texts) : parseLetters(answer, options);
  const expectedCount = type === "choice" ? 1 : type === "matching" ? items : null;
  if (chosenLetters && (expectedCount === null || chosenLetters.length === expectedCount)) return chosenLetters;
  const hasSeveralLetters = type === "choice" && (parseLetters(answer, options) ?? []).length > 1;
  return wrong(hasSeveralLetters ? "read.several-letters" : "verdict.no-letter", {
    said: answer.slice(0, 40),
    letters: isTrueOrFalse(texts) ? texts.join(", ") : [...LETTERS.slice(0, options)].join(", "),
  });
}

/** Return whether a question asks if a statement is true. */
export const isTrueOrFalse = (texts: readonly string[]): boolean => texts.join() === "true,false";

/** A shorter text is not taken for a part of an option's text. */
const MIN_PART_LENGTH = 4;

/** Return the index, in a list, of the option with this letter or text; null if none or several match. */
function findOption(answer: string, texts: readonly string[]): readonly number[] | null {
  const typed = stripLabel(answer);
  const word = isTrueOrFalse(texts) ? texts.find((text) => text[0] === typed) : undefined;
  const exactIndex = texts.findIndex((text) => stripLabel(text) === (word ?? typed));
  if (exactIndex >= 0) return [exactIndex];
  const choice = /^([a-h])\s*[.):]/.exec(typed)?.[1] ?? typed;
  const letterIndex = LETTERS.slice(0, texts.length).toLowerCase().indexOf(choice);
  if (choice.length === 1 && letterIndex >= 0) return [letterIndex];
  const indices = texts.flatMap((text, i) => (text.toLowerCase().includes(choice) ? [i] : []));
  return choice.length >= MIN_PART_LENGTH && indices.length === 1 ? indices : null;
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

/** The words before a letter, as in "Answer: C". */
const LABEL_BEFORE_LETTER = /^(?:answer|option|antwort|lösung|solution)(?: is| ist| ?[:=])? ?(?=["'([]?[a-h](?![a-z]))/;

/** Return a text in lower case without words before a letter, and without quotes and brackets around it. */
const stripLabel = (text: string): string =>
  normalize(text.slice(0, MAX_LENGTH))
    .replace(/\s+/g, " ")
    .replace(LABEL_BEFORE_LETTER, "")
    .replace(/^["'()[\]{}.„“”‚‘’«» ]+|["'()[\]{}.„“”‚‘’«» ]+$/g, "");

/** Only so many characters of an answer are searched for an option. */
const MAX_LENGTH = 1000;

/** Return a text in lower case, with compatible letters in their plain form and without invisible characters. */
function normalize(text: string): string {
  return text
    .replace(/\p{Cf}/gu, "")
    .normalize("NFKC")
    .toLowerCase();
}
