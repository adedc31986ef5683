// A round on the page: what is asked, how one stands, and what is sent of it.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import type { Index } from "../bank.js";
import { Current } from "../practice/current.js";
import { inDigits, message, type Message, said, say } from "../text/text.js";
import { type Given, isComplete, isPassed, type News, type Recipient } from "./recipient.js";
import {
  answered,
  fromText,
  isDone,
  isLastTry,
  nextPlace,
  type Round,
  type Score,
  scoreOf,
  shownIn,
  type Standing,
  type Tried,
} from "./round.js";

type RoundViewProps = { readonly index: Index; readonly round: Round; readonly recipient: Recipient };

export function RoundView({ index, round, recipient }: RoundViewProps): JSX.Element {
  const [standing, setStanding] = useState<Standing>(() => fromText(round, recipient.kept));
  const [{ place, visits }, setPlace] = useState({ place: nextPlace(round, standing, -1) ?? 0, visits: 0 });
  const [isSent, setSent] = useState(true);
  const latest = useRef<Standing>(standing);
  const newsOf = (now: Standing, given: Given | null): News => ({
    round,
    standing: now,
    score: scoreOf(round, now),
    given,
  });
  const tell = (now: Standing, given: Given | null): void => {
    latest.current = now;
    setStanding(now);
    setSent(recipient.tell(newsOf(now, given)));
  };
  useEffect(() => {
    tell(standing, null);
    const leave = () => recipient.leave(newsOf(latest.current, null));
    const back = ({ persisted }: PageTransitionEvent) => persisted && window.location.reload(); // it was left for good
    window.addEventListener("pagehide", leave);
    window.addEventListener("pageshow", back);
    return () => {
      window.removeEventListener("pagehide", leave);
      window.removeEventListener("pageshow", back);
    };
  }, []);
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
        sending={isSent ? recipient.says : message("round.failed")}
        onAgain={isSent ? null : () => tell(latest.current, null)}
      />
      <Current
        key={`${place} ${visits}`}
        item={asked.item}
        level={index.feedback}
        judgedAt={isLastTry(round, tried) ? "solutions" : "counterexample"}
        arrived={visits > 0}
        closed={isDone(round, tried)}
        factored={false} // another question may ask for them
        onVerdict={(_, __, judged) => {
          const now = answered(round, latest.current, place, judged.verdict.share);
          if (now !== latest.current) tell(now, { place, ...judged });
        }}
        onSolution={() => {
          if (!isDone(round, latest.current[place]!)) tell(shownIn(latest.current, place), null);
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
  readonly sending: Message;
  readonly onPlace: (place: number) => void;
  readonly onAgain: (() => void) | null;
}

/** What the round is called, how one stands, its questions to go to, and what is sent. */
function Head({ round, standing, place, sending, onPlace, onAgain }: HeadProps): JSX.Element {
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
          {isComplete(score) ? <strong>{said(over(round, score))} </strong> : null}
          {said(sending)} {onAgain ? <Button style="quiet small" text={say("round.again")} onClick={onAgain} /> : null}
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

/** How a question stands, as it is marked: never by its colour alone. */
function markOf(round: Round, tried: Tried): keyof typeof STATES {
  if (tried.share === 1) return "right";
  if (tried.share > 0) return "partial";
  return tried.tries > 0 || isDone(round, tried) ? "wrong" : "open";
}

/** What is said when all were answered. */
function over(round: Round, score: Score): Message {
  const passed = isPassed(round, score);
  if (passed === null) return message("round.over");
  return message(passed ? "round.passed" : "round.not-passed", { percent: rounded(100 * round.pass!) });
}

function triesLeft(round: Round, tried: Tried): string {
  if (tried.share === 1) return say("round.closed-right");
  if (tried.shown) return say("round.closed-shown");
  if (round.tries === 0) return say("round.tries-any");
  return say("round.tries-left", { count: Math.max(round.tries - tried.tries, 0), all: round.tries });
}

const rounded = (value: number): string => inDigits(Math.round(value * 100) / 100);
