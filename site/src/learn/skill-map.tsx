// The map of lessons: links in an order in which each lesson follows what it needs, and lines between them. The lines
// are hidden from screen readers, because each link names the needed lessons that are not learned yet.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { describeClass } from "./dots.js";
import { type QuestionProgress, type LessonNode, findLessonState } from "./graph.js";

export function SkillMap({ nodes }: { nodes: readonly LessonNode[] }): JSX.Element {
  const layerCount = Math.max(...nodes.map(({ lesson }) => lesson.position.layer)) + 1;
  /** The width of the widest layer, where each lesson has the width 1. */
  const width = 1 + 2 * Math.max(...nodes.map(({ lesson }) => lesson.position.offset));
  return (
    <section class="skills" aria-labelledby="skills-title">
      <h2 id="skills-title">{say("skills.title")}</h2>
      <p class="muted">{say("skills.legend")}</p>
      <div class="skill-map" style={{ "--layers": layerCount, "--width": width }}>
        <Lines nodes={nodes} layerCount={layerCount} width={width} />
        <ol>
          {nodes.map((node) => (
            <li
              key={node.lesson.id}
              class={`skill is-${node.state}${node.isNext ? " is-next" : ""}`}
              style={gridPlace(node.lesson.position, width)}
            >
              <LessonItem node={node} />
            </li>
          ))}
        </ol>
      </div>
    </section>
  );
}

/** Return the lines of the grid (from 1) at which a lesson begins; it spans two columns, so offsets may be halves. */
const gridPlace = ({ layer, offset }: LessonNode["lesson"]["position"], width: number) => ({
  "--layer": layer + 1,
  "--offset": Math.round(2 * offset + width),
});

type Point = readonly [x: number, y: number];

type LinesProps = { readonly nodes: readonly LessonNode[]; readonly layerCount: number; readonly width: number };

/** Lines from each lesson to what it needs, for layers from left to right and for layers downwards; CSS shows one. */
function Lines({ nodes, layerCount, width }: LinesProps): JSX.Element {
  const centreOf = ({ lesson: { position } }: LessonNode): Point => [position.layer + 0.5, width / 2 + position.offset];
  const lines = nodes.flatMap((node) =>
    node.lesson.needs.map((need) => {
      const needed = nodes.find(({ lesson }) => lesson.id === need)!;
      const isLearned = needed.state !== "new" && needed.state !== "begun";
      return { key: `${need} ${node.lesson.id}`, start: centreOf(needed), end: centreOf(node), isLearned };
    }),
  );
  return (
    <>
      {(["across", "down"] as const).map((direction) => (
        <svg
          key={direction}
          class={`skill-lines ${direction}`}
          viewBox={direction === "across" ? `0 0 ${layerCount} ${width}` : `0 0 ${width} ${layerCount}`}
          preserveAspectRatio="none"
          aria-hidden="true"
        >
          {lines.map(({ key, start, end, isLearned }) => {
            const [[x1, y1], [x2, y2]] = direction === "across" ? [start, end] : [swapAxes(start), swapAxes(end)];
            return <path key={key} class={isLearned ? "known" : ""} d={`M${x1} ${y1}L${x2} ${y2}`} />;
          })}
        </svg>
      ))}
    </>
  );
}

const swapAxes = ([x, y]: Point): Point => [y, x];

const STATE_SIGNS = { new: "○", begun: "◔", learned: "◕", due: "◕", mastered: "●" } as const;

/** A link to a lesson, with its state, and the progress in its classes of arms and its questions. */
function LessonItem({ node }: { node: LessonNode }): JSX.Element {
  const { lesson, state, isNext, unlearnedNeeds, classes, questions } = node;
  const titleOf = ({ title }: LessonNode["lesson"]): string => say(title);
  return (
    <>
      <a href={`learn.html?lesson=${lesson.id}${state === "due" ? "&practise=1" : ""}`}>{titleOf(lesson)}</a>
      <span class="skill-state">
        <span aria-hidden="true">{STATE_SIGNS[state]}</span> {say(`skills.${state}`)}
        {isNext ? `, ${say("skills.next")}` : ""}
      </span>
      {classes.length > 1 && state !== "new" && state !== "begun" ? (
        <ul class="skill-classes" aria-label={say("classes.title")}>
          {classes.map(([armClass, streak]) => {
            const classState = findLessonState({ ...streak, goals: [] }, -Infinity); // at this time, nothing is due
            return (
              <li key={armClass.name} class={`is-${classState}`} title={describeClass(armClass, streak)}>
                <span aria-hidden="true">
                  {STATE_SIGNS[classState]} {say(`classes.${armClass.name}`)}
                </span>
                <span class="visually-hidden">{describeClass(armClass, streak)}</span>
              </li>
            );
          })}
        </ul>
      ) : null}
      {unlearnedNeeds.length > 0 ? (
        <span class="visually-hidden">{say("skills.after", { titles: unlearnedNeeds.map(titleOf).join(", ") })}</span>
      ) : null}
      {questions.length > 0 ? (
        <ul class="skill-asked" aria-label={say("skills.asked")}>
          {questions.map((question) => (
            <li key={question.name}>
              <QuestionLink {...question} />
            </li>
          ))}
        </ul>
      ) : null}
    </>
  );
}

/** A link to a question, with a segment for each needed arm, filled for each right answer. */
function QuestionLink(props: QuestionProgress): JSX.Element {
  const { name, title, lang, rightCount, neededCount, hasWrongAnswer } = props;
  const progress = say(hasWrongAnswer ? "skills.of-missed" : "skills.of", { right: rightCount, needed: neededCount });
  return (
    <a
      href={`practice.html?question=${name}`}
      class={hasWrongAnswer ? "missed" : rightCount === neededCount ? "full" : ""}
      title={`${title}: ${progress}`}
    >
      <span aria-hidden="true">
        {Array.from({ length: neededCount }, (_, i) => (
          <i key={i} class={i < rightCount ? "on" : ""} />
        ))}
      </span>
      <span class="visually-hidden">
        <span lang={lang ?? "en"}>{title}</span>: {progress}
      </span>
    </a>
  );
}
