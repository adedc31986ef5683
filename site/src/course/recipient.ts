// The recipients of a round's results: the browser, the surrounding page, or a learning platform.

import type { Part } from "../bank.js";
import type { Verdict } from "../grade/verdict.js";
import { storeText, storedText } from "../storage.js";
import type { Message } from "../text/text.js";
import { asText, type Round, type Score, type Standing } from "./round.js";

/** An answer that was judged: the question, the typed answer and the verdict. */
export type Given = { readonly place: number; readonly part: Part; readonly answer: string; readonly verdict: Verdict };

/** The state of a round, and the answer that led to it; null if there was none. */
export interface News {
  readonly round: Round;
  readonly standing: Standing;
  readonly score: Score;
  readonly given: Given | null;
}

export interface Recipient {
  /** The stored state of the round from an earlier visit; "" if there is none. */
  readonly kept: string;
  /** A sentence on where results go, or why they go nowhere. */
  readonly says: Message;
  /** Whether it accepts results. */
  readonly takes: boolean;
  /** Report results; return false if they must be reported again. */
  tell(news: News): boolean;
  /** Called when the page is left. */
  leave(news: News): void;
}

/** Return whether all questions were answered or given up. */
export const isComplete = ({ answered, count }: Score): boolean => answered === count;

/** Return whether a round is passed; null if it has no passing share. */
export function isPassed({ pass }: Round, { share }: Score): boolean | null {
  return pass === null ? null : share >= pass - 1e-9;
}

/** Return a recipient that only stores the round in this browser, under `key`. */
export function storedInBrowser(storage: Storage | null, key: string, says: Message): Recipient {
  return {
    kept: storedText(storage, key) ?? "",
    says,
    takes: false,
    tell({ round, standing }) {
      storeText(storage, key, asText(round, standing));
      return true;
    },
    leave: () => undefined,
  };
}
