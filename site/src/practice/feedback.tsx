// The feedback on an answer: the verdict, where the answer differs, the likely mistakes, and a pose to look at.

import type { JSX } from "preact";
import { Words } from "../arm/letters.js";
import { nameJoint, type Problem } from "../bank.js";
import { isParsed, type Slip, type Verdict } from "../grade/verdict.js";
import type { SymbolValues } from "../read/tree.js";
import { type Message, message, say, textOf, withGreek } from "../text/text.js";

const TITLES = {
  correct: "practice.right",
  partial: "practice.partly",
  wrong: "practice.wrong",
  missing: "practice.missing",
} as const;

interface FeedbackProps {
  readonly problem: Problem;
  readonly verdict: Verdict;
  /** Whether the columns of the answer are drawn beside the true ones. */
  readonly isDrawn: boolean;
  /** Sentences on what the answer changes in the student's progress. */
  readonly notes?: readonly string[] | undefined;
}

export function Feedback({ problem, verdict, isDrawn, notes = [] }: FeedbackProps): JSX.Element {
  const slips: Slip[] = [...(verdict.slips ?? [])];
  if (verdict.mistake !== undefined) slips.unshift({ mistake: verdict.mistake });
  const slipTexts = slips.map((slip, i) => <SlipText key={i} problem={problem} slip={slip} />);
  const pose = findPose(problem, verdict);
  const isAnswer = isParsed(verdict);
  const reasons = isAnswer ? verdict.reasons : verdict.reasons.filter(({ key }) => key.startsWith("read."));
  const title = isAnswer || verdict.outcome === "missing" ? TITLES[verdict.outcome] : "practice.unread";
  return (
    <section class={`verdict ${isAnswer ? verdict.outcome : "missing"}`}>
      <h3>{say(title)}</h3>
      {reasons.map((reason) => (
        <p key={reason.key}>
          <Words text={textOf(reason)} />
        </p>
      ))}
      {slips.length === 1 ? (
        <p class="mistake">
          <strong>{say("practice.mistake")}</strong> {slipTexts[0]}
        </p>
      ) : null}
      {slips.length > 1 ? (
        <div class="mistake">
          <strong>{say("practice.mistakes")}</strong>
          <ul>
            {slipTexts.map((text, i) => (
              <li key={i}>{text}</li>
            ))}
          </ul>
        </div>
      ) : null}
      {isAnswer && verdict.entries && verdict.entries.length * (verdict.entries[0]?.length ?? 0) > 1 ? (
        <Marks entries={verdict.entries} />
      ) : null}
      {isDrawn ? (
        <p>
          <Words text={say("practice.own-columns")} />
        </p>
      ) : null}
      {isAnswer
        ? notes.map((note) => (
            <p key={note} class="verdict-note">
              {note}
            </p>
          ))
        : null}
      {pose ? (
        <p>
          <a href="#arm">{say("practice.pose")}</a>
        </p>
      ) : null}
    </section>
  );
}

/** Return the message on a missing factor with these symbols; a factor of det J with joints has singularities. */
export function describeMissingFactor(symbols: string, isOfDeterminant: boolean): Message {
  const isMoving = isOfDeterminant && /theta|d\d/.test(symbols);
  return message(isMoving ? "practice.lost-with-factor" : "practice.missing-in", { what: withGreek(symbols) });
}

/** A mistake in words; a known mistake is described in the problem's language. */
function SlipText({ problem, slip }: { problem: Problem; slip: Slip }) {
  if (!("mistake" in slip)) return <Words text={textOf(slip)} />;
  const [name, title, sentence, missing] = problem.said[slip.mistake] ?? [];
  return (
    <>
      {slip.where ? `${textOf(slip.where)}: ` : null}
      <span lang={problem.lang ?? "en"}>
        <strong>{title}.</strong> <Words text={sentence ?? ""} />
        {missing ? ` ${textOf(describeMissingFactor(missing, name === "factor-lost"))}` : null}
      </span>
    </>
  );
}

/** Which entries are right, as a table in the shape of the answer. */
function Marks({ entries }: { entries: readonly (readonly boolean[])[] }) {
  return (
    <table class="marks">
      <tbody>
        {entries.map((row, r) => (
          <tr key={r}>
            {row.map((right, c) => (
              <td key={c} class={right ? "right" : "wrong"}>
                {right ? "✓" : "✗"}
                <span class="visually-hidden">{say(right ? "practice.right" : "practice.wrong")}</span>
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** Return the pose at which an answer differs; undefined if the verdict has no complete pose. */
export function findPose(problem: Problem, verdict: Verdict): SymbolValues | undefined {
  const { counterexample } = verdict;
  if (!isParsed(verdict)) return undefined;
  const joints = problem.robot.joints.map(nameJoint);
  return counterexample && joints.every((joint) => counterexample[joint] !== undefined) ? counterexample : undefined;
}
