// Work in a notebook: take it away, submit the file, follow it through the queue.

import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

import { DropField } from "../check/drop-field.js";
import { Warning } from "../controls.js";
import { useInterval } from "../scheduling.js";
import { say } from "../text/text.js";
import { get, makeRequestId, post, type Queued, type Submission, type Work } from "./api.js";
import { describeFailure, useSending } from "./points-form.js";
import { writePoints } from "./shown.js";
import { formatTime } from "../text/times.js";

/** How often the state of a submission in the queue is asked for, in milliseconds. */
const LOOK_WAIT = 2000;
/** The largest file that is sent, in megabytes; the server has the last word. */
const MAX_MEGABYTES = 20;

interface NotebookWorkProps {
  readonly work: Work;
  /** Called when a notebook has been graded. */
  readonly onGraded: () => void;
}

export function NotebookWork({ work, onGraded }: NotebookWorkProps): JSX.Element {
  const [own, setOwn] = useState<readonly Submission[]>([]); // submitted on this page
  const { send, isSending, error, setError } = useSending(() => undefined, say("serve.not-sent"));
  const [asked, setAsked] = useState<File | null>(null); // whether it may replace the answers
  const unsent = useRef<{ readonly file: File; readonly id: string } | null>(null);
  const isKnown = ({ id }: Submission) => own.some((other) => other.id === id);
  const submissions = [...work.submissions.filter((one) => !isKnown(one)), ...own].filter(
    ({ kind }) => kind === "notebook",
  );
  const isWaiting = submissions.some(({ state }) => state === "waiting");
  const submit = async (file: File): Promise<void> => {
    setAsked(null);
    // the same file that is sent again after a lost connection keeps its number
    const isAgain = unsent.current?.file.name === file.name && unsent.current.file.lastModified === file.lastModified;
    if (!isAgain) unsent.current = { file, id: makeRequestId() };
    const form = new FormData();
    form.append("request", unsent.current!.id);
    form.append("file", file, file.name);
    const { submission, place } = await post<Queued>("notebooks", form);
    unsent.current = null;
    const common = { kind: "notebook", part: "", file_name: file.name, state: "waiting" } as const;
    const added = { ...common, id: submission, received: new Date().toISOString(), place, score: null, note: "" };
    setOwn((old) => [...old.filter(({ id }) => id !== submission), added]);
  };
  const [isOpen, setOpen] = useState(isWaiting);
  const look = () => {
    for (const waiting of submissions.filter(({ state }) => state === "waiting"))
      get<Submission>(`submissions/${waiting.id}`).then(
        (news) => {
          setOwn((old) => [...old.filter(({ id }) => id !== waiting.id), { ...waiting, ...news, id: waiting.id }]);
          setError("");
          if (news.state !== "waiting") onGraded();
        },
        (reason: unknown) => setError(describeFailure(reason)),
      );
  };
  useInterval(look, LOOK_WAIT, isWaiting);
  return (
    <details class="more notebook-work" open={isOpen} onToggle={({ currentTarget }) => setOpen(currentTarget.open)}>
      <summary>{say("serve.notebook")}</summary>
      <p>
        <a class="button quiet" href="notebook.ipynb" download>
          {say("serve.take-away")}
        </a>
      </p>
      {work.closed ? null : (
        <DropField
          text={say("serve.drop")}
          isDisabled={isSending}
          onFiles={([file, ...others]) => {
            if (others.length > 0) setError(say("check.several-files"));
            else if (file!.size > MAX_MEGABYTES * 1e6)
              setError(say("check.too-large", { name: file!.name, limit: MAX_MEGABYTES }));
            else if (Object.keys(work.answers).length > 0) setAsked(file!);
            else void send(() => submit(file!));
          }}
        />
      )}
      {asked ? (
        <Warning
          text={say("serve.replaces")}
          onSubmit={() => void send(() => submit(asked))}
          onCancel={() => setAsked(null)}
        />
      ) : null}
      {isSending ? <p role="status">{say("serve.submitting")}</p> : null}
      {error ? <p role="alert">{error}</p> : null}
      {submissions.length > 0 ? (
        <ul class="submissions" aria-live="polite">
          {submissions.map((submission) => (
            <li key={submission.id}>
              <strong>{submission.file_name}</strong> <span class="muted">{formatTime(submission.received)}</span>{" "}
              {describeState(submission, work.max_score)} {submission.note}
            </li>
          ))}
        </ul>
      ) : null}
      {Object.values(work.results).some(({ outcome }) => outcome !== "missing") ? (
        <p>
          <a href="feedback">{say("serve.feedback")}</a>
        </p>
      ) : null}
    </details>
  );
}

function describeState({ state, place, score }: Submission, max: number): string {
  if (state === "failed") return say("serve.failed");
  if (state === "marked") return say("serve.points", { points: writePoints(score), max });
  return place === null || place < 1 ? say("serve.grading") : say("serve.queued", { place });
}
