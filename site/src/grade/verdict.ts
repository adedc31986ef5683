// The verdict on an answer.

import { catchParseError, type SymbolValues } from "../read/tree.js";
import { message, type Message, type Values, type TextKey } from "../text/text.js";

export interface Verdict {
  readonly outcome: "correct" | "partial" | "wrong" | "missing";
  /** The share of the part's points, from 0 to 1. */
  readonly share: number;
  readonly reasons: readonly Message[];
  /** Whether the exact method of `qdot grade` would agree, except with negligible probability. */
  readonly isSure: boolean;
  /** A configuration at which the answer is wrong (rad, m). */
  readonly counterexample?: SymbolValues | undefined;
  /** Whether each entry of a matrix is right, in rows. */
  readonly entries?: readonly (readonly boolean[])[];
  /** Whether the answer is a set that is not that of the singular configurations. */
  readonly ofOwnSet?: boolean;
  /** The known mistake that explains the answer, as an index into the problem's texts on mistakes. */
  readonly mistake?: number | undefined;
  /** Other mistakes, each in a part of the answer. */
  readonly slips?: readonly Slip[] | undefined;
}

/** Return whether a result is a verdict, because the answer was refused before it was judged. */
export const isVerdict = (result: object): result is Verdict => "outcome" in result;

/** A message; or a known mistake (an index as in `Verdict`), with its place if it was made only there. */
export type Slip = Message | { readonly mistake: number; readonly where?: Message };

export function correct(reason?: Message, isSure = true): Verdict {
  return { outcome: "correct", share: 1, reasons: reason ? [reason] : [], isSure };
}

export function missing(): Verdict {
  return { outcome: "missing", share: 0, reasons: [message("read.missing")], isSure: true };
}

export function wrong(key: TextKey, values: Values = {}): Verdict {
  return { outcome: "wrong", share: 0, reasons: [message(key, values)], isSure: true };
}

/** Return the first five of some names, in alphabetical order, as text. */
export const listNames = (names: Iterable<string>): string => [...names].sort().slice(0, 5).join(", ");

/** Return whether the answer could be parsed; an answer that could not be parsed does not count as a try. */
export const isParsed = ({ reasons }: Verdict): boolean => !reasons.some(({ key }) => key.startsWith("read."));

/** Return what `parse` returns, or the verdict that an answer can't be parsed. */
export const parseOrVerdict = <T>(parse: () => T): T | Verdict =>
  catchParseError(parse, ({ why }) => wrong("read.unreadable", { why }));

/** Return the verdict on an answer that is wrong or, if the share is above 0, partly right. */
export function verdictOf(share: number, reasons: readonly Message[], details: Partial<Verdict> = {}): Verdict {
  return { outcome: share > 0 ? "partial" : "wrong", share, reasons, isSure: true, ...details };
}
