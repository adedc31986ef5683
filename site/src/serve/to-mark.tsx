// Answers in words that a person marks, one after the other, by keys: numbers are points, j and k go on and back.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { say } from "../text/text.js";
import { type ClassResults, type Override, post } from "./api.js";
import { type ClassView, numberParts } from "./class-table.js";
import { nameOf } from "./groups.js";
import { describeFailure, PointsForm } from "./points-form.js";

export function ToMark({ results, onChange }: Omit<ClassView, "onStudent">): JSX.Element {
  const [place, setPlace] = useState(0);
  const [done, setDone] = useState<Readonly<Record<string, number>>>({}); // points that were set on this page
  const [queue] = useState(() => [...results.to_mark]); // it stays in order while answers are marked
  const known = new Set(queue.map(nameAnswer));
  const answers = [...queue, ...results.to_mark.filter((answer) => !known.has(nameAnswer(answer)))];
  const [failures, setFailures] = useState<readonly string[]>([]);
  const section = useRef<HTMLElement>(null);
  useEffect(() => section.current?.focus(), []); // the keys work while the focus is here
  const answer = answers[Math.min(place, answers.length - 1)];
  const part = results.parts.find(({ name }) => name === answer?.part);
  const maxPoints = part?.max_points ?? 0;
  const move = (step: number) => setPlace((old) => Math.min(Math.max(old + step, 0), answers.length - 1));
  /** Set points and move on at once; if they can't be stored, the answer is named. */
  const mark = (points: number) => {
    if (!answer || points > maxPoints) return;
    const name = nameAnswer(answer);
    const override: Override = { ...answerTarget(answer), points, comment: "" };
    setDone((old) => ({ ...old, [name]: points }));
    move(1);
    post("overrides", override).then(onChange, (reason: unknown) => {
      setDone(({ [name]: _, ...others }) => others);
      setFailures((old) => [...old, `${nameOf(results, answer.student)}: ${describeFailure(reason)}`]);
    });
  };
  const pressKey = ({ key, target, ctrlKey, altKey, metaKey }: KeyboardEvent) => {
    if (ctrlKey || altKey || metaKey || (target as Element).matches("input")) return;
    if (key === "j") move(1);
    else if (key === "k") move(-1);
    else if (/^\d$/.test(key)) mark(Number(key));
  };
  if (!answer || !part) return <p>{say("class.nothing-to-mark")}</p>;
  const points = done[nameAnswer(answer)];
  return (
    <section class="to-mark" ref={section} tabIndex={-1} aria-label={say("class.view.to-mark")} onKeyDown={pressKey}>
      <p class="muted">{say("class.mark-keys", { max: Math.min(9, Math.floor(maxPoints)) })}</p>
      <div role="status">
        <h2>
          {nameOf(results, answer.student)}{" "}
          <span class="muted">
            {numberParts(results.parts)[part.name]} {part.title} ·{" "}
            {say("class.place", { number: answers.indexOf(answer) + 1, count: answers.length })}
          </span>
        </h2>
        <blockquote class="words">{answer.text}</blockquote>
        <p>{points === undefined ? "" : say("serve.points", { points, max: maxPoints })}</p>
      </div>
      <p class="actions">
        {Array.from({ length: Math.floor(maxPoints) + 1 }, (_, value) => (
          <Button key={value} text={String(value)} onClick={() => mark(value)} />
        ))}
        <Button text={say("class.back-one")} onClick={() => move(-1)} />
        <Button text={say("class.forth-one")} onClick={() => move(1)} />
      </p>
      {failures.map((failure) => (
        <p key={failure} role="alert">
          {failure}
        </p>
      ))}
      <PointsForm
        key={nameAnswer(answer)}
        target={answerTarget(answer)}
        max={maxPoints}
        points={points ?? null}
        onSaved={() => {
          onChange();
          move(1);
        }}
      />
    </section>
  );
}

type Answer = ClassResults["to_mark"][number];
const nameAnswer = ({ student, part, text }: Answer): string => JSON.stringify([student, part, text]);
const answerTarget = ({ student, part, text }: Answer) => ({ student, part, answer: text });
