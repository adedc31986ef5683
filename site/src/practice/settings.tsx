// What to practise, and the progress so far.

import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { say } from "../text/text.js";
import { ANYTHING, asLink, isMissed, items, STEPS, variations, WAITS, type Wish } from "./choice.js";
import { type AllKept, asFile, fromFile, merged, NOTHING_KEPT } from "./all-kept.js";
import { sheetLink } from "./sheet.js";

interface SettingsProps {
  readonly index: Index;
  readonly wish: Wish;
  readonly kept: AllKept;
  readonly onWish: (wish: Wish) => void;
  readonly onKept: (all: AllKept) => void;
}

export function Settings(props: SettingsProps): JSX.Element {
  const { index, wish, onWish } = props;
  // only what there is: a question that a family is never asked can't be chosen with it
  const asked = new Set([
    wish.question, // of a link: that it does not go with the arm is said below
    ...items(index, { ...ANYTHING, family: wish.family }).map(({ question }) => question),
  ]);
  const questions = index.questions.filter(({ name }) => asked.has(name));
  const [isOpen, setOpen] = useState(false);
  const group = (short: boolean) => questions.filter(({ form }) => Boolean(form) === short);
  return (
    <form class="settings" onSubmit={(event) => event.preventDefault()}>
      <details class="wish" open={isOpen} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>
          <span class="visually-hidden">{say("practice.wish")}: </span>
          {inShort(index, wish)}
        </summary>
        <div class="choices">
          <label>
            {say("practice.arm")}
            <select
              value={wish.family}
              onChange={(event) => onWish({ ...wish, family: event.currentTarget.value, question: "" })}
            >
              <option value="">{say("practice.any-arm")}</option>
              {index.families.map(({ name, title, lang = "en" }) => (
                <option key={name} value={name} lang={lang}>
                  {title}
                </option>
              ))}
            </select>
          </label>
          <label>
            {say("practice.question")}
            <select
              value={wish.question}
              onChange={(event) => onWish({ ...wish, question: event.currentTarget.value })}
            >
              <option value="">{say("practice.any-question")}</option>
              {[false, true].map((short) =>
                group(short).length > 0 ? (
                  <optgroup key={String(short)} label={say(short ? "practice.short" : "practice.long")}>
                    {group(short).map(({ name, title, lang = "en" }) => (
                      <option key={name} value={name} lang={lang}>
                        {title}
                      </option>
                    ))}
                  </optgroup>
                ) : null,
              )}
            </select>
          </label>
          <label>
            {say("practice.difficulty")}
            <select
              value={wish.difficulty ?? ""}
              onChange={(event) => {
                const value = event.currentTarget.value;
                onWish({ ...wish, difficulty: value === "" ? null : Number(value) });
              }}
            >
              <option value="">{say("practice.any-difficulty")}</option>
              {[0, 1, 2, 3, 4].map((step) => (
                <option key={step} value={step}>
                  {step}
                </option>
              ))}
            </select>
          </label>
          <VariationChoice {...props} />
        </div>
      </details>
      <More {...props} />
    </form>
  );
}

/** A wish in a line: what arm, what question, how difficult. */
function inShort({ families, questions }: Index, wish: Wish): string {
  const arm = families.find(({ name }) => name === wish.family)?.title ?? say("practice.any-arm");
  const question =
    questions.find(({ name }) => name === wish.question)?.title ?? say("practice.any-question");
  const more = [
    wish.difficulty === null ? "" : say("practice.points", { difficulty: wish.difficulty }),
    wish.variation ? variationName(wish.variation) : "",
  ];
  return [arm, question, ...more].filter(Boolean).join(" · ");
}

/** How far arms vary, where the bank has more than one kind. */
function VariationChoice({ index, wish, onWish }: SettingsProps) {
  const known = variations(index);
  if (known.length < 2) return null;
  return (
    <label>
      {say("practice.variation")}
      <select
        value={wish.variation}
        onChange={(event) => onWish({ ...wish, variation: event.currentTarget.value })}
      >
        <option value="">{say("practice.any-variation")}</option>
        {known.map((name) => (
          <option key={name} value={name}>
            {variationName(name)}
          </option>
        ))}
      </select>
    </label>
  );
}

/** A step in words; an instructor's own axes as they are. */
export function variationName(name: string): string {
  const step = STEPS.find((each) => each === name);
  return step ? say(`variation.${step}`) : name.replaceAll("+", ", ");
}

function More({ wish, kept, onWish, onKept }: SettingsProps) {
  const [told, setTold] = useState("");
  const [fresh] = useState(newSet);
  const file = useRef<HTMLInputElement>(null);
  const tried = Object.values(kept.progress);
  const due = tried.filter((each) => isMissed(each) && each.box < WAITS.length - 1).length;
  const load = async () => {
    const found = fromFile((await file.current?.files?.[0]?.text()) ?? "");
    setTold(found ? "" : say("practice.not-progress"));
    if (found) onKept(merged(kept, found));
    if (file.current) file.current.value = ""; // so that the same file may be chosen again
  };
  const save = () => {
    const address = URL.createObjectURL(new Blob([asFile(kept)], { type: "application/json" }));
    const link = Object.assign(document.createElement("a"), {
      href: address,
      download: "qdot-progress.json",
    });
    link.click();
    URL.revokeObjectURL(address);
  };
  const link = `${window.location.origin}${window.location.pathname}${asLink(wish)}`;
  return (
    <details class="more">
      <summary>{say("practice.progress")}</summary>
      <p>
        {say("practice.count", {
          right: tried.filter((each) => each.right).length,
          tried: tried.length,
        })}
        ; {say("practice.due", { count: due })}. {say("practice.kept")}
      </p>
      <p class="actions">
        <button type="button" class="quiet" onClick={save}>
          {say("practice.save")}
        </button>
        <button type="button" class="quiet" onClick={() => file.current?.click()}>
          {say("practice.load")}
        </button>
        <button
          type="button"
          class="quiet"
          onClick={() => {
            if (window.confirm(say("practice.forget-sure"))) onKept(NOTHING_KEPT);
          }}
        >
          {say("practice.forget")}
        </button>
        <a
          class="button quiet"
          href={sheetLink({ ...wish, set: wish.set || fresh }, { count: 4, key: false })}
        >
          {say("sheet.make")}
        </a>
      </p>
      <input
        ref={file}
        class="visually-hidden"
        type="file"
        accept=".json,application/json"
        aria-label={say("practice.load")}
        tabIndex={-1}
        onChange={() => void load()}
      />
      {told ? <p role="alert">{told}</p> : null}
      {wish.set ? (
        <p>
          {say("practice.set-help")} <a href={link}>{link}</a>
        </p>
      ) : (
        <button type="button" class="quiet" onClick={() => onWish({ ...wish, set: fresh })}>
          {say("practice.make-set")}
        </button>
      )}
    </details>
  );
}

function newSet(): string {
  return crypto.getRandomValues(new Uint32Array(1))[0]!.toString(36);
}
