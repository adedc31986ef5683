// To whom the results of a round go: what every recipient can be told, and what it says of that.

import type { Part } from "../bank.js";
import type { Verdict } from "../grade/verdict.js";
import { keepText, keptText } from "../storage.js";
import type { Message } from "../text/text.js";
import { asText, type Round, type Score, type Standing } from "./round.js";

/** An answer that was judged: to which question, what was typed, and how it was found. */
export type Given = { readonly place: number; readonly part: Part; readonly answer: string; readonly verdict: Verdict };

/** How a round stands, and the answer by which it came to that; null where it was none. */
export interface News {
  readonly round: Round;
  readonly standing: Standing;
  readonly score: Score;
  readonly given: Given | null;
}

export interface Recipient {
  /** What was kept of the round when it was left. */
  readonly kept: string;
  /** What is said of where results go, or why they go nowhere. */
  readonly says: Message;
  /** Whether it takes results at all. */
  readonly takes: boolean;
  /** Tell it; false where it did not take it, and has to be told again. */
  tell(news: News): boolean;
  /** The page is left. */
  leave(news: News): void;
}

/** Whether all questions were answered, or given up. */
export const isComplete = ({ answered, count }: Score): boolean => answered === count;

/** Whether a round is passed; null where nobody has said from what on it would be. */
export function isPassed({ pass }: Round, { share }: Score): boolean | null {
  return pass === null ? null : share >= pass - 1e-9;
}

/** Nobody: the round is kept in this browser, under `key`. */
export function inBrowser(storage: Storage | null, key: string, says: Message): Recipient {
  return {
    kept: keptText(storage, key) ?? "",
    says,
    takes: false,
    tell({ round, standing }) {
      keepText(storage, key, asText(round, standing));
      return true;
    },
    leave: () => undefined,
  };
}
