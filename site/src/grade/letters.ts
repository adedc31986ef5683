// Letters of options: one, several, one for each item; true or false. The rules of ../../../grader/choices.py.

import type { LettersKey } from "../bank.js";
import { message } from "../text/text.js";
import { correct, graded, missing, type Verdict, wrong } from "./verdict.js";

const LETTERS = "ABCDEFGH";
const NOTHING = new Set(["", "blank", "ellipsis", "none"]);

export function judgeLetters(answer: string, key: LettersKey): Verdict {
  const shown = plain(answer.slice(0, 1000))
    .trim()
    .replace(/^["'()[\]{}. ]+|["'()[\]{}. ]+$/g, "");
  if (NOTHING.has(shown)) return missing();
  const chosen = chosenLetters(answer, key.options);
  const due = key.type === "choice" ? 1 : key.type === "matching" ? key.items : null;
  if (!chosen || (due !== null && chosen.length !== due)) {
    return wrong("verdict.no-letter", {
      said: answer.slice(0, 40),
      letters: [...LETTERS.slice(0, key.options)].join(", "),
    });
  }
  if (key.type === "matching") return matched(chosen, key.right);
  return key.type === "choice" ? single(chosen[0] as number, key.right) : selected(chosen, key);
}

function single(chosen: number, right: readonly number[]): Verdict {
  if (right.includes(chosen)) return correct();
  return wrong("verdict.letter", { letter: LETTERS[chosen] ?? "" });
}

/** Each right letter counts, each wrong one as much against it, none below zero. */
function selected(chosen: readonly number[], key: LettersKey): Verdict {
  const all = new Set(chosen);
  const hits = [...all].filter((index) => key.right.includes(index)).length;
  const misses = all.size - hits;
  if (hits === key.right.length && misses === 0) return correct();
  const share = hits / key.right.length - misses / Math.max(key.options - key.right.length, 1);
  return graded(Math.max(share, 0), [message("verdict.letters", { hits, misses })]);
}

/** Each right pair counts; a letter that is given twice is no choice. */
function matched(chosen: readonly number[], right: readonly number[]): Verdict {
  const isOnce = (letter: number) => chosen.filter((each) => each === letter).length === 1;
  const off = right.flatMap((due, i) => (chosen[i] === due && isOnce(due) ? [] : [i + 1]));
  if (off.length === 0) return correct();
  return graded((right.length - off.length) / right.length, [
    message("verdict.matching", { items: off.join(", ") }),
  ]);
}

/** The options that are meant by letters in a row or with commas between; null where it is something else. */
export function chosenLetters(answer: string, options: number): number[] | null {
  const said = plain(answer.slice(0, 200)).replace(
    /\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|["'()[\]{}.,;&+\s]/g,
    "",
  );
  const letters = LETTERS.slice(0, options).toLowerCase();
  const found = [...said].map((letter) => letters.indexOf(letter));
  return found.length > 0 && !found.includes(-1) ? found : null;
}

/** A text in small letters, wide ones as plain ones, without marks that nobody sees. */
function plain(text: string): string {
  return text
    .replace(/\p{Cf}/gu, "")
    .normalize("NFKC")
    .toLowerCase();
}
