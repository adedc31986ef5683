// A form by which the staff set points with a comment: for a student's part or total, or for a group.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import { Button, Field } from "../controls.js";
import { describeLoadError } from "../scheduling.js";
import { formatRounded, say } from "../text/text.js";
import { formatTime, writeLocalTime } from "../text/times.js";
import { type ClassStudent, type Override, post, Refused, type Target } from "./api.js";

/** Return in a sentence why a request failed; `unsent` is the sentence if the server wasn't reached. */
export const describeFailure = (reason: unknown, unsent = describeLoadError(reason)): string =>
  reason instanceof Refused ? reason.message || say("serve.refused") : unsent;

/** Return a function that sends something, whether it is on its way, and the error of the last try in a sentence. */
export function useSending(onDone: () => void, unsent?: string) {
  const [isSending, setSending] = useState(false);
  const [error, setError] = useState("");
  const send = async (work: () => Promise<unknown>): Promise<boolean> => {
    if (isSending) return false;
    setSending(true);
    setError("");
    try {
      await work();
      onDone();
      return true;
    } catch (reason) {
      setError(describeFailure(reason, unsent));
      return false;
    } finally {
      setSending(false);
    }
  };
  return { send, isSending, error, setError };
}

interface PointsFormProps {
  readonly target: Target;
  readonly max: number;
  /** The present points and comment. */
  readonly points: number | null;
  readonly comment?: string;
  readonly onSaved: () => void;
}

/** Read points as they are typed, with a point or a comma; null for an empty field, NaN for anything else. */
export const readPoints = (text: string): number | null => {
  const typed = text.trim().replace(",", ".");
  return typed === "" ? null : /^\d*\.?\d+$|^\d+\.$/.test(typed) ? Number(typed) : NaN;
};

export function PointsForm(props: PointsFormProps): JSX.Element {
  const { target, max, comment = "", onSaved } = props;
  const [points, setPoints] = useState("");
  const [text, setText] = useState(comment);
  const [isSaved, setSaved] = useState(false);
  const [problem, setProblem] = useState("");
  const { send, isSending, error } = useSending(onSaved);
  const save = async () => {
    const number = readPoints(points);
    const isValid = number === null || (number >= 0 && number <= max);
    setProblem(isValid ? "" : say("class.points-wrong", { max }));
    const override: Override = { ...target, points: number, comment: text.trim() };
    setSaved(isValid && (await send(() => post("overrides", override))));
  };
  return (
    <form
      class="points-form"
      onSubmit={(event) => {
        event.preventDefault();
        void save();
      }}
    >
      <Field
        label={say("class.points", { max })}
        inputMode="decimal"
        placeholder={props.points === null ? "" : formatRounded(props.points)}
        value={points}
        onValue={setPoints}
      />
      <Field label={say("class.comment")} value={text} onValue={setText} />
      <button type="submit" class="quiet small" disabled={isSending}>
        {say("class.save")}
      </button>
      <span role="status" class="muted">
        {isSaved ? say("class.saved") : ""}
      </span>
      {problem || error ? <span role="alert">{problem || error}</span> : null}
    </form>
  );
}

type ExtensionProps = {
  readonly student: ClassStudent;
  readonly classDue: string | null;
  readonly onSaved: () => void;
};

/** A form for the due date of one student, in the reader's time zone. */
export function ExtensionForm({ student, classDue, onSaved }: ExtensionProps): JSX.Element {
  const { id: number, due } = student;
  const [value, setValue] = useState(due ? writeLocalTime(new Date(due)) : "");
  const { send, isSending, error } = useSending(onSaved);
  const save = (newDue: string | null) => void send(() => post("extensions", { student: number, due: newDue }));
  return (
    <form
      class="points-form"
      onSubmit={(event) => {
        event.preventDefault();
        if (value) save(new Date(value).toISOString());
      }}
    >
      <Field label={say("class.extension")} type="datetime-local" value={value} onValue={setValue} />
      <button type="submit" class="quiet small" disabled={isSending || !value}>
        {say("class.save")}
      </button>
      {due ? <Button className="quiet small" text={say("class.no-extension")} onClick={() => save(null)} /> : null}
      {classDue && value && new Date(value) < new Date(classDue) ? (
        <strong role="status">{say("class.extension-early", { time: formatTime(classDue) })}</strong>
      ) : null}
      {error ? <span role="alert">{error}</span> : null}
    </form>
  );
}
