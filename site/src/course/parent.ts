// Results for the page around an embedded round, by postMessage: to the origin that the link names, and to nobody else.

import { nameOf } from "../practice/choice.js";
import { message, type Message } from "../text/text.js";
import { inBrowser, isComplete, type News, type Recipient } from "./recipient.js";

/** What is sent, as docs/site.md tells it; what changes in it for those who read it is another version. */
export interface Told {
  readonly qdot: "round";
  readonly version: 1;
  readonly event: "opened" | "answered" | "completed";
  readonly name: string;
  readonly seed: string;
  readonly score: {
    readonly points: number;
    readonly max: number;
    readonly scaled: number;
    readonly answered: number;
    readonly count: number;
  };
  readonly answer: {
    readonly question: string;
    readonly number: number;
    readonly share: number;
    readonly outcome: string;
    readonly tries: number;
    readonly typed: string;
  } | null;
}

/** Answers longer than that are cut in messages. */
const LONGEST = 4000;

export function toldOf({ round, standing, score, given }: News, isFirst: boolean): Told {
  const { points, max, share, answered, count } = score;
  const event = isFirst ? "opened" : isComplete(score) ? "completed" : "answered";
  return {
    qdot: "round",
    version: 1,
    event,
    name: round.name,
    seed: round.seed,
    score: { points, max, scaled: share, answered, count },
    answer: given && {
      question: nameOf(round.asked[given.place]!.item),
      number: given.place + 1,
      share: given.verdict.share,
      outcome: given.verdict.outcome,
      tries: standing[given.place]!.tries,
      typed: given.answer.slice(0, LONGEST),
    },
  };
}

/** The window around this one, as far as results are sent to it. */
export interface Around {
  /** Whether the page stands in another one. */
  readonly isFramed: boolean;
  post(told: Told, origin: string): void;
}

type Origins = { readonly named: string; readonly own: string };

/** The surrounding page, at the named origin or our own; `storage` stores the round in this browser under `key`. */
export function parentPage(around: Around, origins: Origins, storage: Storage | null, key: string): Recipient {
  let isFirst = true;
  const kept = inBrowser(storage, key, saysOf(around.isFramed, origins.named));
  return {
    ...kept,
    takes: around.isFramed,
    tell(news) {
      if (around.isFramed) around.post(toldOf(news, isFirst), origins.named || origins.own); // there, or not at all
      isFirst = false;
      return kept.tell(news);
    },
  };
}

function saysOf(isFramed: boolean, named: string): Message {
  if (!isFramed) return message("round.not-sent");
  return named ? message("round.sent-to", { origin: named }) : message("round.sent-here");
}
