// The choices of what to practise: arm, question, difficulty, variation of the arms.

import type { JSX } from "preact";

import type { Index, Question } from "../bank.js";
import { Choice, type Option, optionsOf } from "../controls.js";
import { say } from "../text/text.js";
import { ANY_WISH, listItems, VARIATION_STEPS, listVariations, type Wish } from "./choice.js";
import type { Topic } from "./topics.js";

interface WishChoicesProps {
  readonly index: Index;
  readonly wish: Wish;
  /** The lesson whose questions can be chosen; undefined for all questions. */
  readonly lesson?: Topic | undefined;
  readonly onWish: (wish: Wish) => void;
}

export function WishChoices({ index, wish, lesson, onWish }: WishChoicesProps): JSX.Element {
  // offer only questions that the bank asks about this family
  const offeredNames = new Set([
    wish.question, // a link may name a question that the arm does not have; an error is shown below
    ...listItems(index, { ...ANY_WISH, family: wish.family }).map(({ question }) => question),
  ]);
  const questions = index.questions.filter(
    ({ name }) => offeredNames.has(name) && (!lesson || lesson.questions.includes(name)),
  );
  const groups = [
    { label: say("practice.long"), members: questions.filter(({ form }) => !form) },
    { label: say("practice.short"), members: questions.filter(({ form }) => form) },
  ].filter(({ members }) => members.length > 0);
  const variations = listVariations(index);
  const change = (changed: Partial<Wish>): void => onWish({ ...wish, ...changed });
  return (
    <>
      <Choice
        label="practice.arm"
        value={wish.family}
        any={lesson ? "maker.lesson-arms" : "practice.any-arm"}
        onValue={(family) => change({ family, question: "" })}
      >
        {optionsOf(index.families.map(makeOption))}
      </Choice>
      <Choice
        label="practice.question"
        value={wish.question}
        any={lesson ? "maker.lesson-questions" : "practice.any-question"}
        onValue={(question) => change({ question })}
      >
        {groups.map(({ label, members }) => (
          <optgroup key={label} label={label}>
            {optionsOf(members.map(makeOption))}
          </optgroup>
        ))}
      </Choice>
      <Choice
        label="practice.difficulty"
        value={String(wish.difficulty ?? "")}
        any="practice.any-difficulty"
        onValue={(value) => change({ difficulty: value === "" ? null : Number(value) })}
      >
        {optionsOf([0, 1, 2, 3, 4].map((step) => [step, String(step)]))}
      </Choice>
      {variations.length > 1 ? (
        <Choice
          label="practice.variation"
          value={wish.variation}
          any="practice.any-variation"
          onValue={(variation) => change({ variation })}
        >
          {optionsOf(variations.map((name) => [name, nameVariation(name)]))}
        </Choice>
      ) : null}
    </>
  );
}

const makeOption = ({ name, title, lang = "en" }: Omit<Question, "form" | "source">): Option => [name, title, lang];

/** Return the name of a variation step; an instructor's own axes as they are. */
export function nameVariation(name: string): string {
  const step = VARIATION_STEPS.find((known) => known === name);
  return step ? say(`variation.${step}`) : name.replaceAll("+", ", ");
}
