// How far a lesson is, as dots and in words: a dot for each right answer of the row.

import type { JSX } from "preact";

import { message, said } from "../text/text.js";
import { NEEDED, type Skill } from "./skills.js";

export function Dots({ skill }: { skill: Skill }): JSX.Element {
  const isLearned = skill.learned !== undefined;
  const full = isLearned ? NEEDED : Math.min(skill.row.length, NEEDED);
  const text =
    skill.mastered !== undefined
      ? said(message("lesson.state-mastered"))
      : isLearned
        ? said(message("lesson.state-learned"))
        : said(message("lesson.state-row", { count: full, needed: NEEDED }));
  return (
    <span class={`dots${skill.mastered !== undefined ? " mastered" : ""}`} title={text}>
      <span aria-hidden="true">{"●".repeat(full) + "○".repeat(NEEDED - full)}</span>
      <span class="visually-hidden">{text}</span>
    </span>
  );
}
