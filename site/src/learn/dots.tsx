// Show the progress in a lesson as dots and in words: one dot for each right answer in a row.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { chooseClassIndex, findStreak, type ClassItems } from "../practice/classes.js";
import { NEEDED_ARMS, type Streak, type Skill } from "../practice/skills.js";

type DotsProps = { readonly skill: Skill; readonly classes: readonly ClassItems[] };

export function Dots({ skill, classes }: DotsProps): JSX.Element | null {
  if (classes.length === 0) return null;
  const classIndex = chooseClassIndex(skill, classes, Date.now());
  const streak = findStreak(skill, classes, classIndex);
  const filledCount = countFilledDots(streak);
  const text = classes.length > 1 ? describeClass(classes[classIndex]!, streak) : describeProgress(streak);
  return (
    <span class={`dots${streak.mastered !== undefined ? " mastered" : ""}`} title={text}>
      <span aria-hidden="true">{"●".repeat(filledCount) + "○".repeat(NEEDED_ARMS - filledCount)}</span>
      <span class="visually-hidden">{text}</span>
    </span>
  );
}

const countFilledDots = ({ row, learned }: Streak): number =>
  learned !== undefined ? NEEDED_ARMS : Math.min(row.length, NEEDED_ARMS);

/** Return the state of a class of arms in words, with its name. */
const describeClass = ({ name }: ClassItems, streak: Streak): string =>
  `${say(`classes.${name}`)}: ${describeProgress(streak)}`;

function describeProgress(streak: Streak): string {
  if (streak.mastered !== undefined) return say("lesson.state-mastered");
  if (streak.learned !== undefined) return say("lesson.state-learned");
  return say("lesson.state-row", { count: countFilledDots(streak), needed: NEEDED_ARMS });
}
