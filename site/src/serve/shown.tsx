// A result of the server as the verdict that the practice page shows, too.

import type { JSX } from "preact";

import { VerdictBox } from "../practice/feedback.js";
import { Html } from "../practice/math.js";
import { formatRounded, say } from "../text/text.js";
import type { Mark } from "../course/places.js";
import type { Shown } from "./api.js";

const TITLES = {
  correct: "practice.right",
  partial: "practice.partly",
  wrong: "practice.wrong",
  missing: "practice.missing",
  ungraded: "serve.ungraded",
} as const;

/** The mark of a question's place; an answer that follows from an earlier one earns part of the points. */
export const MARKS: Readonly<Record<Shown["outcome"], Mark>> = {
  ...({ correct: "right", partial: "partial", wrong: "wrong" } as const),
  ...({ missing: "open", ungraded: "open" } as const),
};

export const nameOutcome = (outcome: Shown["outcome"]): string => say(TITLES[outcome]);

/** Return points as they are shown; a dash if there are none yet. */
export const writePoints = (points: number | null): string => (points === null ? "–" : formatRounded(points));

/** Return whether a result says more than that there is no answer. */
export const isTelling = ({ outcome, points, comment }: Shown): boolean =>
  outcome !== "missing" || (points ?? 0) > 0 || comment !== "";

interface ShownResultProps {
  readonly shown: Shown;
  /** The number of the part from which the answer follows. */
  readonly followedFrom: string;
  readonly hasPose: boolean;
  /** Whether the answer itself is shown, as it was understood. */
  readonly hasAnswer: boolean;
}

export function ShownResult({ shown, followedFrom, hasPose, hasAnswer }: ShownResultProps): JSX.Element {
  const { outcome, points, max_points, sentences, entries, counterexample, answer, comment } = shown;
  const look = outcome === "ungraded" ? "partial" : outcome;
  return (
    <VerdictBox
      look={look}
      title={`${nameOutcome(outcome)} · ${say("serve.points", { points: writePoints(points), max: max_points })}`}
      reasons={[
        ...(followedFrom ? [say("serve.follows", { number: followedFrom })] : []),
        ...sentences.map((html) => <Html key={html} html={html} />),
      ]}
      entries={entries ?? []}
      hasPose={hasPose}
    >
      {counterexample ? <Html html={counterexample} class="counterexample" /> : null}
      {answer && hasAnswer ? (
        <div class="preview">
          <span class="muted">{say("answer.read-as")}</span> <Html html={answer} />
        </div>
      ) : null}
      {comment ? (
        <p class="verdict-note">
          <strong>{say("serve.comment")}</strong> {comment}
        </p>
      ) : null}
    </VerdictBox>
  );
}
