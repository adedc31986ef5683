// Groups of equal wrong answers, the largest first; points can be set for a whole group.

import type { JSX } from "preact";

import { Button } from "../controls.js";
import { say } from "../text/text.js";
import type { ClassResults, Group } from "./api.js";
import { type ClassView, numberParts } from "./class-table.js";
import { PointsForm } from "./points-form.js";
import { nameOutcome, writePoints } from "./shown.js";

export function Groups({ results, onChange, onStudent }: ClassView): JSX.Element {
  const numbers = numberParts(results.parts);
  const common = results.groups.filter(({ students }) => students.length > 1);
  const parts = results.parts.filter(({ name }) => common.some(({ part }) => part === name));
  if (parts.length === 0) return <p>{say("class.no-groups")}</p>;
  return (
    <>
      {parts.map((part) => {
        const groups = common
          .filter((group) => group.part === part.name)
          .sort((a, b) => b.students.length - a.students.length);
        return (
          <section key={part.name}>
            <h2>
              {numbers[part.name]} {part.title}
            </h2>
            <Mistakes groups={results.groups.filter((group) => group.part === part.name)} />
            {groups.map((group) => (
              <article key={group.group} class="answered">
                <h3>
                  {say("class.group", { count: group.students.length })}{" "}
                  <span class="muted">
                    {nameOutcome(group.outcome)} ·{" "}
                    {say("serve.points", { points: writePoints(group.points), max: part.max_points })}
                    {group.mistake ? ` · ${group.mistake}` : ""}
                  </span>
                </h3>
                <pre tabIndex={0} role="region" aria-label={say("answer.label")}>
                  <code>{group.answer}</code>
                </pre>
                <details>
                  <summary>{say("class.set-points")}</summary>
                  <PointsForm
                    target={{ group: group.group, part: part.name }}
                    max={part.max_points}
                    points={group.points}
                    onSaved={onChange}
                  />
                  <p class="names">
                    {group.students.map((id) => (
                      <Button key={id} className="heading" text={nameOf(results, id)} onClick={() => onStudent(id)} />
                    ))}
                  </p>
                </details>
              </article>
            ))}
          </section>
        );
      })}
    </>
  );
}

/** How many students made each mistake. */
function Mistakes({ groups }: { groups: readonly Group[] }): JSX.Element | null {
  const counts = new Map<string, number>();
  for (const { mistake, students } of groups)
    if (mistake) counts.set(mistake, (counts.get(mistake) ?? 0) + students.length);
  if (counts.size === 0) return null;
  return (
    <ul class="mistakes">
      {[...counts]
        .sort(([, a], [, b]) => b - a)
        .map(([mistake, count]) => (
          <li key={mistake}>
            {count} × {mistake}
          </li>
        ))}
    </ul>
  );
}

export function nameOf({ students }: ClassResults, id: number): string {
  const student = students.find((other) => other.id === id);
  return student?.name || student?.student_id || String(id);
}
