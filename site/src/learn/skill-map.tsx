// The map of lessons: links in an order in which each lesson follows what it needs, and lines between them; on a phone a
// list. The lines are hidden from screen readers, because each link names the needed lessons that are not learned yet.

import type { JSX } from "preact";

import { say } from "../text/text.js";
import { Dots } from "./dots.js";
import type { LessonNode } from "./graph.js";

export function SkillMap({ nodes }: { nodes: readonly LessonNode[] }): JSX.Element {
  const layerCount = Math.max(...nodes.map(({ lesson }) => lesson.position.layer)) + 1;
  /** The width of the widest layer, where each lesson has the width 1. */
  const width = 1 + 2 * Math.max(...nodes.map(({ lesson }) => lesson.position.offset));
  return (
    <section class="skills" aria-labelledby="skills-title">
      <h2 id="skills-title">{say("skills.title")}</h2>
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

/** Lines from each lesson to what it needs, for layers from left to right. */
function Lines({ nodes, layerCount, width }: LinesProps): JSX.Element {
  const centreOf = ({ lesson: { position } }: LessonNode): Point => [position.layer + 0.5, width / 2 + position.offset];
  return (
    <svg class="skill-lines" viewBox={`0 0 ${layerCount} ${width}`} preserveAspectRatio="none" aria-hidden="true">
      {nodes.flatMap((node) =>
        node.lesson.needs.map((need) => {
          const needed = nodes.find(({ lesson }) => lesson.id === need)!;
          const isLearned = needed.state !== "new" && needed.state !== "begun";
          const [[x1, y1], [x2, y2]] = [centreOf(needed), centreOf(node)];
          return (
            <path key={`${need} ${node.lesson.id}`} class={isLearned ? "known" : ""} d={`M${x1} ${y1}L${x2} ${y2}`} />
          );
        }),
      )}
    </svg>
  );
}

/** A link to a lesson, with its state in words, and dots if it was practised. */
function LessonItem({ node }: { node: LessonNode }): JSX.Element {
  const { lesson, skill, state, isNext, unlearnedNeeds, classes } = node;
  const titleOf = ({ title }: LessonNode["lesson"]): string => say(title);
  return (
    <>
      <a href={`learn.html?lesson=${lesson.id}${state === "due" ? "&practise=1" : ""}`}>{titleOf(lesson)}</a>
      <span class="skill-state">
        {say(`skills.${state}`)}
        {isNext ? `, ${say("skills.next")}` : ""}
        {state === "begun" || state === "learned" ? (
          <>
            {" "}
            <Dots skill={skill} classes={classes.map(([armClass]) => armClass)} />
          </>
        ) : null}
      </span>
      {unlearnedNeeds.length > 0 ? (
        <span class="visually-hidden">{say("skills.after", { titles: unlearnedNeeds.map(titleOf).join(", ") })}</span>
      ) : null}
    </>
  );
}
