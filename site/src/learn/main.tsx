// The script of the page of lessons: all of them with the progress, or one of them, by ?lesson= in the address.
import "../site.css";

import type { JSX } from "preact";
import { useMemo } from "preact/hooks";

import type { Index } from "../bank.js";
import type { ArmRecord } from "../pages/live.js";
import { showPart } from "../pages/part.js";
import { Rich } from "../practice/math.js";
import { type StoredState, useStoredState } from "../practice/stored-state.js";
import { WithIndex } from "../practice/with-index.js";
import { say } from "../text/text.js";
import { Offline } from "../offline/offline.js";
import { Dots } from "./dots.js";
import { makeLessonNodes } from "./graph.js";
import { SkillMap } from "./skill-map.js";
import { LessonView } from "./lesson.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { NEW_SKILL } from "../practice/skills.js";

/** The arms of the ideas, as Python wrote them. */
type Arms = Readonly<Record<"plain" | "elbow", ArmRecord>>;

function Learn({ arms, index }: { arms: Arms; index: Index }): JSX.Element {
  const [stored, changeStored] = useStoredState();
  const { lessons: skills } = stored;
  const parameters = new URLSearchParams(window.location.search);
  const lesson = findLesson(parameters);
  if (lesson)
    return (
      <LessonView
        lesson={lesson}
        record={arms[lesson.arm]}
        index={index}
        skill={skills[lesson.id] ?? NEW_SKILL}
        isPractising={parameters.has("practise")}
        onSkill={(skill) => changeStored({ lessons: { ...skills, [lesson.id]: skill } })}
      />
    );
  return <List stored={stored} unknownLesson={parameters.get("lesson")} index={index} />;
}

type ListProps = { stored: StoredState; unknownLesson: string | null; index: Index };

/** All lessons; the next one is highlighted, and so are lessons that are due for review. */
function List({ stored, unknownLesson, index }: ListProps): JSX.Element {
  const { lessons: skills, progress } = stored;
  const problems = useMemo(
    () => index.families.flatMap(({ name, problems }) => problems.map(({ key }) => `${name}/${key}`)),
    [index],
  );
  const now = Date.now();
  const nodes = makeLessonNodes(index, skills, progress, now);
  const next =
    LESSONS.find(({ id }) => skills[id]?.learned === undefined) ??
    nodes.find(({ classes }) => classes.some(([, { learned }]) => learned === undefined))?.lesson;
  return (
    <div class="way">
      {unknownLesson ? <p role="alert">{say("lesson.unknown", { name: unknownLesson })}</p> : null}
      <p class="lead">{say("lesson.lead")}</p>
      <SkillMap nodes={nodes} />
      <ol>
        {nodes.map(({ lesson: { id, title, idea, goals }, state, classes }) => {
          const skill = skills[id] ?? NEW_SKILL;
          const isDue = state === "due";
          return (
            <li key={id} class={isDue || (next?.id === id && !isDue) ? "current" : ""}>
              <h2>
                <a class="cover" href={`learn.html?lesson=${id}${isDue ? "&practise=1" : ""}`}>
                  {say(title)}
                </a>
              </h2>
              <p>
                <Rich text={say(idea[0]!)} />
              </p>
              <p class="muted">
                <Dots skill={skill} classes={classes.map(([armClass]) => armClass)} />{" "}
                {isDue ? say("lesson.due") : say("lesson.goals", { count: skill.goals.length, all: goals.length })}
              </p>
            </li>
          );
        })}
      </ol>
      <Offline title={say("offline.course")} problems={problems} />
    </div>
  );
}

const findLesson = (parameters: URLSearchParams): Lesson | undefined =>
  LESSONS.find(({ id }) => id === parameters.get("lesson"));

/** The space of a lesson before it is loaded. */
const Loading = (): JSX.Element => (
  <div class="workspace">
    <p role="status" class="task">
      {say("practice.loading")}
    </p>
    {findLesson(new URLSearchParams(window.location.search)) ? <div class="stage" /> : null}
  </div>
);

await showPart("learn", ["Learn", "page.learn"], ({ arms }) => (
  <WithIndex loading={<Loading />}>{(index) => <Learn arms={JSON.parse(arms!) as Arms} index={index} />}</WithIndex>
));
