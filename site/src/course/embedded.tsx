// A round by a link, in a page of its own or in a frame of somebody else's page.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { LESSONS } from "../learn/lessons.js";
import { WithIndex } from "../practice/with-index.js";
import { keepText, keptText, storage } from "../storage.js";
import { LANGUAGES } from "../text/languages.js";
import { type Message, said, say } from "../text/text.js";
import { type Link, readLink, roundOf, writeLink } from "./link.js";
import { parentPage } from "./parent.js";
import type { Recipient } from "./recipient.js";
import type { Round } from "./round.js";
import { RoundView } from "./view.js";

export const Embedded = (): JSX.Element => <WithIndex>{(index) => <AskedRound index={index} />}</WithIndex>;

function AskedRound({ index }: { index: Index }): JSX.Element {
  const [begun] = useState(() => begin(index, window.location.search));
  return "key" in begun ? <Wrong why={begun} /> : <RoundView index={index} {...begun} />;
}

/** What is wrong with a link; whoever gave it out has to fix it. */
function Wrong({ why }: { why: Message }) {
  return (
    <div class="task" role="alert">
      <h2>{say("link.wrong")}</h2>
      <p>{said(why)}</p>
      <p>{say("link.mend")}</p>
    </div>
  );
}

function begin(index: Index, search: string): { round: Round; recipient: Recipient } | Message {
  const asked = readLink(search, Object.keys(LANGUAGES));
  if ("key" in asked) return asked;
  const link = { ...asked, seed: asked.seed || ownSeed(asked) };
  const round = roundOf(link, index, LESSONS);
  if ("key" in round) return round;
  const around = {
    isFramed: window.parent !== window,
    post: (told: unknown, origin: string) => window.parent.postMessage(told, origin),
  };
  const origins = { named: link.origin, own: window.location.origin };
  return { round, recipient: parentPage(around, origins, storage, `qdot-round${nameOf(link)}`) };
}

/** What makes a round what it is: neither who is told of it nor how it is shown. */
const nameOf = (link: Link): string => writeLink({ ...link, embed: false, origin: "", language: "" });

/** The seed of a link that has none: drawn once in this browser, so that the page can be opened again. */
function ownSeed(link: Link): string {
  const key = `qdot-seed${nameOf(link)}`;
  const kept = keptText(storage, key);
  if (kept) return kept;
  const fresh = newSeed();
  keepText(storage, key, fresh);
  return fresh;
}

export const newSeed = (): string => crypto.getRandomValues(new Uint32Array(1))[0]!.toString(36);
