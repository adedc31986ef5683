// How much feedback a wrong answer gets, by the `feedback` of an assignment: the levels of ../../../grader/reports/feedback_levels.py.

import { ENGLISH, message, type Message, type TextKey } from "../text/text.js";
import type { Verdict } from "./verdict.js";

/** From least to most; each level includes those before. */
export const LEVELS = ["outcome", "mistake", "counterexample", "values", "solutions"] as const;
export type Level = (typeof LEVELS)[number];

/** Messages that reveal a correct value, and the message that replaces each: it shows the answer's own value. */
const REPLACEMENTS_WITHOUT_VALUES: Partial<Record<TextKey, TextKey>> = {
  "verdict.entry": "verdict.own-entry",
  "verdict.differs": "verdict.own-value",
  "verdict.number": "verdict.own-number",
  "verdict.uncovered": "verdict.some-uncovered",
};

/** Messages that reveal a counterexample, and the message that replaces each. */
const REPLACEMENTS_WITHOUT_NUMBERS: Partial<Record<TextKey, TextKey>> = {
  "verdict.own-entry": "verdict.that-entry",
  "verdict.own-value": "verdict.not-equal",
  "verdict.own-number": "verdict.that-number",
  "verdict.unsound": "verdict.some-unsound",
  "verdict.not-along": "verdict.other-direction",
};

export const isAtLeast = (level: Level, minLevel: Level): boolean => LEVELS.indexOf(level) >= LEVELS.indexOf(minLevel);

/** Return the level that reveals less. */
export const chooseLowerLevel = (a: Level, b: Level): Level => (isAtLeast(a, b) ? b : a);

/** Return a verdict without what the level hides, in words that fit the set that was asked for. */
export function limitVerdict(verdict: Verdict, level: Level): Verdict {
  const shown = hideDetails(verdict, level);
  if (!verdict.ofOwnSet) return shown;
  const slips = shown.slips?.map((slip) => ("key" in slip ? rewordForOwnSet(slip) : slip));
  return { ...shown, reasons: shown.reasons.map(rewordForOwnSet), slips };
}

/** Return a message about singular configurations as one about the configurations of another set. */
function rewordForOwnSet({ key, values }: Message): Message {
  const ownKey = `own-set.${key}`;
  return message(ownKey in ENGLISH.catalogue ? (ownKey as TextKey) : key, values);
}

/** Return a verdict without what the level hides. The verdict on a correct or missing answer stays unchanged. */
function hideDetails(verdict: Verdict, level: Level): Verdict {
  const { outcome, share, isSure, reasons } = verdict;
  if (outcome === "correct" || outcome === "missing" || isAtLeast(level, "values")) return verdict;
  if (!isAtLeast(level, "mistake")) return { outcome, share, isSure, reasons: reasons.filter(isParseMessage) };
  const withoutValues = reasons.map((reason) => replaceKey(reason, REPLACEMENTS_WITHOUT_VALUES));
  const showsCounterexample = isAtLeast(level, "counterexample");
  const revealsPose = reasons.some(({ key }) => key === "verdict.uncovered"); // a pose that belongs to the answer
  return {
    ...verdict,
    reasons: showsCounterexample
      ? withoutValues
      : withoutValues.map((reason) => replaceKey(reason, REPLACEMENTS_WITHOUT_NUMBERS)),
    counterexample: showsCounterexample && !revealsPose ? verdict.counterexample : undefined,
  };
}

function replaceKey({ key, values }: Message, replacements: Partial<Record<TextKey, TextKey>>): Message {
  return message(replacements[key] ?? key, values);
}

const isParseMessage = ({ key }: Message): boolean => key.startsWith("read.") || key === "verdict.no-letter";
