// One student's submission as the staff see it: answers, results, solutions, points by hand, due date.

import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { Button, Failed } from "../controls.js";
import { Html } from "../practice/math.js";
import { removeLetterInstructions } from "../practice/prompt.js";
import { Solution } from "../practice/question.js";
import { useLoaded } from "../scheduling.js";
import { say } from "../text/text.js";
import { get, inLanguage, type StudentWork } from "./api.js";
import type { ClassView } from "./class-table.js";
import { nameOf } from "./groups.js";
import { ExtensionForm, PointsForm } from "./points-form.js";
import { isTelling, nameOutcome, ShownResult, writePoints } from "./shown.js";
import { listQuestions, type NamedQuestion } from "./student.js";
import { formatTime } from "../text/times.js";

export function StudentView({ id, results, onChange, onStudent }: ClassView & { readonly id: number }): JSX.Element {
  const student = results.students.find((other) => other.id === id);
  const load = () => get<StudentWork>(inLanguage(`students/${id}`));
  // again if something about the student changes
  const { loaded: work, error, retry } = useLoaded(load, [id, student?.score, student?.last]);
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), [id, work === null]);
  const place = results.students.findIndex((other) => other.id === id);
  const questions = work ? listQuestions(work) : [];
  const numberOf = (name: string | null) => questions.find((question) => question.name === name)?.number ?? "";
  const save = () => {
    onChange();
    retry();
  };
  return (
    <section class="student-view">
      <p class="actions">
        <Button text={say("class.back")} onClick={() => onStudent(null)} />
        {([-1, 1] as const).map((step) => {
          const { [place + step]: other } = results.students;
          const text = (name: string) => say(step < 0 ? "class.previous" : "class.following", { name });
          return other ? <Button text={text(nameOf(results, other.id))} onClick={() => onStudent(other.id)} /> : null;
        })}
      </p>
      {error ? <Failed reason={error} onAgain={retry} /> : null}
      {!work || !student ? (
        <p role="status">{say("practice.loading")}</p>
      ) : (
        <>
          <h2 ref={heading} tabIndex={-1}>
            {nameOf(results, id)}{" "}
            <span class="muted">
              {say("serve.points", { points: writePoints(work.score), max: work.max_score })}
              {work.is_late ? ` · ${say("class.late")}` : ""}
            </span>
          </h2>
          {student.notes ? <p class="notes">{student.notes}</p> : null}
          <ExtensionForm key={student.due} student={student} classDue={results.due} onSaved={save} />
          <details>
            <summary>{say("class.total")}</summary>
            <PointsForm target={{ student: id, part: "" }} max={work.max_score} points={work.score} onSaved={save} />
          </details>
          {work.submissions.length > 0 ? (
            <details>
              <summary>{say("class.submissions", { count: work.submissions.length })}</summary>
              <ul>
                {work.submissions.map((submission) => (
                  <li key={submission.id}>
                    {formatTime(submission.received)} · {submission.file_name || submission.part} ·{" "}
                    {writePoints(submission.score)} {submission.note}
                  </li>
                ))}
              </ul>
            </details>
          ) : null}
          {questions.map((question) => (
            <Answered key={question.name} {...{ question, work, id, numberOf }} onSaved={save} />
          ))}
        </>
      )}
    </section>
  );
}

interface AnsweredProps {
  readonly question: NamedQuestion;
  readonly work: StudentWork;
  readonly id: number;
  readonly numberOf: (name: string | null) => string;
  readonly onSaved: () => void;
}

/** A question with the student's answer, its result, and the solution. */
function Answered({ question, work, id, numberOf, onSaved }: AnsweredProps): JSX.Element {
  const { name, number, problem, part } = question;
  const { [name]: shown } = work.results;
  const { [name]: text } = work.answers;
  const { [name]: solution } = work.solutions;
  return (
    <article class="answered">
      <h3 lang={problem.lang ?? "en"}>
        {number} {part.title}
      </h3>
      <details>
        <summary>{say("class.asked")}</summary>
        <figure lang="en" dangerouslySetInnerHTML={{ __html: part.figure || problem.figure }} />
        <Html html={problem.statement} class="statement" lang={problem.lang} />
        <Html html={removeLetterInstructions(part)} class="prompt" lang={problem.lang} />
      </details>
      {shown && isTelling(shown) ? (
        <ShownResult shown={shown} followedFrom={numberOf(shown.followed_from)} hasPose={false} hasAnswer />
      ) : (
        <p class="muted">{nameOutcome("missing")}</p>
      )}
      {solution ? (
        <details>
          <summary>{say("practice.solution-title")}</summary>
          <Solution {...solution} lang={problem.lang} />
        </details>
      ) : null}
      <PointsForm
        target={{ student: id, part: name, ...(part.key.type === "text" && text ? { answer: text } : {}) }}
        max={shown?.max_points ?? part.points}
        points={shown?.points ?? null}
        comment={shown?.comment ?? ""}
        onSaved={onSaved}
      />
    </article>
  );
}
