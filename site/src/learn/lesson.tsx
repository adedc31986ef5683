// A lesson: an idea to try on the arm, with goals to reach; then practice until the lesson is learned.

import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { Arm } from "../arm/panel.js";
import type { State } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import { ZERO } from "../arm/vector.js";
import type { View } from "../arm/view.js";
import type { Index } from "../bank.js";
import type { ArmRecord } from "../pages/live.js";
import { progressAfter, type Item, nameOf } from "../practice/choice.js";
import { Current } from "../practice/current.js";
import { Rich } from "../practice/math.js";
import { storedState, storeState } from "../practice/stored-state.js";
import { storage } from "../storage.js";
import { Offline } from "../offline/offline.js";
import { type Message, textOf, say } from "../text/text.js";
import { classesOf, currentClass, streakIn, type ClassItems, withStreak } from "../practice/classes.js";
import { Dots } from "./dots.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { streakAfter, armCountOf, isDue, NEEDED, nextIn, outcomeOf, type Skill } from "../practice/skills.js";
import { DialBoard, FIRST_DIALS, ratesOf, Contributions, velocityOf } from "./tools.js";

export interface LessonProps {
  readonly lesson: Lesson;
  readonly record: ArmRecord;
  readonly index: Index;
  readonly skill: Skill;
  readonly isPractising: boolean;
  readonly onSkill: (skill: Skill) => void;
}

export function LessonView(props: LessonProps): JSX.Element {
  const { lesson, index } = props;
  const [isPractising, setPractising] = useState(props.isPractising);
  const classes = useMemo(() => classesOf(index, lesson), [index, lesson]);
  const items = useMemo(() => classes.flatMap(({ items }) => items), [classes]);
  return isPractising && items.length > 0 ? (
    <Practice {...props} classes={classes} hasArrived={!props.isPractising} onIdea={() => setPractising(false)} />
  ) : (
    <Idea {...props} classes={classes} items={items} onPractise={() => setPractising(true)} />
  );
}

type Classes = { readonly classes: readonly ClassItems[] };

/** The number of the lesson, and a link to the list of lessons. */
function Head({ lesson, skill, classes }: Pick<LessonProps, "lesson" | "skill"> & Classes): JSX.Element {
  const number = LESSONS.indexOf(lesson) + 1;
  return (
    <p class="kicker">
      <a href="learn.html">{say("lesson.all")}</a>
      <span class="muted"> · {say("lesson.number", { number, count: LESSONS.length })}</span>{" "}
      <Dots skill={skill} classes={classes} />
    </p>
  );
}

function Idea(props: LessonProps & Classes & { items: readonly Item[]; onPractise: () => void }): JSX.Element {
  const { lesson, record, skill, classes, items, onSkill, onPractise } = props;
  const [stage, setStage] = useState<Stage | null>(null);
  const problems = useMemo(() => items.map(({ family, key }) => `${family}/${key}`), [items]);
  const [dials, setDials] = useState(FIRST_DIALS);
  const { tool, goals } = lesson;
  const rates = stage ? ratesOf(tool, dials, stage.state) : [];
  const velocity = stage ? velocityOf(stage.arm, stage.state, rates) : ZERO;
  const reached = stage ? goals.flatMap(({ reached }, i) => (reached({ stage, rates, velocity }) ? [i] : [])) : [];
  const moved = useRef(false); // the arm's first pose reaches no goal
  const initial = useRef("");
  const hasPath = useRef(false); // nor does the first path
  useEffect(() => {
    if (!stage) return;
    const current = JSON.stringify([stage.pose, dials, stage.welding?.place, stage.welding?.weld]);
    const isFirstPath = stage.welding !== null && !hasPath.current;
    if (!initial.current || isFirstPath) [initial.current, moved.current] = [current, false];
    if (isFirstPath) hasPath.current = true;
    if (current !== initial.current) moved.current = true;
    const newGoals = reached.filter((i) => !skill.goals.includes(i));
    if (moved.current && newGoals.length > 0) onSkill({ ...skill, goals: [...skill.goals, ...newGoals] });
  });
  const overlay = useMemo(
    () =>
      tool
        ? (now: Stage, view: View) => <Contributions stage={now} view={view} rates={ratesOf(tool, dials, now.state)} />
        : undefined,
    [tool, dials],
  );
  const ratesIn = useMemo(
    () => (tool ? (state: State): readonly number[] => ratesOf(tool, dials, state) : undefined),
    [tool, dials],
  );
  const done = goals.every((_, i) => skill.goals.includes(i));
  return (
    <div class="workspace">
      <article class="task lesson">
        <Head lesson={lesson} skill={skill} classes={classes} />
        <h2>{say(lesson.title)}</h2>
        {lesson.idea.map((text) => (
          <p key={text}>
            <Rich text={say(text)} />
          </p>
        ))}
        {tool && stage ? (
          <DialBoard tool={tool} arm={stage.arm} dials={dials} rates={rates} velocity={velocity} onDials={setDials} />
        ) : null}
        <h3>{say("lesson.try")}</h3>
        <ul class="goals" aria-live="polite">
          {goals.map(({ text }, i) => (
            <li key={text} class={skill.goals.includes(i) ? "reached" : ""}>
              <span class="tick" aria-hidden="true">
                {skill.goals.includes(i) ? "✓" : "○"}
              </span>
              <span>
                <Rich text={say(text)} />
                {skill.goals.includes(i) ? <span class="visually-hidden"> {say("lesson.reached")}</span> : null}
              </span>
            </li>
          ))}
        </ul>
        <p class="actions">
          {items.length > 0 ? (
            <Button
              style={done ? "button" : "button quiet"}
              text={say(done ? "lesson.practise" : "lesson.practise-already")}
              onClick={onPractise}
            />
          ) : null}
          <NextLesson lesson={lesson} quiet />
        </p>
        {items.length > 0 ? <Offline title={say("offline.lesson")} problems={problems} /> : null}
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        <Arm
          key={lesson.id}
          robot={record.robot}
          symbols={record.symbols}
          first={record.pose}
          factors={record.factors}
          layers={lesson.layers}
          pane={lesson.pane}
          onStage={setStage}
          overlay={overlay}
          rates={ratesIn}
        />
      </section>
    </div>
  );
}

/** A link to the next lesson. */
function NextLesson({ lesson, quiet }: { lesson: Lesson; quiet: boolean }): JSX.Element | null {
  const next = LESSONS[LESSONS.indexOf(lesson) + 1];
  return next ? (
    <a class={quiet ? "button quiet" : "button"} href={`learn.html?lesson=${next.id}`}>
      {say("lesson.next", { title: say(next.title) })}
    </a>
  ) : null;
}

function Practice(props: LessonProps & Classes & { hasArrived: boolean; onIdea: () => void }): JSX.Element {
  const { lesson, index, skill, classes, hasArrived, onSkill, onIdea } = props;
  /** Choose the next question, and the class of arms to which it belongs. */
  const chooseNext = (): { at: number; item: Item | null } => {
    const at = currentClass(skill, classes, Date.now());
    const item = nextIn(classes[at]!.items, streakIn(skill, classes, at), asked.current, Math.random);
    if (item) asked.current.push(nameOf(item));
    return { at, item };
  };
  const asked = useRef<string[]>([]);
  const [{ at, item }, setCurrent] = useState(chooseNext);
  const [count, setCount] = useState(0);
  const [note, setNote] = useState<Message | null>(null);
  const again = useRef(false); // whether this question was answered before
  const armCount = armCountOf(classes[at]!.items);
  const streak = streakIn(skill, classes, at);
  return (
    <div class="workspace">
      <div class="choosing">
        <Head lesson={lesson} skill={skill} classes={classes} />
        <p class="lesson-title">
          <strong>{say(lesson.title)}</strong> <Button style="quiet small" text={say("lesson.back")} onClick={onIdea} />
        </p>
        <p class="muted" role="status">
          {classes.length > 1 ? (
            <>
              <strong class="class-name">{say(`classes.${classes[at]!.name}`)}</strong> ·{" "}
            </>
          ) : null}
          {streak.mastered !== undefined
            ? say("lesson.mastered")
            : streak.learned !== undefined
              ? say(isDue(streak, Date.now()) ? "lesson.due" : "lesson.learned")
              : say("lesson.row", { count: streak.row.length, needed: Math.min(NEEDED, armCount) })}
        </p>
        {skill.learned !== undefined ? (
          <p class="actions">
            <NextLesson lesson={lesson} quiet={false} />
          </p>
        ) : null}
      </div>
      {item ? (
        <Current
          key={`${nameOf(item)} ${count}`}
          item={item}
          level={index.feedback}
          hasArrived={hasArrived || count > 0}
          notes={note ? [textOf(note)] : []}
          onVerdict={(right, helped) => {
            const now = Date.now();
            const attempt = { right, helped, again: again.current, armCount };
            const after = streakAfter(streak, item, { ...attempt, now });
            again.current = true;
            setNote(outcomeOf(streak, after, attempt));
            onSkill(withStreak(skill, classes, at, after));
            // a wrong answer is asked again on the practice page
            storeState(storage, { progress: progressAfter(storedState(storage).progress, item, right, now) });
          }}
          onNext={() => {
            again.current = false;
            setNote(null);
            setCurrent(chooseNext());
            setCount(count + 1);
          }}
        />
      ) : null}
    </div>
  );
}
