// A round on the page: its questions, the score so far, and what is sent.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Index } from "../bank.js";
import { Current } from "../practice/current.js";
import { listen } from "../scheduling.js";
import { formatRounded, message, type Message, textOf, say } from "../text/text.js";
import { type Mark, Places } from "./places.js";
import { type JudgedAnswer, isComplete, isPassed, type Report, type Recipient } from "./recipient.js";
import type { Round, Score, Standing, QuestionState } from "./round.js";
import { addAnswer, closeQuestion, parseStanding, isDone, isLastTry, findNextPlace, computeScore } from "./round.js";

type RoundViewProps = { readonly index: Index; readonly round: Round; readonly recipient: Recipient };

export function RoundView({ index, round, recipient }: RoundViewProps): JSX.Element {
  const [standing, setStanding] = useState<Standing>(() => parseStanding(round, recipient.stored));
  const [{ place, visits }, setPlace] = useState({ place: findNextPlace(round, standing, -1) ?? 0, visits: 0 });
  const [isSent, setSent] = useState(true);
  const latestStanding = useRef<Standing>(standing);
  const makeReport = (newStanding: Standing, lastAnswer: JudgedAnswer | null): Report => {
    return { round, standing: newStanding, score: computeScore(round, newStanding), lastAnswer };
  };
  const report = (newStanding: Standing, lastAnswer: JudgedAnswer | null): void => {
    latestStanding.current = newStanding;
    setStanding(newStanding);
    setSent(recipient.report(makeReport(newStanding, lastAnswer)));
  };
  useEffect(() => {
    report(standing, null);
    return listen(window, "pagehide", () => recipient.leave(makeReport(latestStanding.current, null)));
  }, []);
  const reload = ({ persisted }: PageTransitionEvent) => persisted && window.location.reload(); // the session has ended
  useEffect(() => listen(window, "pageshow", reload), []);
  const goTo = (newPlace: number): void => setPlace({ place: newPlace, visits: visits + 1 });
  const question = round.questions[place]!;
  const state = standing[place]!;
  return (
    <div class="workspace">
      <Head
        round={round}
        standing={standing}
        place={place}
        onPlace={goTo}
        destination={isSent ? recipient.destination : message("round.failed")}
        onAgain={isSent ? null : () => report(latestStanding.current, null)}
      />
      <Current
        key={`${place} ${visits}`}
        item={question.item}
        level={index.feedback}
        maxLevel={isLastTry(round, state) ? "solutions" : "counterexample"}
        hasArrived={visits > 0}
        isClosed={isDone(round, state)}
        mayShowFactors={false} // another question may ask for the factors
        onVerdict={(_, __, judged) => {
          const newStanding = addAnswer(round, latestStanding.current, place, judged.verdict.share);
          if (newStanding !== latestStanding.current) report(newStanding, { place, ...judged });
        }}
        onSolution={() => {
          if (!isDone(round, latestStanding.current[place]!))
            report(closeQuestion(latestStanding.current, place), null);
        }}
        onNext={() => goTo(findNextPlace(round, latestStanding.current, place) ?? (place + 1) % round.questions.length)}
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
  const score = computeScore(round, standing);
  return (
    <section class="choosing round" aria-label={round.name || say("round.title")}>
      <p class="round-head">
        {round.name ? <strong>{round.name}</strong> : null}
        <span>{say("round.done", { done: score.answered, count: score.count })}</span>
        <span>{say("round.points", { points: formatRounded(score.points), max: score.max })}</span>
      </p>
      <Places
        places={round.questions.map((_, i) => ({ number: String(i + 1), mark: findMark(round, standing[i]!) }))}
        place={place}
        onPlace={onPlace}
      />
      <p class="muted">
        <span class="round-tries">{describeTriesLeft(round, standing[place]!)}</span>{" "}
        <span role="status">
          {isComplete(score) ? <strong>{textOf(makeFinalMessage(round, score))} </strong> : null}
          {textOf(destination)}{" "}
          {onAgain ? <Button className="quiet small" text={say("round.again")} onClick={onAgain} /> : null}
        </span>
      </p>
    </section>
  );
}

function findMark(round: Round, state: QuestionState): Mark {
  if (state.share === 1) return "right";
  if (state.share > 0) return "partial";
  return state.tries > 0 || isDone(round, state) ? "wrong" : "open";
}

/** Return the sentence after all questions were answered. */
function makeFinalMessage(round: Round, score: Score): Message {
  const passed = isPassed(round, score);
  if (passed === null) return message("round.over");
  return message(passed ? "round.passed" : "round.not-passed", { percent: formatRounded(100 * round.passShare!) });
}

function describeTriesLeft(round: Round, state: QuestionState): string {
  if (state.share === 1) return say("round.closed-right");
  if (state.shown) return say("round.closed-shown");
  if (round.tries === 0) return say("round.tries-any");
  return say("round.tries-left", { count: Math.max(round.tries - state.tries, 0), all: round.tries });
}
