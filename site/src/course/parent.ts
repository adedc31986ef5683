// Send results to the page around an embedded round by postMessage, only to the origin that the link names.

import { nameItem } from "../practice/choice.js";
import { message } from "../text/text.js";
import { makeBrowserRecipient, isComplete, type Report, type Recipient } from "./recipient.js";

/** Longer answers are cut off in messages. */
const MAX_CHARACTERS = 4000;

/** What is sent, as docs/site.md describes it; a change that receivers would notice needs another version. */
export type ResultMessage = ReturnType<typeof makeResultMessage>;

function makeResultMessage({ round, standing, score, lastAnswer }: Report, isFirst: boolean) {
  const { points, max, share, answered, count } = score;
  return {
    qdot: "round" as const,
    version: 1 as const,
    event: isFirst ? "opened" : isComplete(score) ? "completed" : "answered",
    name: round.name,
    seed: round.seed,
    score: { points, max, scaled: share, answered, count },
    answer: lastAnswer && {
      question: nameItem(round.questions[lastAnswer.place]!.item),
      number: lastAnswer.place + 1,
      share: lastAnswer.verdict.share,
      outcome: lastAnswer.verdict.outcome,
      tries: standing[lastAnswer.place]!.tries,
      typed: lastAnswer.answer.slice(0, MAX_CHARACTERS),
    },
  };
}

/** The surrounding window, as far as results are sent to it. */
interface SurroundingPage {
  /** Whether the page is in a frame. */
  readonly isFramed: boolean;
  post(message: ResultMessage, origin: string): void;
}

/** The origins of the page that the link names ("" if none), and of this page. */
type Origins = { readonly named: string; readonly own: string };

/**
 * Return the surrounding page as recipient, if it has the named origin, else this page's origin. The browser stores the
 * round, too.
 */
export function makePageRecipient(
  page: SurroundingPage,
  origins: Origins,
  storage: Storage | null,
  key: string,
): Recipient {
  let isFirst = true;
  const destination = origins.named ? message("round.sent-to", { origin: origins.named }) : message("round.sent-here");
  const browserRecipient = makeBrowserRecipient(storage, key, page.isFramed ? destination : message("round.not-sent"));
  return {
    ...browserRecipient,
    isAccepting: page.isFramed,
    report(newReport) {
      if (page.isFramed) page.post(makeResultMessage(newReport, isFirst), origins.named || origins.own);
      isFirst = false;
      return browserRecipient.report(newReport);
    },
  };
}
