// A round on the page: its questions, the score so far, and what is sent.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Index } from "../bank.js";
import { Current } from "../practice/current.js";
import { listen } from "../scheduling.js";
import { inDigits, message, type Message, textOf, say } from "../text/text.js";
import { type JudgedAnswer, isComplete, isPassed, type Report, type Recipient } from "./recipient.js";
import {
  afterAnswer,
  afterSolution,
  fromText,
  isDone,
  isLastTry,
  nextPlace,
  type Round,
  type Score,
  scoreOf,
  type Standing,
  type QuestionState,
} from "./round.js";

type RoundViewProps = { readonly index: Index; readonly round: Round; readonly recipient: Recipient };

export function RoundView({ index, round, recipient }: RoundViewProps): JSX.Element {
  const [standing, setStanding] = useState<Standing>(() => fromText(round, recipient.stored));
  const [{ place, visits }, setPlace] = useState({ place: nextPlace(round, standing, -1) ?? 0, visits: 0 });
  const [isSent, setSent] = useState(true);
  const latest = useRef<Standing>(standing);
  const reportOf = (now: Standing, given: JudgedAnswer | null): Report => {
    return { round, standing: now, score: scoreOf(round, now), given };
  };
  const report = (now: Standing, given: JudgedAnswer | null): void => {
    latest.current = now;
    setStanding(now);
    setSent(recipient.report(reportOf(now, given)));
  };
  useEffect(() => {
    report(standing, null);
    return listen(window, "pagehide", () => recipient.leave(reportOf(latest.current, null)));
  }, []);
  const reload = ({ persisted }: PageTransitionEvent) => persisted && window.location.reload(); // the session has ended
  useEffect(() => listen(window, "pageshow", reload), []);
  const go = (to: number): void => setPlace({ place: to, visits: visits + 1 });
  const asked = round.asked[place]!;
  const tried = standing[place]!;
  return (
    <div class="workspace">
      <Head
        round={round}
        standing={standing}
        place={place}
        onPlace={go}
        destination={isSent ? recipient.destination : message("round.failed")}
        onAgain={isSent ? null : () => report(latest.current, null)}
      />
      <Current
        key={`${place} ${visits}`}
        item={asked.item}
        level={index.feedback}
        judgedAt={isLastTry(round, tried) ? "solutions" : "counterexample"}
        hasArrived={visits > 0}
        isClosed={isDone(round, tried)}
        mayShowFactors={false} // another question may ask for the factors
        onVerdict={(_, __, judged) => {
          const now = afterAnswer(round, latest.current, place, judged.verdict.share);
          if (now !== latest.current) report(now, { place, ...judged });
        }}
        onSolution={() => {
          if (!isDone(round, latest.current[place]!)) report(afterSolution(latest.current, place), null);
        }}
        onNext={() => go(nextPlace(round, latest.current, place) ?? (place + 1) % round.asked.length)}
      />
    </div>
  );
}

interface HeadProps {
  readonly round: Round;
  readonly standing: Standing;
  readonly place: number;
  readonly destination: Message;
  readonly onPlace: (place: number) => void;
  readonly onAgain: (() => void) | null;
}

/** The round's name, the score so far, links to its questions, and where results go. */
function Head({ round, standing, place, destination, onPlace, onAgain }: HeadProps): JSX.Element {
  const score = scoreOf(round, standing);
  return (
    <section class="choosing round" aria-label={round.name || say("round.title")}>
      <p class="round-head">
        {round.name ? <strong>{round.name}</strong> : null}
        <span>{say("round.done", { done: score.answered, count: score.count })}</span>
        <span>{say("round.points", { points: rounded(score.points), max: score.max })}</span>
      </p>
      <ol class="round-places">
        {round.asked.map((_, i) => (
          <li key={i}>
            <button
              type="button"
              class={markOf(round, standing[i]!)}
              aria-current={i === place ? "true" : undefined}
              aria-label={say("round.place", { number: i + 1, state: message(STATES[markOf(round, standing[i]!)]) })}
              onClick={() => onPlace(i)}
            >
              {i + 1}
            </button>
          </li>
        ))}
      </ol>
      <p class="muted">
        <span class="round-tries">{triesLeft(round, standing[place]!)}</span>{" "}
        <span role="status">
          {isComplete(score) ? <strong>{textOf(finalMessage(round, score))} </strong> : null}
          {textOf(destination)}{" "}
          {onAgain ? <Button style="quiet small" text={say("round.again")} onClick={onAgain} /> : null}
        </span>
      </p>
    </section>
  );
}

const STATES = {
  open: "round.open",
  right: "practice.right",
  partial: "practice.partly",
  wrong: "practice.wrong",
} as const;

/** Return how a question is marked: by a text as well as a colour. */
function markOf(round: Round, tried: QuestionState): keyof typeof STATES {
  if (tried.share === 1) return "right";
  if (tried.share > 0) return "partial";
  return tried.tries > 0 || isDone(round, tried) ? "wrong" : "open";
}

/** Return the sentence after all questions were answered. */
function finalMessage(round: Round, score: Score): Message {
  const passed = isPassed(round, score);
  if (passed === null) return message("round.over");
  return message(passed ? "round.passed" : "round.not-passed", { percent: rounded(100 * round.pass!) });
}

function triesLeft(round: Round, tried: QuestionState): string {
  if (tried.share === 1) return say("round.closed-right");
  if (tried.shown) return say("round.closed-shown");
  if (round.tries === 0) return say("round.tries-any");
  return say("round.tries-left", { count: Math.max(round.tries - tried.tries, 0), all: round.tries });
}

const rounded = (value: number): string => inDigits(Math.round(value * 100) / 100);
