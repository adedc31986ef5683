// The script of the page of lessons: all of them with the progress, or one of them, by ?lesson= in the address.
import "../site.css";

import type { JSX } from "preact";
import { useMemo, useState } from "preact/hooks";

import type { Index } from "../bank.js";
import { Failed } from "../controls.js";
import { loadIndex } from "../load.js";
import type { ArmRecord } from "../pages/live.js";
import { showPart } from "../pages/part.js";
import { type StoredState, useStoredState } from "../practice/stored-state.js";
import { useLoaded } from "../scheduling.js";
import { say } from "../text/text.js";
import { Offline } from "../offline/offline.js";
import { makeLessonNodes } from "./graph.js";
import { SkillMap } from "./skill-map.js";
import { LessonView } from "./lesson.js";
import { LESSONS } from "./lessons.js";
import { countNeededArms, NEW_SKILL } from "../practice/skills.js";

/** The arms of the ideas, as Python wrote them. */
type Arms = Readonly<Record<"plain" | "elbow", ArmRecord>>;

/** The index before it is loaded: the words of a lesson don't wait for it. */
const NO_INDEX: Index = { format: 1, feedback: "solutions", families: [], questions: [] };

function Learn({ arms }: { arms: Arms }): JSX.Element {
  const [stored, changeStored] = useStoredState();
  const { loaded: index, error, retry } = useLoaded(loadIndex, []);
  const { lessons: skills } = stored;
  const parameters = new URLSearchParams(window.location.search);
  const lesson = LESSONS.find(({ id }) => id === parameters.get("lesson"));
  const [mayBeginWithQuestion] = useState(parameters.has("practise") || window.history.state !== null);
  if (error) return <Failed reason={error} onAgain={retry} />;
  if (!index && (!lesson || mayBeginWithQuestion)) return <Loading hasStage={lesson !== undefined} />;
  if (lesson)
    return (
      <LessonView
        lesson={lesson}
        record={arms[lesson.arm]}
        index={index ?? NO_INDEX}
        skill={skills[lesson.id] ?? NEW_SKILL}
        isPractising={parameters.has("practise")}
        onSkill={(skill) => changeStored({ lessons: { ...skills, [lesson.id]: skill } })}
      />
    );
  return <List stored={stored} unknownLesson={parameters.get("lesson")} index={index!} />;
}

type ListProps = { stored: StoredState; unknownLesson: string | null; index: Index };

/** The map of all lessons, and a link to the one that comes next or is due for review. */
function List({ stored, unknownLesson, index }: ListProps): JSX.Element {
  const problems = useMemo(
    () => index.families.flatMap(({ name, problems }) => problems.map(({ key }) => `${name}/${key}`)),
    [index],
  );
  const nodes = makeLessonNodes(index, stored.lessons, Date.now());
  const next =
    nodes.find(({ state }) => state === "due") ??
    nodes.find(({ skill }) => skill.learned === undefined) ??
    nodes.find(({ classes }) => classes.some(([, { learned }]) => learned === undefined));
  const needed = Math.max(1, ...nodes.flatMap(({ classes }) => classes.map(([{ items }]) => countNeededArms(items))));
  return (
    <div class="way">
      {unknownLesson ? <p role="alert">{say("lesson.unknown", { name: unknownLesson })}</p> : null}
      <p class="lead">{say("lesson.lead", { needed })}</p>
      {next ? (
        <p class="actions">
          <a class="button" href={`learn.html?lesson=${next.lesson.id}${next.state === "due" ? "&practise=1" : ""}`}>
            {say(next.state === "due" ? "lesson.review" : "lesson.next", { title: say(next.lesson.title) })}
          </a>
        </p>
      ) : null}
      <SkillMap nodes={nodes} />
      <Offline title={say("offline.course")} problems={problems} />
    </div>
  );
}

/** The space of the list, or of a lesson with its arm, before it is loaded. */
const Loading = ({ hasStage }: { readonly hasStage: boolean }): JSX.Element => (
  <div class="workspace">
    <p role="status" class="task">
      {say("practice.loading")}
    </p>
    {hasStage ? <div class="stage" /> : null}
  </div>
);

await showPart("learn", ["Learn", "page.learn"], ({ arms }) => <Learn arms={JSON.parse(arms!) as Arms} />);
