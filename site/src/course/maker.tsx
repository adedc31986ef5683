// The page on which an instructor makes a link to a round, or a frame for a course page, with a preview.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { Choice, LITERAL, optionsOf } from "../controls.js";
import { listen, useDebounced } from "../scheduling.js";
import { LESSONS } from "../learn/lessons.js";
import { CopyButton } from "../pages/copy-button.js";
import { WishChoices } from "../practice/wish-choices.js";
import { LANGUAGES } from "../text/languages.js";
import { textOf, say, type TextKey } from "../text/text.js";
import { makeSeed } from "../random.js";
import { listCandidates, EMPTY_LINK, isOrigin, type Link, MAX_QUESTIONS, MAX_TRIES, writeLink } from "./link.js";

/** Height of the frame (pixels): enough for arm and question one above the other. */
const FRAME_HEIGHT = 900;

export function Maker({ index }: { index: Index }): JSX.Element {
  const [link, setLink] = useState<Link>(() => ({ ...EMPTY_LINK, seed: makeSeed() }));
  const candidates = listCandidates(link, index, LESSONS);
  const maxCount = "length" in candidates ? Math.min(candidates.length, MAX_QUESTIONS) : 0;
  const count = Math.min(link.wish.count, maxCount);
  const hasWrongOrigin = link.origin !== "" && !isOrigin(link.origin);
  const validLink = { ...link, wish: { ...link.wish, count }, origin: hasWrongOrigin ? "" : link.origin };
  const pageAddress = new URL("practice.html", window.location.href).href;
  return (
    <div class="maker">
      <Choices index={index} link={link} max={maxCount} hasWrongOrigin={hasWrongOrigin} onLink={setLink} />
      {"length" in candidates ? (
        <>
          <p class="muted" role="status">
            {say("maker.there", { count: candidates.length })}
          </p>
          <CopyableText label="maker.link" text={pageAddress + writeLink(validLink)} />
          <CopyableText
            label="maker.frame"
            text={writeFrame(pageAddress + writeLink({ ...validLink, embed: true }), link.name)}
          />
          <Preview link={validLink} />
        </>
      ) : (
        <p role="alert">{textOf(candidates)}</p>
      )}
    </div>
  );
}

/** Return the HTML of a frame for the page of a course. */
function writeFrame(address: string, name: string): string {
  const attributes = { src: address, title: name || say("round.title"), width: "100%", height: FRAME_HEIGHT };
  return Object.assign(document.createElement("iframe"), attributes).outerHTML;
}

interface ChoicesProps {
  readonly index: Index;
  readonly link: Link;
  readonly max: number;
  readonly hasWrongOrigin: boolean;
  readonly onLink: (link: Link) => void;
}

function Choices({ index, link, max, hasWrongOrigin, onLink }: ChoicesProps): JSX.Element {
  const { wish } = link;
  const lesson = LESSONS.find(({ id }) => id === link.lesson);
  const change = (changes: Partial<Link>): void => onLink({ ...link, ...changes });
  return (
    <form class="settings maker-choices" onSubmit={(event) => event.preventDefault()}>
      <Choice
        label="maker.lesson"
        value={link.lesson}
        any="maker.no-lesson"
        onValue={(value) => change({ lesson: value, wish: { ...wish, question: "" } })}
      >
        {optionsOf(LESSONS.map(({ id, title }) => [id, say(title)]))}
      </Choice>
      <WishChoices index={index} wish={wish} lesson={lesson} onWish={(wish) => change({ wish })} />
      <NumberField
        label="maker.count"
        value={wish.count}
        min={1}
        max={max}
        onValue={(count) => change({ wish: { ...wish, count } })}
      />
      <NumberField
        label="maker.tries"
        value={link.tries}
        min={0}
        max={MAX_TRIES}
        onValue={(tries) => change({ tries })}
      />
      <TextField label="maker.name" value={link.name} onValue={(name) => change({ name })} />
      <TextField label="maker.seed" value={link.seed} onValue={(seed) => change({ seed })} />
      <TextField
        label="maker.origin"
        value={link.origin}
        hint="https://moodle.example.org"
        wrong={hasWrongOrigin ? "link.origin" : null}
        onValue={(origin) => change({ origin: origin.trim() })}
      />
      <Choice
        label="page.language"
        value={link.language}
        any="maker.any-language"
        onValue={(language) => change({ language })}
      >
        {optionsOf(Object.entries(LANGUAGES).map(([code, { name }]) => [code, name, code]))}
      </Choice>
    </form>
  );
}

interface NumberFieldProps {
  readonly label: TextKey;
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly onValue: (value: number) => void;
}

function NumberField({ label, value, min, max, onValue }: NumberFieldProps): JSX.Element {
  return (
    <label>
      {say(label)}
      <input
        type="number"
        min={min}
        max={max}
        step={1}
        value={Math.min(value, Math.max(max, min))}
        onChange={(event) => {
          const typed = Math.round(Number(event.currentTarget.value));
          const count = Math.min(Math.max(Number.isFinite(typed) ? typed : min, min), Math.max(max, min));
          event.currentTarget.value = String(count); // the typed number may be out of range
          onValue(count);
        }}
      />
    </label>
  );
}

interface TextFieldProps {
  readonly label: TextKey;
  readonly value: string;
  readonly hint?: string;
  readonly wrong?: TextKey | null;
  readonly onValue: (value: string) => void;
}

function TextField({ label, value, hint = "", wrong = null, onValue }: TextFieldProps): JSX.Element {
  return (
    <label>
      {say(label)}
      <input
        type="text"
        {...LITERAL}
        value={value}
        maxLength={100}
        placeholder={hint}
        aria-invalid={wrong !== null}
        onInput={(event) => onValue(event.currentTarget.value)}
      />
      {wrong ? <span role="alert">{say(wrong, { value })}</span> : null}
    </label>
  );
}

/** A text to be copied: by the button, or by hand if a script may not copy. */
const CopyableText = ({ label, text }: { label: TextKey; text: string }): JSX.Element => (
  <div class="made">
    <label>
      {say(label)}
      <textarea
        readOnly
        rows={3}
        value={text}
        spellcheck={false}
        onFocus={({ currentTarget }) => currentTarget.select()}
      />
    </label>
    <CopyButton key={text} text={text} label={say("maker.copy")} />
  </div>
);

/** Milliseconds without a change after which the preview is loaded again. */
const SETTLING_TIME = 400;

/** The frame as students see it, and the last message that the surrounding page receives. */
function Preview({ link }: { link: Link }): JSX.Element {
  const address = `practice.html${writeLink({ ...link, embed: true, origin: window.location.origin })}`;
  const settledAddress = useDebounced(address, SETTLING_TIME);
  const [lastMessage, setLastMessage] = useState("");
  const frame = useRef<HTMLIFrameElement>(null);
  const receive = ({ origin, source, data }: MessageEvent): void => {
    if (origin === window.location.origin && source === frame.current?.contentWindow)
      setLastMessage(JSON.stringify(data, null, 1));
  };
  useEffect(() => listen(window, "message", receive), []);
  return (
    <section>
      <h2>{say("maker.preview")}</h2>
      <iframe ref={frame} class="maker-preview" src={settledAddress} title={say("maker.preview")} />
      <details>
        <summary>{say("maker.told")}</summary>
        <pre tabIndex={0}>
          <code>{lastMessage || say("maker.nothing-told")}</code>
        </pre>
      </details>
    </section>
  );
}
