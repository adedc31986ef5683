// The live table of a class: who has begun, the marks of each part, late work.

import { Component, type JSX } from "preact";
import { useMemo, useState } from "preact/hooks";

import { Button, Choice, optionsOf } from "../controls.js";
import { say, type TextKey } from "../text/text.js";
import type { ClassPart, ClassResults, ClassStudent, Mark } from "./api.js";
import { nameOutcome, writePoints } from "./shown.js";
import { formatShortTime } from "../text/times.js";

const SIGNS: Readonly<Record<Mark["outcome"], string>> = {
  ...{ correct: "✓", partial: "◐", wrong: "✗", missing: "", ungraded: "…" },
};

/** Which students are listed. */
const FILTERS: Readonly<Record<string, (student: ClassStudent) => boolean>> = {
  all: () => true,
  begun: ({ begun }) => begun !== null,
  "not-begun": ({ begun }) => begun === null,
  late: ({ is_late }) => is_late,
  extended: ({ due }) => due !== null,
};

type Order = "name" | "score" | "last";

/** Return the students that a filter and a search leave, in an order; the best and the latest first. */
export function listStudents(
  students: readonly ClassStudent[],
  { filter, search, order }: { readonly filter: string; readonly search: string; readonly order: Order },
): readonly ClassStudent[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const matches = ({ name, student_id }: ClassStudent) =>
    words.every((word) => `${name} ${student_id}`.toLowerCase().includes(word));
  const byName = (a: ClassStudent, b: ClassStudent) => (a.name || a.student_id).localeCompare(b.name || b.student_id);
  const compare = {
    name: byName,
    score: (a: ClassStudent, b: ClassStudent) => (b.score ?? -1) - (a.score ?? -1) || byName(a, b),
    last: (a: ClassStudent, b: ClassStudent) => (b.last ?? "").localeCompare(a.last ?? "") || byName(a, b),
  }[order];
  return students.filter((student) => FILTERS[filter]!(student) && matches(student)).sort(compare);
}

/** Return the numbers of parts by their names, as students see them: "1.2" for the second part of the first problem. */
export function numberParts(parts: readonly ClassPart[]): Readonly<Record<string, string>> {
  const slots = [...new Set(parts.map(({ name }) => name.split(".")[0]!))];
  const partsOf = (slot: string) => parts.filter(({ name }) => name.startsWith(`${slot}.`));
  return Object.fromEntries(
    slots.flatMap((slot, i) => partsOf(slot).map(({ name }, k) => [name, `${i + 1}.${k + 1}`])),
  );
}

/** What the views of a class get: the results, and what to do if a person changes something or opens a student. */
export interface ClassView {
  readonly results: ClassResults;
  readonly onChange: () => void;
  readonly onStudent: (id: number | null) => void;
}

export function ClassTable({ results, onStudent }: Omit<ClassView, "onChange">): JSX.Element {
  const [filter, setFilter] = useState("all");
  const [search, setSearch] = useState("");
  const [order, setOrder] = useState<Order>("name");
  const students = useMemo(
    () => listStudents(results.students, { filter, search, order }),
    [results.students, filter, search, order],
  );
  const numbers = useMemo(() => numberParts(results.parts), [results.parts]);
  const heading = (key: Order, text: TextKey, className: string) => (
    <th
      scope="col"
      class={className}
      aria-sort={order === key ? (key === "name" ? "ascending" : "descending") : undefined}
    >
      <Button className="heading" text={say(text)} onClick={() => setOrder(key)} />
    </th>
  );
  return (
    <>
      <p class="class-choices">
        <label>
          {say("class.search")}{" "}
          <input type="search" value={search} onInput={({ currentTarget }) => setSearch(currentTarget.value)} />
        </label>
        <Choice label="class.show" value={filter} onValue={setFilter}>
          {optionsOf(Object.keys(FILTERS).map((name) => [name, say(`class.filter.${name}` as TextKey)]))}
        </Choice>
        <span role="status">{say("class.listed", { count: students.length, all: results.students.length })}</span>
      </p>
      <div class="class-table" role="region" aria-label={say("class.students")} tabIndex={0}>
        <table style={{ "--parts": results.parts.length }}>
          <thead>
            <tr>
              {heading("name", "class.student", "of-name")}
              {heading("score", "class.score", "of-score")}
              {results.parts.map(({ name, title, max_points }) => (
                <th key={name} scope="col" class="of-part" title={title}>
                  {numbers[name]}
                  <span class="visually-hidden"> {title}</span> <span class="muted">/ {max_points}</span>
                </th>
              ))}
              {heading("last", "class.last", "of-time")}
            </tr>
          </thead>
          <tbody>
            {students.map((student) => (
              <Row key={student.id} student={student} parts={results.parts} onStudent={onStudent} />
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

type RowProps = {
  readonly student: ClassStudent;
  readonly parts: readonly ClassPart[];
  readonly onStudent: (id: number) => void;
};

/** A student's row; it is drawn anew only if something about this student has changed. */
class Row extends Component<RowProps> {
  override shouldComponentUpdate({ student, parts }: RowProps): boolean {
    const { student: old, parts: oldParts } = this.props;
    if (student === old && parts === oldParts) return false;
    return JSON.stringify([student, parts]) !== JSON.stringify([old, oldParts]);
  }

  override render({ student, parts, onStudent }: RowProps): JSX.Element {
    const { id, name, student_id, score, marks, last, is_late, due, notes } = student;
    return (
      <tr>
        <th scope="row" class="of-name">
          <Button className="heading" text={name || student_id} onClick={() => onStudent(id)} />{" "}
          {name ? <span class="muted">{student_id}</span> : null} {notes ? <abbr title={notes}>⚠</abbr> : null}
        </th>
        <td class="of-score">{writePoints(score)}</td>
        {parts.map((part) => (
          <MarkCell key={part.name} mark={marks[part.name]} />
        ))}
        <td class="of-time">
          {last ? formatShortTime(last) : say("class.not-begun")}
          {is_late ? <strong class="late"> {say("class.late")}</strong> : null}
          {due ? <span class="muted"> {say("class.until", { time: formatShortTime(due) })}</span> : null}
        </td>
      </tr>
    );
  }
}

function MarkCell({ mark }: { mark: Mark | undefined }): JSX.Element {
  if (!mark || mark.outcome === "missing") return <td class="of-part">–</td>;
  const { outcome, points, mistake, is_override } = mark;
  return (
    <td class={`of-part ${outcome}`} title={mistake || undefined}>
      <span aria-hidden="true">{SIGNS[outcome]}</span>
      <span class="visually-hidden">{nameOutcome(outcome)}</span> {writePoints(points)}
      {is_override ? <abbr title={say("class.by-hand")}>*</abbr> : null}
    </td>
  );
}
