// The feedback on an answer: the verdict, where the answer differs, the likely mistakes, and a pose to look at.

import type { ComponentChildren, JSX } from "preact";
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

/** The feedback on an answer that was judged by its key. */
export function Feedback({ problem, verdict, isDrawn, notes = [] }: FeedbackProps): JSX.Element {
  const slips: Slip[] = [...(verdict.slips ?? [])];
  if (verdict.mistake !== undefined) slips.unshift({ mistake: verdict.mistake });
  const isAnswer = isParsed(verdict);
  const reasons = isAnswer ? verdict.reasons : verdict.reasons.filter(({ key }) => key.startsWith("read."));
  const title = isAnswer || verdict.outcome === "missing" ? TITLES[verdict.outcome] : "practice.unread";
  return (
    <VerdictBox
      look={isAnswer ? verdict.outcome : "missing"}
      title={say(title)}
      reasons={reasons.map((reason) => (
        <Words key={reason.key} text={textOf(reason)} />
      ))}
      mistakes={slips.map((slip, i) => (
        <SlipText key={i} problem={problem} slip={slip} />
      ))}
      entries={(isAnswer && verdict.entries?.map((row) => row.map((isRight) => (isRight ? "right" : "wrong")))) || []}
      hasPose={findPose(problem, verdict) !== undefined}
    >
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
    </VerdictBox>
  );
}

/** The state of an entry of an answer; "follows": right, given the student's own earlier answer. */
export type EntryState = "right" | "follows" | "blank" | "wrong";

interface VerdictBoxProps {
  readonly look: "correct" | "partial" | "wrong" | "missing";
  readonly title: string;
  readonly reasons: readonly ComponentChildren[];
  /** What seems to be wrong. */
  readonly mistakes?: readonly JSX.Element[];
  /** The states of the answer's entries, in rows. */
  readonly entries?: readonly (readonly EntryState[])[];
  /** Whether the arm shows a pose in which the answer is wrong. */
  readonly hasPose?: boolean;
  readonly children?: ComponentChildren;
}

/** The verdict on an answer, from a key or from the server. */
export function VerdictBox(props: VerdictBoxProps): JSX.Element {
  const { look, title, reasons, mistakes = [], entries = [], hasPose = false, children } = props;
  return (
    <section class={`verdict ${look}`}>
      <h3>{title}</h3>
      {reasons.map((reason, i) => (
        <p key={i}>{reason}</p>
      ))}
      {mistakes.length === 1 ? (
        <p class="mistake">
          <strong>{say("practice.mistake")}</strong> {mistakes[0]}
        </p>
      ) : null}
      {mistakes.length > 1 ? (
        <div class="mistake">
          <strong>{say("practice.mistakes")}</strong>
          <ul>
            {mistakes.map((text, i) => (
              <li key={i}>{text}</li>
            ))}
          </ul>
        </div>
      ) : null}
      {entries.length * (entries[0]?.length ?? 0) > 1 ? <Marks entries={entries} /> : null}
      {children}
      {hasPose ? (
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

/** The sign and the name of each state of an entry. */
const ENTRY_STATES = {
  right: ["✓", "practice.right"],
  follows: ["↪", "practice.follows"],
  blank: ["–", "practice.missing"],
  wrong: ["✗", "practice.wrong"],
} as const;

/** Which entries are right, as a table in the shape of the answer. */
function Marks({ entries }: { entries: readonly (readonly EntryState[])[] }) {
  return (
    <table class="marks">
      <tbody>
        {entries.map((row, r) => (
          <tr key={r}>
            {row.map((state, c) => (
              <td key={c} class={state}>
                {ENTRY_STATES[state][0]}
                <span class="visually-hidden">{say(ENTRY_STATES[state][1])}</span>
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
