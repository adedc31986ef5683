// The verdict on an answer.

import { catchParseError } from "../read/tree.js";
import { message, type Message, type Values, type TextKey } from "../text/text.js";

/** Values of symbols at a configuration, by name. */
export type SymbolValues = Readonly<Record<string, number>>;

/**
 * `share` of the points, from 0 to 1; `sure`: the exact method would agree except with negligible probability; `at`: a
 * configuration at which the answer differs; `entries`: which entries of a matrix are right; `mistake`: an index into
 * the problem's texts on mistakes; `slips`: other mistakes, each in a part of the answer.
 */
export interface Verdict {
  readonly outcome: "correct" | "partial" | "wrong" | "missing";
  readonly share: number;
  readonly reasons: readonly Message[];
  readonly sure: boolean;
  readonly at?: SymbolValues;
  readonly entries?: readonly (readonly boolean[])[];
  readonly mistake?: number;
  readonly slips?: readonly Slip[];
}

/** A message; or an index into the problem's texts on mistakes, and the place if it was made only there. */
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

/** Return whether an answer could be parsed; one that could not does not count as a try. */
export const isParsed = ({ reasons }: Verdict): boolean => !reasons.some(({ key }) => key.startsWith("read."));

/** Return what `parse` returns, or the verdict that an answer can't be parsed. */
export const parseOrVerdict = <T>(parse: () => T): T | Verdict =>
  catchParseError(parse, ({ why }) => wrong("read.unreadable", { why }));

/** Return the verdict on an answer that is partly right or wrong. */
export function verdictOf(share: number, reasons: readonly Message[], more: Partial<Verdict> = {}): Verdict {
  return { outcome: share > 0 ? "partial" : "wrong", share, reasons, sure: true, ...more };
}
