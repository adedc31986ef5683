// How much is told of a wrong answer, by the `feedback` of an assignment: the levels of ../../../grader/levels.py.

import { message, type Message, type TextKey } from "../text/text.js";
import type { Verdict } from "./verdict.js";

/** From little to all; each tells what those before it do. */
export const LEVELS = ["outcome", "mistake", "counterexample", "values", "solutions"] as const;
export type Level = (typeof LEVELS)[number];

/** What tells a value that is right, with what is said in its place: the answer's own value there. */
const WITHOUT_VALUES: Partial<Record<TextKey, TextKey>> = {
  "verdict.entry": "verdict.own-entry",
  "verdict.differs": "verdict.own-value",
  "verdict.number": "verdict.own-number",
  "verdict.uncovered": "verdict.some-uncovered",
};

/** What tells of a counterexample, with what is said in its place. */
const WITHOUT_NUMBERS: Partial<Record<TextKey, TextKey>> = {
  "verdict.own-entry": "verdict.that-entry",
  "verdict.own-value": "verdict.not-equal",
  "verdict.own-number": "verdict.that-number",
  "verdict.unsound": "verdict.some-unsound",
  "verdict.not-along": "verdict.other-direction",
};

export const atLeast = (level: Level, wanted: Level): boolean => LEVELS.indexOf(level) >= LEVELS.indexOf(wanted);

/** The level that tells less. */
export const lower = (one: Level, other: Level): Level => (atLeast(one, other) ? other : one);

/** A verdict without what the level keeps back; of a right answer, and of one that can't be parsed, all is told. */
export function told(verdict: Verdict, level: Level): Verdict {
  const { outcome, share, sure, reasons, at, entries, mistake, slips } = verdict;
  if (outcome === "correct" || outcome === "missing" || atLeast(level, "values")) return verdict;
  const isOfTheSet = reasons.some(({ key }) => key === "verdict.uncovered"); // a pose that belongs to the answer
  if (!atLeast(level, "mistake")) return { outcome, share, sure, reasons: reasons.filter(isOfReading) };
  const withoutValues = reasons.map((reason) => instead(reason, WITHOUT_VALUES));
  const shown = atLeast(level, "counterexample");
  return {
    outcome,
    share,
    sure,
    reasons: shown ? withoutValues : withoutValues.map((reason) => instead(reason, WITHOUT_NUMBERS)),
    ...(shown && at && !isOfTheSet ? { at } : {}),
    ...(entries ? { entries } : {}),
    ...(mistake === undefined ? {} : { mistake }),
    ...(slips ? { slips } : {}),
  };
}

function instead({ key, values }: Message, keys: Partial<Record<TextKey, TextKey>>): Message {
  return message(keys[key] ?? key, values);
}

const isOfReading = ({ key }: Message): boolean => key.startsWith("read.") || key === "verdict.no-letter";
