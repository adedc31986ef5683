// The page of a class for the staff: a live table, groups of equal answers, answers to mark, regrading, the record.

import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

import { Button, Failed } from "../controls.js";
import { listen, useInterval, useRunning } from "../scheduling.js";
import { say, type TextKey } from "../text/text.js";
import { type ClassResults, get, post, type NewMarks } from "./api.js";
import { StudentView } from "./class-student.js";
import { ClassTable, numberParts } from "./class-table.js";
import { Groups, nameOf } from "./groups.js";
import { describeFailure, useSending } from "./points-form.js";
import { writePoints } from "./shown.js";
import { formatShortTime, formatTime } from "../text/times.js";
import { ToMark } from "./to-mark.js";

/** How often new results are asked for, in milliseconds. */
const LOOK_WAIT = 4000;

const VIEWS = ["students", "groups", "to-mark", "record"] as const;
type View = (typeof VIEWS)[number];

/** What the page shows, as in its address: one of the views, or a student. */
type Shown = { readonly view: View; readonly student: number | null };

function readShown(): Shown {
  const parameters = new URLSearchParams(window.location.search);
  const view = VIEWS.find((name) => name === parameters.get("view")) ?? "students";
  return { view, student: Number(parameters.get("student")) || null };
}

export function ClassPage(): JSX.Element {
  const [results, setResults] = useState<ClassResults | null>(null);
  const [error, setError] = useState("");
  const [shown, setShown] = useState(readShown);
  const version = useRef<string | number | null>(null);
  const look = (): void => {
    const since = version.current === null ? "" : `?since=${encodeURIComponent(version.current)}`;
    get<ClassResults | null>(`results${since}`).then(
      (news) => {
        setError("");
        if (!news) return;
        version.current = news.version;
        setResults(news);
      },
      (reason: unknown) => setError(describeFailure(reason)),
    );
  };
  useRunning(() => {
    look();
    return [
      listen(document, "visibilitychange", () => !document.hidden && look()),
      listen(window, "popstate", () => setShown(readShown())),
    ];
  }, []);
  useInterval(() => !document.hidden && look(), LOOK_WAIT);
  const show = (next: Shown): void => {
    const address = new URL(window.location.href);
    for (const [name, value] of Object.entries(next))
      if (value === null || value === "students") address.searchParams.delete(name);
      else address.searchParams.set(name, String(value));
    window.history.pushState(null, "", address);
    setShown(next);
  };
  if (!results && error) return <Failed reason={error} onAgain={look} />;
  if (!results) return <p role="status">{say("practice.loading")}</p>;
  const openStudent = (student: number | null) => show({ ...shown, student });
  const { view, student } = shown;
  return (
    <>
      <h1>{results.title}</h1>
      <Summary results={results} />
      <RefusedScores results={results} onChange={look} />
      {[results.file_error, error].map((text) => (text ? <p role="alert">{text}</p> : null))}
      <nav class="class-views" aria-label={say("class.views")}>
        {VIEWS.map((name) => (
          <button
            key={name}
            type="button"
            class="quiet"
            aria-current={name === view ? "page" : undefined}
            onClick={() => show({ view: name, student: null })}
          >
            {say(`class.view.${name}` as TextKey)}
            {name === "to-mark" && results.to_mark.length > 0 ? ` (${results.to_mark.length})` : ""}
          </button>
        ))}
      </nav>
      {student !== null ? (
        <StudentView id={student} results={results} onChange={look} onStudent={openStudent} />
      ) : view === "students" ? (
        <>
          <ClassTable results={results} onStudent={openStudent} />
          <Regrading parts={results.parts} onChange={look} />
        </>
      ) : view === "groups" ? (
        <Groups results={results} onChange={look} onStudent={openStudent} />
      ) : view === "to-mark" ? (
        <ToMark results={results} onChange={look} />
      ) : results.actions.length === 0 ? (
        <p>{say("class.no-record")}</p>
      ) : (
        <ul class="record">
          {results.actions.map(({ made, by, summary }, i) => (
            <li key={i}>
              <span class="muted">
                {formatShortTime(made)} · {by}
              </span>{" "}
              {summary}
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

/** How many students have begun, the mean of the scores, and the due date. */
function Summary({ results: { students, due, max_score } }: { results: ClassResults }): JSX.Element {
  const scores = students.flatMap(({ begun, score }) => (begun !== null && score !== null ? [score] : []));
  const mean = scores.length > 0 ? scores.reduce((sum, score) => sum + score, 0) / scores.length : null;
  return (
    <p class="muted">
      {say("class.begun", { count: students.filter(({ begun }) => begun !== null).length, all: students.length })}{" "}
      {say("class.mean", { points: writePoints(mean), max: max_score })}{" "}
      {due ? say("class.due", { time: formatTime(due) }) : ""}
    </p>
  );
}

/** Scores that the platform refuses, and a button that sends them again. */
function RefusedScores({ results, onChange }: { results: ClassResults; onChange: () => void }): JSX.Element | null {
  const { send, isSending, error } = useSending(onChange);
  const [first] = results.refused;
  if (!first) return null;
  const names = [...new Set(results.refused.map(({ student }) => nameOf(results, student)))].join(", ");
  return (
    <p role="alert">
      {say("class.refused", { names, error: first.error })}{" "}
      <Button text={say("class.send-again")} disabled={isSending} onClick={() => void send(() => post("scores", {}))} />{" "}
      {error}
    </p>
  );
}

/** Export, and regrading: the changes are shown before they are stored. */
function Regrading({ parts, onChange }: Pick<ClassResults, "parts"> & { onChange: () => void }): JSX.Element {
  const numbers = numberParts(parts);
  const [newMarks, setNewMarks] = useState<NewMarks | null>(null);
  const { send, isSending, error } = useSending(onChange);
  const compare = () =>
    void send(async () => {
      let answer = await post<NewMarks>("regrade", {});
      for (; answer.waiting > 0; answer = await post<NewMarks>("regrade", {})) {
        setNewMarks(answer);
        await new Promise((done) => setTimeout(done, LOOK_WAIT));
      }
      setNewMarks(answer);
    });
  const confirm = (token: string) =>
    void send(async () => {
      await post("regrade", { token });
      setNewMarks(null);
    });
  return (
    <section class="regrading">
      <p class="actions">
        <a class="button quiet" href="export.zip" download>
          {say("class.export")}
        </a>
        <Button text={say("class.regrade")} disabled={isSending} onClick={compare} />
      </p>
      {error ? <p role="alert">{error}</p> : null}
      {isSending ? <p role="status">{say("class.regrading", { count: newMarks?.waiting ?? 0 })}</p> : null}
      {newMarks && newMarks.waiting === 0 ? (
        <div role="status">
          <h2>{say("class.changes", { count: newMarks.changes.length })}</h2>
          {newMarks.changes.length > 0 ? (
            <>
              <table>
                <tbody>
                  {newMarks.changes.map(({ student, name, part, before, after }) => (
                    <tr key={`${student} ${part}`}>
                      <th scope="row">{name}</th>
                      <td>{part ? (numbers[part] ?? part) : say("class.score")}</td>
                      <td>
                        {writePoints(before)} → {writePoints(after)}
                      </td>
                    </tr>
                  ))}
                </tbody>
              </table>
              <p class="actions">
                <Button className="button" text={say("class.store-changes")} onClick={() => confirm(newMarks.token)} />
                <Button text={say("class.drop-changes")} onClick={() => setNewMarks(null)} />
              </p>
            </>
          ) : null}
        </div>
      ) : null}
    </section>
  );
}
