// Send results to the page around an embedded round by postMessage, only to the origin that the link names.

import { nameItem } from "../practice/choice.js";
import { message } from "../text/text.js";
import { storedInBrowser, isComplete, type Report, type Recipient } from "./recipient.js";

/** Longer answers are cut in messages. */
const MAX_CHARACTERS = 4000;

/** What is sent, as docs/site.md describes it; a change that receivers would notice needs another version. */
export type ResultMessage = ReturnType<typeof resultMessage>;

export function resultMessage({ round, standing, score, given }: Report, isFirst: boolean) {
  const { points, max, share, answered, count } = score;
  return {
    qdot: "round" as const,
    version: 1 as const,
    event: isFirst ? "opened" : isComplete(score) ? "completed" : "answered",
    name: round.name,
    seed: round.seed,
    score: { points, max, scaled: share, answered, count },
    answer: given && {
      question: nameItem(round.asked[given.place]!.item),
      number: given.place + 1,
      share: given.verdict.share,
      outcome: given.verdict.outcome,
      tries: standing[given.place]!.tries,
      typed: given.answer.slice(0, MAX_CHARACTERS),
    },
  };
}

/** The surrounding window, as far as results are sent to it. */
export interface SurroundingPage {
  /** Whether the page is in a frame. */
  readonly isFramed: boolean;
  post(message: ResultMessage, origin: string): void;
}

type Origins = { readonly named: string; readonly own: string };

/** Return the surrounding page as recipient, at the named origin or our own; the browser stores the round, too. */
export function parentPage(around: SurroundingPage, origins: Origins, storage: Storage | null, key: string): Recipient {
  let isFirst = true;
  const sentTo = origins.named ? message("round.sent-to", { origin: origins.named }) : message("round.sent-here");
  const stored = storedInBrowser(storage, key, around.isFramed ? sentTo : message("round.not-sent"));
  return {
    ...stored,
    isAccepting: around.isFramed,
    report(current) {
      if (around.isFramed) around.post(resultMessage(current, isFirst), origins.named || origins.own);
      isFirst = false;
      return stored.report(current);
    },
  };
}
