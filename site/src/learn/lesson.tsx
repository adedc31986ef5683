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
import { updateProgress, type Item, nameItem } from "../practice/choice.js";
import { Current } from "../practice/current.js";
import { Rich } from "../practice/math.js";
import { loadState, storeState } from "../practice/stored-state.js";
import { storage } from "../storage.js";
import { Offline } from "../offline/offline.js";
import { type Message, textOf, say } from "../text/text.js";
import { chooseClassIndex, type ClassItems, countInClass, findStreak, listClasses } from "../practice/classes.js";
import { Dots } from "./dots.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { chooseItem, countArms, isDue, NEEDED_ARMS, type Skill } from "../practice/skills.js";
import { DialBoard, FIRST_DIALS, computeRates, Contributions, computeVelocity } from "./tools.js";

interface LessonProps {
  readonly lesson: Lesson;
  readonly record: ArmRecord;
  readonly index: Index;
  readonly skill: Skill;
  /** Whether the page begins with practice instead of the idea. */
  readonly isPractising: boolean;
  readonly onSkill: (skill: Skill) => void;
}

export function LessonView(props: LessonProps): JSX.Element {
  const { lesson, index } = props;
  const [isPractising, setPractising] = useState(props.isPractising);
  const classes = useMemo(() => listClasses(index, lesson), [index, lesson]);
  const items = useMemo(() => classes.flatMap(({ items }) => items), [classes]);
  return isPractising && items.length > 0 ? (
    <Practice {...props} classes={classes} hasArrived={!props.isPractising} onIdea={() => setPractising(false)} />
  ) : (
    <Idea {...props} classes={classes} items={items} onPractise={() => setPractising(true)} />
  );
}

type Classes = { readonly classes: readonly ClassItems[] };

/** The number of the lesson, its progress, and a link to the list of lessons. */
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

/** The idea of the lesson, with the arm on which its goals are reached. */
function Idea(props: LessonProps & Classes & { items: readonly Item[]; onPractise: () => void }): JSX.Element {
  const { lesson, record, skill, classes, items, onSkill, onPractise } = props;
  const [stage, setStage] = useState<Stage | null>(null);
  const problems = useMemo(() => items.map(({ family, key }) => `${family}/${key}`), [items]);
  const [dials, setDials] = useState(FIRST_DIALS);
  const { tool, goals } = lesson;
  const ratesAt = useMemo(() => tool && ((state: State) => computeRates(tool, dials, state)), [tool, dials]);
  const rates = (stage && ratesAt?.(stage.state)) ?? [];
  const velocity = stage ? computeVelocity(stage.arm, stage.state, rates) : ZERO;
  const reachedGoals = stage
    ? goals.flatMap(({ isReached }, i) => (isReached({ stage, rates, velocity }) ? [i] : []))
    : [];
  // Goals are not reached by the arm's initial pose and path, but only after the student changed something.
  const hasMoved = useRef(false);
  const initialState = useRef("");
  const hasPath = useRef(false);
  useEffect(() => {
    if (!stage) return;
    const currentState = JSON.stringify([stage.pose, dials, stage.welding?.place, stage.welding?.weld]);
    const isFirstPath = stage.welding !== null && !hasPath.current;
    if (!initialState.current || isFirstPath) [initialState.current, hasMoved.current] = [currentState, false];
    if (isFirstPath) hasPath.current = true;
    if (currentState !== initialState.current) hasMoved.current = true;
    const newGoals = reachedGoals.filter((i) => !skill.goals.includes(i));
    if (hasMoved.current && newGoals.length > 0) onSkill({ ...skill, goals: [...skill.goals, ...newGoals] });
  });
  const overlay = useMemo(
    () => ratesAt && ((now: Stage, view: View) => <Contributions stage={now} view={view} rates={ratesAt(now.state)} />),
    [ratesAt],
  );
  const isDone = goals.every((_, i) => skill.goals.includes(i));
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
              className={isDone ? "button" : "button quiet"}
              text={say(isDone ? "lesson.practise" : "lesson.practise-already")}
              onClick={onPractise}
            />
          ) : null}
          <NextLesson lesson={lesson} isQuiet />
        </p>
        {items.length > 0 ? <Offline title={say("offline.lesson")} problems={problems} /> : null}
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        <Arm
          key={lesson.id}
          robot={record.robot}
          symbols={record.symbols}
          firstPose={record.pose}
          factors={record.factors}
          layers={lesson.layers}
          pane={lesson.pane}
          onStage={setStage}
          overlay={overlay ?? undefined}
          rates={ratesAt ?? undefined}
        />
      </section>
    </div>
  );
}

/** A link to the next lesson. */
function NextLesson({ lesson, isQuiet }: { lesson: Lesson; isQuiet: boolean }): JSX.Element | null {
  const next = LESSONS[LESSONS.indexOf(lesson) + 1];
  return next ? (
    <a class={isQuiet ? "button quiet" : "button"} href={`learn.html?lesson=${next.id}`}>
      {say("lesson.next", { title: say(next.title) })}
    </a>
  ) : null;
}

/** Questions on the lesson, one after the other; `hasArrived` says whether the reader comes from the idea. */
function Practice(props: LessonProps & Classes & { hasArrived: boolean; onIdea: () => void }): JSX.Element {
  const { lesson, index, skill, classes, hasArrived, onSkill, onIdea } = props;
  /** Choose the next question, and the class of arms to which it belongs. */
  const chooseNext = (): { classIndex: number; item: Item | null } => {
    const classIndex = chooseClassIndex(skill, classes, Date.now());
    const item = chooseItem(
      classes[classIndex]!.items,
      findStreak(skill, classes, classIndex),
      askedNames.current,
      Math.random,
    );
    if (item) askedNames.current.push(nameItem(item));
    return { classIndex, item };
  };
  const askedNames = useRef<string[]>([]);
  const [{ classIndex, item }, setCurrent] = useState(chooseNext);
  const [count, setCount] = useState(0);
  const [note, setNote] = useState<Message | null>(null);
  const isAnswered = useRef(false); // whether this question was answered before
  const armCount = countArms(classes[classIndex]!.items);
  const streak = findStreak(skill, classes, classIndex);
  return (
    <div class="workspace">
      <div class="choosing">
        <Head lesson={lesson} skill={skill} classes={classes} />
        <p class="lesson-title">
          <strong>{say(lesson.title)}</strong>{" "}
          <Button className="quiet small" text={say("lesson.back")} onClick={onIdea} />
        </p>
        <p class="muted" role="status">
          {classes.length > 1 ? (
            <>
              <strong class="class-name">{say(`classes.${classes[classIndex]!.name}`)}</strong> ·{" "}
            </>
          ) : null}
          {streak.mastered !== undefined
            ? say("lesson.mastered")
            : streak.learned !== undefined
              ? say(isDue(streak, Date.now()) ? "lesson.due" : "lesson.learned")
              : say("lesson.row", { count: streak.row.length, needed: Math.min(NEEDED_ARMS, armCount) })}
        </p>
        {skill.learned !== undefined ? (
          <p class="actions">
            <NextLesson lesson={lesson} isQuiet={false} />
          </p>
        ) : null}
      </div>
      {item ? (
        <Current
          key={`${nameItem(item)} ${count}`}
          item={item}
          level={index.feedback}
          hasArrived={hasArrived || count > 0}
          notes={note ? [textOf(note)] : []}
          onVerdict={(isRight, isHelped) => {
            const now = Date.now();
            const attempt = { isRight, isHelped, isRepeated: isAnswered.current, now };
            const counted = countInClass(skill, { classes, classIndex }, item, attempt);
            isAnswered.current = true;
            setNote(counted.outcome);
            onSkill(counted.skill);
            // a wrong answer is asked again on the practice page
            storeState(storage, { progress: updateProgress(loadState(storage).progress, item, isRight, now) });
          }}
          onNext={() => {
            isAnswered.current = false;
            setNote(null);
            setCurrent(chooseNext());
            setCount(count + 1);
          }}
        />
      ) : null}
    </div>
  );
}
