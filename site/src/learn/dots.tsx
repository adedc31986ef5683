// Show the progress in a lesson as dots and in words: one dot for each right answer in a row.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { currentClass, streakIn, type ClassItems } from "../practice/classes.js";
import { NEEDED, type Streak, type Skill } from "../practice/skills.js";

type DotsProps = { readonly skill: Skill; readonly classes: readonly ClassItems[] };

export function Dots({ skill, classes }: DotsProps): JSX.Element | null {
  if (classes.length === 0) return null;
  const at = currentClass(skill, classes, Date.now());
  const streak = streakIn(skill, classes, at);
  const full = filledDots(streak);
  const text = classes.length > 1 ? describeClass(classes[at]!, streak) : describeProgress(streak);
  return (
    <span class={`dots${streak.mastered !== undefined ? " mastered" : ""}`} title={text}>
      <span aria-hidden="true">{"●".repeat(full) + "○".repeat(NEEDED - full)}</span>
      <span class="visually-hidden">{text}</span>
    </span>
  );
}

const filledDots = ({ row, learned }: Streak): number =>
  learned !== undefined ? NEEDED : Math.min(row.length, NEEDED);

/** Return the state of a class of arms in words, with its name. */
export const describeClass = ({ name }: ClassItems, streak: Streak): string =>
  `${say(`classes.${name}`)}: ${describeProgress(streak)}`;

function describeProgress(streak: Streak): string {
  if (streak.mastered !== undefined) return say("lesson.state-mastered");
  if (streak.learned !== undefined) return say("lesson.state-learned");
  return say("lesson.state-row", { count: filledDots(streak), needed: NEEDED });
}
