// A lesson: a prediction, goals to reach on the arm, the explanation, guided steps on one arm; then practice until it is
// learned.

import type { JSX } from "preact";
import { useEffect, useId, useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type { Arm as ArmModel, State } from "../arm/model.js";
import type { Overlay } from "../arm/panel.js";
import type { Stage } from "../arm/stage.js";
import { ZERO } from "../arm/vector.js";
import { type Index, nameJoint, type NamedPose } from "../bank.js";
import type { ArmRecord } from "../pages/live.js";
import { isInIndex, updateProgress, type Item, nameItem } from "../practice/choice.js";
import { useArm } from "../practice/arm-part.js";
import { Rich } from "../practice/math.js";
import { loadState, storeState } from "../practice/stored-state.js";
import { useVisits, visitNumber } from "../practice/visits.js";
import { WithLoaded } from "../practice/with-index.js";
import { useSteps } from "../scheduling.js";
import { storage } from "../storage.js";
import { Offline } from "../offline/offline.js";
import { type Message, textOf, say } from "../text/text.js";
import { chooseClassIndex, type ClassItems, countInClass, findStreak, listClasses } from "../practice/classes.js";
import { Dots } from "./dots.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { chooseItem, countNeededArms, isDue, listGuidedItems, type Skill } from "../practice/skills.js";
import { Sketch } from "./sketch.js";
import { computeRates, computeVelocity, DialBoard, FIRST_DIALS, linesOfTool, ToolArrows } from "./tools.js";
import { WorkspaceChart } from "./workspace.js";

interface LessonProps {
  readonly lesson: Lesson;
  readonly record: ArmRecord;
  readonly index: Index;
  readonly skill: Skill;
  /** Whether the page begins with practice instead of the idea. */
  readonly isPractising: boolean;
  readonly onSkill: (skill: Skill) => void;
}

/** What the page shows: the idea, a guided step, or a question that counts (and whether it was answered before). */
type LessonVisit =
  | { readonly kind: "idea" }
  | { readonly kind: "step"; readonly step: number }
  | { readonly kind: "counted"; readonly classIndex: number; readonly item: Item; readonly isAnswered: boolean };

export function LessonView(props: LessonProps): JSX.Element {
  const { lesson, index, skill } = props;
  const classes = useMemo(() => listClasses(index, lesson), [index, lesson]);
  const items = useMemo(() => classes.flatMap(({ items }) => items), [classes]);
  const steps = useMemo(() => listGuidedItems(classes[0]?.items ?? [], lesson.questions), [classes, lesson]);
  const askedNames = useRef<string[]>([]);
  /** Choose the next question that counts, and the class of arms to which it belongs. */
  const chooseCounted = (): LessonVisit => {
    if (items.length === 0) return { kind: "idea" };
    const classIndex = chooseClassIndex(skill, classes, Date.now());
    const streak = findStreak(skill, classes, classIndex);
    const names = [...steps.map(nameItem), ...askedNames.current]; // an answer to a guided step would not count
    const item = chooseItem(classes[classIndex]!.items, streak, names, Math.random);
    if (!item) return { kind: "idea" };
    askedNames.current.push(nameItem(item));
    return { kind: "counted", classIndex, item, isAnswered: false };
  };
  const [note, setNote] = useState<Message | null>(null);
  const { visit, showNext, replace } = useVisits<LessonVisit>(
    "lesson",
    () => (props.isPractising ? chooseCounted() : { kind: "idea" }),
    (visit) =>
      visit.kind === "idea" ||
      (visit.kind === "step" ? visit.step in steps : visit.classIndex in classes && isInIndex(index, visit.item)),
    () => setNote(null),
  );
  const [firstVisit] = useState(visitNumber);
  const show = (next: LessonVisit): void => {
    setNote(null);
    showNext(next);
  };
  if (visit.kind === "idea") {
    const isFirstPractice = skill.row.length === 0 && skill.learned === undefined;
    const practise = () => show(isFirstPractice && steps.length > 1 ? { kind: "step", step: 0 } : chooseCounted());
    return <Idea {...props} classes={classes} items={items} onPractise={practise} />;
  }
  const isStep = visit.kind === "step";
  const item = isStep ? steps[visit.step]! : visit.item;
  return (
    <div class="workspace">
      <div class="choosing">
        <Head lesson={lesson} skill={skill} classes={classes} />
        <p class="lesson-title">
          <strong>
            {isStep ? say("lesson.step", { number: visit.step + 1, count: steps.length }) : say(lesson.title)}
          </strong>{" "}
          <Button className="quiet small" text={say("lesson.back")} onClick={() => show({ kind: "idea" })} />{" "}
          {isStep ? (
            <Button className="quiet small" text={say("lesson.skip-steps")} onClick={() => show(chooseCounted())} />
          ) : null}
        </p>
        {isStep ? null : <Standing lesson={lesson} skill={skill} classes={classes} classIndex={visit.classIndex} />}
      </div>
      <WithLoaded load={loadCurrent}>
        {({ Current }) => (
          <Current
            key={`${nameItem(item)} ${visitNumber()}`}
            item={item}
            level={index.feedback}
            unknown={lesson.unknown ? "determinant" : undefined}
            hasArrived={visitNumber() !== firstVisit}
            notes={note ? [textOf(note)] : []}
            onVerdict={(isRight, isHelped) => {
              if (isStep) return;
              const now = Date.now();
              const attempt = { isRight, isHelped, isRepeated: visit.isAnswered, now };
              const counted = countInClass(skill, { classes, classIndex: visit.classIndex }, item, attempt);
              replace({ ...visit, isAnswered: true });
              setNote(counted.outcome);
              props.onSkill(counted.skill);
              // a wrong answer is asked again on the practice page
              storeState(storage, { progress: updateProgress(loadState(storage).progress, item, isRight, now) });
            }}
            onNext={() =>
              show(isStep && visit.step + 1 < steps.length ? { ...visit, step: visit.step + 1 } : chooseCounted())
            }
          />
        )}
      </WithLoaded>
    </div>
  );
}

const loadCurrent = () => import("../practice/current.js");

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
  const { lesson, record, index, skill, classes, items, onSkill, onPractise } = props;
  const [stage, setStage] = useState<Stage | null>(null);
  const Arm = useArm(useSteps(1) > 0);
  const problems = useMemo(() => items.map(({ family, key }) => `${family}/${key}`), [items]);
  const [dials, setDials] = useState(FIRST_DIALS);
  const { tool, goals } = lesson;
  const firstPose = useMemo(() => firstPoseOf(lesson, record), [lesson, record]);
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
    (): Overlay | undefined =>
      tool
        ? {
            draw: (now, view) => <ToolArrows tool={tool} dials={dials} stage={now} view={view} />,
            linesAt: (now) => linesOfTool(tool, dials, now),
          }
        : undefined,
    [tool, dials],
  );
  const isDone = goals.every((_, i) => skill.goals.includes(i));
  return (
    <div class="workspace">
      <article class="task lesson">
        <Head lesson={lesson} skill={skill} classes={classes} />
        <h2>{say(lesson.title)}</h2>
        <p>
          <Rich text={say(lesson.intro)} />
        </p>
        <PredictionBox lesson={lesson} skill={skill} onPredict={(predicted) => onSkill({ ...skill, predicted })} />
        <h3>{say("lesson.try")}</h3>
        <div class="tool" data-tool={tool}>
          {tool === "workspace" && stage ? <WorkspaceChart arm={stage.arm} state={stage.state} /> : null}
          {tool && tool !== "workspace" && tool !== "area" && stage ? (
            <DialBoard tool={tool} stage={stage} dials={dials} rates={rates} velocity={velocity} onDials={setDials} />
          ) : null}
        </div>
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
        <Explanation lesson={lesson} arm={stage?.arm ?? null} isOpen={isDone} />
        <p class="actions">
          {items.length > 0 || index.families.length === 0 ? (
            <Button
              className={isDone ? "button" : "button quiet"}
              text={say(isDone ? "lesson.practise" : "lesson.practise-already")}
              disabled={items.length === 0} // until the index is loaded
              onClick={onPractise}
            />
          ) : null}
          <NextLesson lesson={lesson} isQuiet />
        </p>
        {items.length > 0 ? <Offline title={say("offline.lesson")} problems={problems} /> : null}
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        {Arm ? (
          <Arm
            key={lesson.id}
            robot={record.robot}
            symbols={record.symbols}
            firstPose={firstPose}
            factors={lesson.arm === "plain" ? undefined : record.factors} // its only one would give away what is asked
            layers={lesson.layers}
            unknown={lesson.unknown ?? undefined}
            pane={lesson.pane}
            onStage={setStage}
            overlay={overlay}
            rates={tool === "force" ? undefined : (ratesAt ?? undefined)}
          />
        ) : null}
      </section>
    </div>
  );
}

/** Return the pose in which a lesson shows its arm first. */
function firstPoseOf({ start }: Lesson, { robot, pose }: ArmRecord): NamedPose {
  if (!start) return pose;
  return Object.fromEntries(robot.joints.map((joint, i) => [nameJoint(joint, i), (start[i]! * Math.PI) / 180]));
}

type PredictionProps = Pick<LessonProps, "lesson" | "skill"> & { readonly onPredict: (option: number) => void };

/** The question before anything moves. Once its goal is reached, the prediction comes back with what happened. */
function PredictionBox({ lesson, skill, onPredict }: PredictionProps): JSX.Element {
  const { question, options, right, goal, outcome } = lesson.prediction;
  const { predicted, goals } = skill;
  const name = useId();
  const isSettled = goals.includes(goal);
  const chosen = predicted === undefined ? undefined : options[predicted];
  return (
    <fieldset class="prediction" disabled={isSettled}>
      <legend>
        <strong>{say("lesson.predict")}</strong> <Rich text={say(question)} />
      </legend>
      {options.map((text, i) => (
        <label key={text}>
          <input type="radio" name={name} checked={i === predicted} onChange={() => onPredict(i)} />
          <span>
            <Rich text={say(text)} />
          </span>
        </label>
      ))}
      <p role="status">
        {isSettled ? (
          <>
            {chosen ? (
              <Rich
                text={`${say(predicted === right ? "lesson.predicted-right" : "lesson.predicted-wrong", { option: say(chosen) })} `}
              />
            ) : null}
            <Rich text={say(outcome)} />
          </>
        ) : chosen ? (
          say("lesson.predicted-now-try")
        ) : null}
      </p>
    </fieldset>
  );
}

type ExplanationProps = { readonly lesson: Lesson; readonly arm: ArmModel | null; readonly isOpen: boolean };

/** The formula and its reason, with a figure and an example; closed until all goals are reached. */
function Explanation({ lesson, arm, isOpen }: ExplanationProps): JSX.Element {
  const [first, ...others] = lesson.idea;
  const [wasOpened, setOpened] = useState(isOpen); // before, its formulas are not typeset
  return (
    <details class="explanation" open={isOpen} onToggle={({ currentTarget: { open } }) => open && setOpened(true)}>
      <summary>{say("lesson.explanation")}</summary>
      {wasOpened ? (
        <>
          <p>
            <Rich text={say(first!)} />
          </p>
          {arm ? <Sketch arm={arm} degrees={lesson.sketch} tool={lesson.tool} /> : null}
          {others.map((text) => (
            <p key={text}>
              <Rich text={say(text)} />
            </p>
          ))}
          <p class="worked-example">
            <strong>{say("lesson.example")}</strong> <Rich text={say(lesson.example)} />
          </p>
        </>
      ) : null}
    </details>
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

type StandingProps = Pick<LessonProps, "lesson" | "skill"> & Classes & { readonly classIndex: number };

/** The class of arms that is practised, and how many answers are right in a row. */
function Standing({ lesson, skill, classes, classIndex }: StandingProps): JSX.Element {
  const { name, items } = classes[classIndex]!;
  const streak = findStreak(skill, classes, classIndex);
  return (
    <>
      <p class="muted" role="status">
        {classes.length > 1 ? (
          <>
            <strong class="class-name">{say(`classes.${name}`)}</strong> ·{" "}
          </>
        ) : null}
        {streak.mastered !== undefined
          ? say("lesson.mastered")
          : streak.learned !== undefined
            ? say(isDue(streak, Date.now()) ? "lesson.due" : "lesson.learned")
            : say("lesson.row", { count: streak.row.length, needed: countNeededArms(items) })}
      </p>
      {skill.learned !== undefined ? (
        <p class="actions">
          <NextLesson lesson={lesson} isQuiet={false} />
        </p>
      ) : null}
    </>
  );
}
