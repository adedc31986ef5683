// The map of lessons: links in an order in which each lesson follows what it needs. Its lines repeat what words say.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { describeClass } from "./dots.js";
import { type QuestionProgress, type LessonNode, standingOf } from "./graph.js";

export function SkillMap({ places }: { places: readonly LessonNode[] }): JSX.Element {
  const layers = Math.max(...places.map(({ lesson }) => lesson.at[0])) + 1;
  const width = 1 + 2 * Math.max(...places.map(({ lesson }) => lesson.at[1]));
  return (
    <section class="skills" aria-labelledby="skills-title">
      <h2 id="skills-title">{say("skills.title")}</h2>
      <p class="muted">{say("skills.legend")}</p>
      <div class="skill-map" style={{ "--layers": layers, "--most": width }}>
        <Lines places={places} layers={layers} most={width} />
        <ol>
          {places.map((place) => (
            <li
              key={place.lesson.id}
              class={`skill is-${place.standing}${place.next ? " is-next" : ""}`}
              style={{ "--layer": place.lesson.at[0] + 1, "--across": Math.round(2 * place.lesson.at[1] + width) }}
            >
              <Skill place={place} />
            </li>
          ))}
        </ol>
      </div>
    </section>
  );
}

/** Lines from each lesson to what it builds on: once from left to right, once downwards. A page shows one of both. */
function Lines({ places, layers, most }: { places: readonly LessonNode[]; layers: number; most: number }): JSX.Element {
  const middle = ({ lesson: { at } }: LessonNode): [number, number] => [at[0] + 0.5, most / 2 + at[1]];
  const lines = places.flatMap((place) =>
    place.lesson.needs.map((need) => {
      const from = places.find(({ lesson }) => lesson.id === need)!;
      const isLearned = from.standing !== "new" && from.standing !== "begun";
      return { key: `${need} ${place.lesson.id}`, from: middle(from), to: middle(place), isLearned };
    }),
  );
  return (
    <>
      {(["across", "down"] as const).map((direction) => (
        <svg
          key={direction}
          class={`skill-lines ${direction}`}
          viewBox={direction === "across" ? `0 0 ${layers} ${most}` : `0 0 ${most} ${layers}`}
          preserveAspectRatio="none"
          aria-hidden="true"
        >
          {lines.map(({ key, from, to, isLearned }) => {
            const [[a, b], [c, d]] = direction === "across" ? [from, to] : [flipped(from), flipped(to)];
            return <path key={key} class={isLearned ? "known" : ""} d={`M${a} ${b}L${c} ${d}`} />;
          })}
        </svg>
      ))}
    </>
  );
}

const flipped = ([x, y]: readonly [number, number]): [number, number] => [y, x];

const SIGNS = { new: "○", begun: "◔", learned: "◕", due: "◕", mastered: "●" } as const;

function Skill({ place }: { place: LessonNode }): JSX.Element {
  const { lesson, standing, next, missing, classes, asked } = place;
  const title = ({ title }: LessonNode["lesson"]): string => say(title);
  return (
    <>
      <a href={`learn.html?lesson=${lesson.id}${standing === "due" ? "&practise=1" : ""}`}>{title(lesson)}</a>
      <span class="skill-state">
        <span aria-hidden="true">{SIGNS[standing]}</span> {say(`skills.${standing}`)}
        {next ? `, ${say("skills.next")}` : ""}
      </span>
      {classes.length > 1 && standing !== "new" && standing !== "begun" ? (
        <ul class="skill-classes" aria-label={say("classes.title")}>
          {classes.map(([armClass, row]) => {
            const standing = standingOf({ ...row, goals: [] }, -Infinity);
            return (
              <li key={armClass.name} class={`is-${standing}`} title={describeClass(armClass, row)}>
                <span aria-hidden="true">
                  {SIGNS[standing]} {say(`classes.${armClass.name}`)}
                </span>
                <span class="visually-hidden">{describeClass(armClass, row)}</span>
              </li>
            );
          })}
        </ul>
      ) : null}
      {missing.length > 0 ? (
        <span class="visually-hidden">{say("skills.after", { titles: missing.map(title).join(", ") })}</span>
      ) : null}
      {asked.length > 0 ? (
        <ul class="skill-asked" aria-label={say("skills.asked")}>
          {asked.map((question) => (
            <li key={question.name}>
              <AskedLink {...question} />
            </li>
          ))}
        </ul>
      ) : null}
    </>
  );
}

/** A link to a question, with a segment for each needed arm, filled for each right answer. */
function AskedLink({ name, title, lang, right, needed, missed }: QuestionProgress): JSX.Element {
  const state = say(missed ? "skills.of-missed" : "skills.of", { right, needed });
  return (
    <a
      href={`practice.html?question=${name}`}
      class={missed ? "missed" : right === needed ? "full" : ""}
      title={`${title}: ${state}`}
    >
      <span aria-hidden="true">
        {Array.from({ length: needed }, (_, i) => (
          <i key={i} class={i < right ? "on" : ""} />
        ))}
      </span>
      <span class="visually-hidden">
        <span lang={lang ?? "en"}>{title}</span>: {state}
      </span>
    </a>
  );
}
