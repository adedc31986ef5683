// How much feedback a wrong answer gets, by the `feedback` of an assignment: the levels of ../../../grader/levels.py.

import { message, type Message, type TextKey } from "../text/text.js";
import type { Verdict } from "./verdict.js";

/** From least to most; each level includes those before. */
export const LEVELS = ["outcome", "mistake", "counterexample", "values", "solutions"] as const;
export type Level = (typeof LEVELS)[number];

/** Messages that reveal a correct value, and the message that replaces each: it shows the answer's own value. */
const WITHOUT_VALUES: Partial<Record<TextKey, TextKey>> = {
  "verdict.entry": "verdict.own-entry",
  "verdict.differs": "verdict.own-value",
  "verdict.number": "verdict.own-number",
  "verdict.uncovered": "verdict.some-uncovered",
};

/** Messages that reveal a counterexample, and the message that replaces each. */
const WITHOUT_NUMBERS: Partial<Record<TextKey, TextKey>> = {
  "verdict.own-entry": "verdict.that-entry",
  "verdict.own-value": "verdict.not-equal",
  "verdict.own-number": "verdict.that-number",
  "verdict.unsound": "verdict.some-unsound",
  "verdict.not-along": "verdict.other-direction",
};

export const atLeast = (level: Level, wanted: Level): boolean => LEVELS.indexOf(level) >= LEVELS.indexOf(wanted);

/** Return the level that reveals less. */
export const lower = (one: Level, other: Level): Level => (atLeast(one, other) ? other : one);

/** Return a verdict without what the level hides; a right answer, or one that can't be parsed, keeps everything. */
export function limitTo(verdict: Verdict, level: Level): Verdict {
  const { outcome, share, sure, reasons } = verdict;
  if (outcome === "correct" || outcome === "missing" || atLeast(level, "values")) return verdict;
  if (!atLeast(level, "mistake")) return { outcome, share, sure, reasons: reasons.filter(isOfReading) };
  const withoutValues = reasons.map((reason) => replaceKey(reason, WITHOUT_VALUES));
  const isShown = atLeast(level, "counterexample");
  const revealsPose = reasons.some(({ key }) => key === "verdict.uncovered"); // a pose that belongs to the answer
  const { at, ...others } = verdict;
  return {
    ...others,
    reasons: isShown ? withoutValues : withoutValues.map((reason) => replaceKey(reason, WITHOUT_NUMBERS)),
    ...(isShown && at && !revealsPose ? { at } : {}),
  };
}

function replaceKey({ key, values }: Message, keys: Partial<Record<TextKey, TextKey>>): Message {
  return message(keys[key] ?? key, values);
}

const isOfReading = ({ key }: Message): boolean => key.startsWith("read.") || key === "verdict.no-letter";
