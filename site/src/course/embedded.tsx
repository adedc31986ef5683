// A round started by a link, on its own page or in a frame of another page.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { LESSONS } from "../learn/lessons.js";
import { WithIndex } from "../practice/with-index.js";
import { makeSeed } from "../random.js";
import { storage, loadText, storeText } from "../storage.js";
import { LANGUAGES } from "../text/languages.js";
import { type Message, textOf, say } from "../text/text.js";
import { type Link, parseLink, makeRound, writeLink } from "./link.js";
import { makePageRecipient } from "./parent.js";
import type { Recipient } from "./recipient.js";
import type { Round } from "./round.js";
import { RoundView } from "./view.js";

export const Embedded = (): JSX.Element => <WithIndex>{(index) => <LinkedRound index={index} />}</WithIndex>;

function LinkedRound({ index }: { index: Index }): JSX.Element {
  const [linkedRound] = useState(() => startRound(index, window.location.search));
  return "key" in linkedRound ? <LinkFault fault={linkedRound} /> : <RoundView index={index} {...linkedRound} />;
}

/** What is wrong with a link, for the instructor who has to fix it. */
function LinkFault({ fault }: { fault: Message }) {
  return (
    <div class="task" role="alert">
      <h2>{say("link.wrong")}</h2>
      <p>{textOf(fault)}</p>
      <p>{say("link.mend")}</p>
    </div>
  );
}

function startRound(index: Index, search: string): { round: Round; recipient: Recipient } | Message {
  const request = parseLink(search, Object.keys(LANGUAGES));
  if ("key" in request) return request;
  const link = { ...request, seed: request.seed || findOrStoreSeed(request) };
  const round = makeRound(link, index, LESSONS);
  if ("key" in round) return round;
  const surroundingPage = {
    isFramed: window.parent !== window,
    post: (current: unknown, origin: string) => window.parent.postMessage(current, origin),
  };
  const origins = { named: link.origin, own: window.location.origin };
  return { round, recipient: makePageRecipient(surroundingPage, origins, storage, `qdot-round${nameRound(link)}`) };
}

/** Return what identifies a round: its link without recipient and appearance. */
const nameRound = (link: Link): string => writeLink({ ...link, embed: false, origin: "", language: "" });

/** Return the seed of a link that has none: chosen once in this browser, so that the page can be opened again. */
function findOrStoreSeed(link: Link): string {
  const key = `qdot-seed${nameRound(link)}`;
  const stored = loadText(storage, key);
  if (stored) return stored;
  const seed = makeSeed();
  storeText(storage, key, seed);
  return seed;
}
