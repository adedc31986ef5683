// Letters of options: one, several, one for each item; true or false. The rules of ../../../grader/choices.py.

import type { LettersKey } from "../bank.js";
import { message, type Message } from "../text/text.js";
import { correct, graded, missing, type Slip, type Verdict, wrong } from "./verdict.js";

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
  if (key.type === "matching") return matched(chosen, key);
  return key.type === "choice" ? single(chosen[0] as number, key) : selected(chosen, key);
}

function single(chosen: number, { right, told }: LettersKey): Verdict {
  if (right.includes(chosen)) return correct();
  const [first, ...more] = told[chosen] ?? [];
  return {
    ...wrong("verdict.letter", { letter: LETTERS[chosen] ?? "" }),
    ...(first === undefined || more.length > 0 ? {} : { mistake: first }),
    ...(first === undefined || more.length === 0 ? {} : { slips: [first, ...more].map((mistake) => ({ mistake })) }),
  };
}

/** What is behind wrong letters, each said once, and where if it is in one place; nothing where nothing is known. */
function behind(
  letters: readonly (readonly [letter: number, where: Message])[],
  { told }: LettersKey,
): { slips?: readonly Slip[] } {
  const places = new Map<number, Message[]>();
  for (const [letter, where] of letters)
    for (const mistake of told[letter] ?? []) places.set(mistake, [...(places.get(mistake) ?? []), where]);
  const slips = [...places].map(([mistake, [where, ...more]]) =>
    where && more.length === 0 ? { mistake, where } : { mistake },
  );
  return slips.length > 0 ? { slips } : {};
}

/** Each right letter counts, each wrong one as much against it, none below zero. */
function selected(chosen: readonly number[], key: LettersKey): Verdict {
  const all = new Set(chosen);
  const hits = [...all].filter((index) => key.right.includes(index)).length;
  const misses = all.size - hits;
  if (hits === key.right.length && misses === 0) return correct();
  const wrongOnes = [...all].filter((index) => !key.right.includes(index));
  const places = wrongOnes.map((index) => [index, message("slip.option", { letter: LETTERS[index] ?? "" })] as const);
  const share = hits / key.right.length - misses / Math.max(key.options - key.right.length, 1);
  return graded(Math.max(share, 0), [message("verdict.letters", { hits, misses })], behind(places, key));
}

/** Each right pair counts; a letter that is given twice is no choice. */
function matched(chosen: readonly number[], key: LettersKey): Verdict {
  const { right } = key;
  const isOnce = (letter: number) => chosen.filter((each) => each === letter).length === 1;
  const off = right.flatMap((due, i) => (chosen[i] === due && isOnce(due) ? [] : [i + 1]));
  if (off.length === 0) return correct();
  const others = off.filter((item) => chosen[item - 1] !== right[item - 1]);
  const places = others.map((item) => [chosen[item - 1] as number, message("slip.item", { item })] as const);
  const reasons = [message("verdict.matching", { items: off.join(", ") })];
  return graded((right.length - off.length) / right.length, reasons, behind(places, key));
}

/** The options that are meant by letters in a row or with commas between; null where it is something else. */
export function chosenLetters(answer: string, options: number): number[] | null {
  const said = plain(answer.slice(0, 200)).replace(/\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|["'()[\]{}.,;&+\s]/g, "");
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
