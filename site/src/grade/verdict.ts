// What is said of an answer.

import { ReadError } from "../read/tree.js";
import { message, type Message, type Values, type TextKey } from "../text/text.js";

/** Symbols' values at a configuration, by name. */
export type At = Readonly<Record<string, number>>;

/**
 * `share` of the points, from 0 to 1; `sure` where the exact method would say the same but for a chance that is none;
 * `at` the configuration at which it differs; `entries` which entries of a matrix are right; `mistake` an index into
 * what the problem says of mistakes, `slips` what else seems to have gone wrong, each in a part of the answer.
 */
export interface Verdict {
  readonly outcome: "correct" | "partial" | "wrong" | "missing";
  readonly share: number;
  readonly reasons: readonly Message[];
  readonly sure: boolean;
  readonly at?: At;
  readonly entries?: readonly (readonly boolean[])[];
  readonly mistake?: number;
  readonly slips?: readonly Slip[];
}

/** A text, or an index into what the problem says of mistakes and where that was made, if only there. */
export type Slip = Message | { readonly mistake: number; readonly where?: Message };

export function correct(reason?: Message, sure = true): Verdict {
  return { outcome: "correct", share: 1, reasons: reason ? [reason] : [], sure };
}

export function missing(): Verdict {
  return { outcome: "missing", share: 0, reasons: [message("read.missing")], sure: true };
}

export function wrong(key: TextKey, values: Values = {}): Verdict {
  return { outcome: "wrong", share: 0, reasons: [message(key, values)], sure: true };
}

/** Whether an answer could be read at all; what could not is told so, and is no try. */
export const isRead = ({ reasons }: Verdict): boolean => !reasons.some(({ key }) => key.startsWith("read."));

/** What comes of an answer, or the verdict that it can't be parsed. */
export function ifRead<T>(work: () => T): T | Verdict {
  try {
    return work();
  } catch (error) {
    if (error instanceof ReadError) return wrong("read.unreadable", { why: error.why });
    throw error;
  }
}

/** An answer that is right in part, or not at all. */
export function graded(share: number, reasons: readonly Message[], more: Partial<Verdict> = {}): Verdict {
  return { outcome: share > 0 ? "partial" : "wrong", share, reasons, sure: true, ...more };
}
