// The recipients of a round's results: the browser, the surrounding page, or a learning platform.

import type { JudgedPart } from "../practice/task.js";
import { storeText, loadText } from "../storage.js";
import type { Message } from "../text/text.js";
import { writeStanding, type Round, type Score, type Standing } from "./round.js";

/** An answer with its verdict, and the place of its question in the round. */
export type JudgedAnswer = JudgedPart & { readonly place: number };

/** The state of a round, and the answer that led to it; null if there was none. */
export interface Report {
  readonly round: Round;
  readonly standing: Standing;
  readonly score: Score;
  readonly lastAnswer: JudgedAnswer | null;
}

export interface Recipient {
  /** The stored state of the round from an earlier visit; "" if there is none. */
  readonly stored: string;
  /** A sentence on where results go, or why they go nowhere. */
  readonly destination: Message;
  /** Whether it accepts results. */
  readonly isAccepting: boolean;
  /** Report results; return false if they must be reported again. */
  report(current: Report): boolean;
  /** Called when the page is left. */
  leave(current: Report): void;
}

/** Return whether all questions were answered or given up. */
export const isComplete = ({ answered, count }: Score): boolean => answered === count;

/** Return whether a round is passed; null if it has no passing share. */
export function isPassed({ passShare }: Round, { share }: Score): boolean | null {
  return passShare === null ? null : share >= passShare - 1e-9;
}

/** Return a recipient that only stores the round in this browser, under `key`. */
export function makeBrowserRecipient(storage: Storage | null, key: string, destination: Message): Recipient {
  return {
    stored: loadText(storage, key) ?? "",
    destination,
    isAccepting: false,
    report({ round, standing }) {
      storeText(storage, key, writeStanding(round, standing));
      return true;
    },
    leave: () => undefined,
  };
}
