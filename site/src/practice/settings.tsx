// The settings of the practice page, and the progress so far.

import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Index } from "../bank.js";
import { makeSeed } from "../random.js";
import { say } from "../text/text.js";
import { writeWish, needsRepetition, BOX_DELAYS, type Wish } from "./choice.js";
import { type StoredState, writeFile, parseFile, mergeStates, EMPTY_STATE } from "./stored-state.js";
import { writeSheetLink } from "./sheet.js";
import { nameVariation, WishChoices } from "./wish-choices.js";
import { saveFile } from "../pages/copy-button.js";

interface SettingsProps {
  readonly index: Index;
  readonly wish: Wish;
  readonly stored: StoredState;
  readonly onWish: (wish: Wish) => void;
  /** Called with the state from a file, or with an empty one. */
  readonly onRestored: (state: StoredState) => void;
}

export function Settings(props: SettingsProps): JSX.Element {
  const { index, wish, onWish } = props;
  const [isOpen, setOpen] = useState(false);
  return (
    <form class="settings" onSubmit={(event) => event.preventDefault()}>
      <details class="wish" open={isOpen} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>
          <span class="visually-hidden">{say("practice.wish")}: </span>
          {summarizeWish(index, wish)}
        </summary>
        <div class="choices">
          <WishChoices index={index} wish={wish} onWish={onWish} />
        </div>
      </details>
      <More {...props} />
    </form>
  );
}

/** Return a wish in one line: arm, question, difficulty, variation. */
function summarizeWish({ families, questions }: Index, wish: Wish): string {
  const arm = families.find(({ name }) => name === wish.family)?.title ?? say("practice.any-arm");
  const question = questions.find(({ name }) => name === wish.question)?.title ?? say("practice.any-question");
  const details = [
    wish.difficulty === null ? "" : say("practice.points", { difficulty: wish.difficulty }),
    wish.variation ? nameVariation(wish.variation) : "",
  ];
  return [arm, question, ...details].filter(Boolean).join(" · ");
}

function More({ wish, stored, onWish, onRestored }: SettingsProps) {
  const [error, setError] = useState("");
  const [newSetSeed] = useState(makeSeed);
  const fileInput = useRef<HTMLInputElement>(null);
  const itemStates = Object.values(stored.progress);
  const dueCount = itemStates.filter(
    (attempt) => needsRepetition(attempt) && attempt.box < BOX_DELAYS.length - 1,
  ).length;
  const loadFile = async () => {
    const restored = parseFile((await fileInput.current?.files?.[0]?.text()) ?? "");
    setError(restored ? "" : say("practice.not-progress"));
    if (restored) onRestored(mergeStates(stored, restored));
    if (fileInput.current) fileInput.current.value = ""; // so that the same file may be chosen again
  };
  const link = `${window.location.origin}${window.location.pathname}${writeWish(wish)}`;
  return (
    <details class="more">
      <summary>{say("practice.progress")}</summary>
      <p>
        {say("practice.count", {
          right: itemStates.filter((attempt) => attempt.right).length,
          tried: itemStates.length,
        })}
        ; {say("practice.due", { count: dueCount })}. {say("practice.kept")}
      </p>
      <p class="actions">
        <Button
          text={say("practice.save")}
          onClick={() => saveFile("qdot-progress.json", "application/json", writeFile(stored))}
        />
        <Button text={say("practice.load")} onClick={() => fileInput.current?.click()} />
        <Button
          text={say("practice.forget")}
          onClick={() => {
            if (window.confirm(say("practice.forget-sure"))) onRestored(EMPTY_STATE);
          }}
        />
        <a
          class="button quiet"
          href={writeSheetLink({ ...wish, set: wish.set || newSetSeed }, { count: 4, hasKey: false })}
        >
          {say("sheet.make")}
        </a>
      </p>
      <input
        ref={fileInput}
        class="visually-hidden"
        type="file"
        accept=".json,application/json"
        aria-label={say("practice.load")}
        tabIndex={-1}
        onChange={() => void loadFile()}
      />
      {error ? <p role="alert">{error}</p> : null}
      {wish.set ? (
        <p>
          {say("practice.set-help")} <a href={link}>{link}</a>
        </p>
      ) : (
        <Button text={say("practice.make-set")} onClick={() => onWish({ ...wish, set: newSetSeed })} />
      )}
    </details>
  );
}
