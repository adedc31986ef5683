// What is said of an answer: the verdict, where it differs, the mistake, the pose.

import type { JSX } from "preact";
import type { Problem, Row } from "../bank.js";
import { type At, isRead, type Slip, type Verdict } from "../grade/verdict.js";
import { type Message, message, said, say } from "../text/text.js";

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
  /** What comes of it where it was practised. */
  readonly notes?: readonly string[] | undefined;
}

export function Feedback({ problem, verdict, isDrawn, notes = [] }: FeedbackProps): JSX.Element {
  const behind: Slip[] = [...(verdict.slips ?? [])];
  if (verdict.mistake !== undefined) behind.unshift({ mistake: verdict.mistake });
  const told = behind.map((slip, i) => <Behind key={i} problem={problem} slip={slip} />);
  const pose = poseOf(problem, verdict);
  const isTried = isRead(verdict);
  const reasons = isTried ? verdict.reasons : verdict.reasons.filter(({ key }) => key.startsWith("read."));
  const title = isTried || verdict.outcome === "missing" ? TITLES[verdict.outcome] : "practice.unread";
  return (
    <section class={`verdict ${isTried ? verdict.outcome : "missing"}`}>
      <h3>{say(title)}</h3>
      {reasons.map((reason) => (
        <p key={reason.key}>{said(reason)}</p>
      ))}
      {behind.length === 1 ? (
        <p class="mistake">
          <strong>{say("practice.mistake")}</strong> {told[0]}
        </p>
      ) : null}
      {behind.length > 1 ? (
        <div class="mistake">
          <strong>{say("practice.mistakes")}</strong>
          <ul>
            {told.map((each, i) => (
              <li key={i}>{each}</li>
            ))}
          </ul>
        </div>
      ) : null}
      {isTried && verdict.entries && verdict.entries.length * (verdict.entries[0]?.length ?? 0) > 1 ? (
        <Marks entries={verdict.entries} />
      ) : null}
      {isDrawn ? <p>{say("practice.own-columns")}</p> : null}
      {isTried
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

/** What is said of the symbols in a missing factor; if joints change that factor of det J, singularities are lost. */
export function missingIn(symbols: string, ofDeterminant: boolean): Message {
  const what = symbols.replaceAll("theta", "θ");
  const isMoving = ofDeterminant && /theta|d\d/.test(symbols);
  return message(isMoving ? "practice.lost-with-factor" : "practice.missing-in", { what });
}

/** What went wrong; of a mistake what the problem says, in the language of the problem. */
function Behind({ problem, slip }: { problem: Problem; slip: Slip }) {
  if (!("mistake" in slip)) return <>{said(slip)}</>;
  const [name, title, sentence, missing] = problem.said[slip.mistake] ?? [];
  return (
    <>
      {slip.where ? `${said(slip.where)}: ` : null}
      <span lang={problem.lang ?? "en"}>
        <strong>{title}</strong> {sentence}
        {missing ? ` ${said(missingIn(missing, name === "factor-lost"))}` : null}
      </span>
    </>
  );
}

/** Which entries are right, in the shape of the answer. */
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

/** What the variable of a joint is called. */
export const nameOfJoint = ({ kind }: Row, index: number): string => `${kind === "R" ? "theta" : "d"}${index + 1}`;

/** The joint values at which an answer differs, where all joints are told, and it could be read. */
export function poseOf(problem: Problem, verdict: Verdict): At | undefined {
  const { at } = verdict;
  if (!isRead(verdict)) return undefined;
  const joints = problem.robot.joints.map(nameOfJoint);
  return at && joints.every((joint) => at[joint] !== undefined) ? at : undefined;
}
