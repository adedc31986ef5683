// Show the progress in a lesson as dots and in words: one dot for each right answer of the current row.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { currentClass, rowOf, type ClassItems } from "../practice/classes.js";
import { NEEDED, type Row, type Skill } from "../practice/skills.js";

type DotsProps = { readonly skill: Skill; readonly classes: readonly ClassItems[] };

export function Dots({ skill, classes }: DotsProps): JSX.Element | null {
  if (classes.length === 0) return null;
  const at = currentClass(skill, classes, Date.now());
  const row = rowOf(skill, classes, at);
  const full = filled(row);
  const text = classes.length > 1 ? inClass(classes[at]!, row) : rowInWords(row);
  return (
    <span class={`dots${row.mastered !== undefined ? " mastered" : ""}`} title={text}>
      <span aria-hidden="true">{"●".repeat(full) + "○".repeat(NEEDED - full)}</span>
      <span class="visually-hidden">{text}</span>
    </span>
  );
}

const filled = ({ row, learned }: Row): number => (learned !== undefined ? NEEDED : Math.min(row.length, NEEDED));

/** Return the state of a class of arms in words, with its name. */
export const inClass = ({ name }: ClassItems, row: Row): string => `${say(`classes.${name}`)}: ${rowInWords(row)}`;

function rowInWords(row: Row): string {
  if (row.mastered !== undefined) return say("lesson.state-mastered");
  if (row.learned !== undefined) return say("lesson.state-learned");
  return say("lesson.state-row", { count: filled(row), needed: NEEDED });
}
