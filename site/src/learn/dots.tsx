// Show the progress in a lesson as dots and in words: one dot for each right answer in a row.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { chooseClassIndex, findStreak, type ClassItems } from "../practice/classes.js";
import { countNeededArms, type Skill, type Streak } from "../practice/skills.js";

type DotsProps = { readonly skill: Skill; readonly classes: readonly ClassItems[] };

export function Dots({ skill, classes }: DotsProps): JSX.Element | null {
  const classIndex = chooseClassIndex(skill, classes, Date.now());
  const armClass = classes[classIndex];
  if (!armClass) return null;
  const streak = findStreak(skill, classes, classIndex);
  const needed = countNeededArms(armClass.items);
  const count = streak.learned !== undefined ? needed : Math.min(streak.row.length, needed);
  const progress = describeProgress(streak, count, needed);
  const text = classes.length > 1 ? `${say(`classes.${armClass.name}`)}: ${progress}` : progress;
  return (
    <span class={`dots${streak.mastered !== undefined ? " mastered" : ""}`} title={text}>
      <span aria-hidden="true">{"●".repeat(count) + "○".repeat(needed - count)}</span>
      <span class="visually-hidden">{text}</span>
    </span>
  );
}

function describeProgress({ learned, mastered }: Streak, count: number, needed: number): string {
  if (mastered !== undefined) return say("lesson.state-mastered");
  return learned !== undefined ? say("lesson.state-learned") : say("lesson.state-row", { count, needed });
}
