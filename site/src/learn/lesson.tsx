// A lesson: an idea to try on the arm with goals to reach, then practice until it is learned.

import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import { Arm } from "../arm/panel.js";
import type { State } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import { ZERO } from "../arm/vector.js";
import type { View } from "../arm/view.js";
import type { Index } from "../bank.js";
import type { Told } from "../pages/live.js";
import { attempted, type Item, nameOf } from "../practice/choice.js";
import { Current } from "../practice/current.js";
import { Rich } from "../practice/math.js";
import { keep, kept } from "../practice/progress.js";
import { storage } from "../storage.js";
import { Offline } from "../offline/offline.js";
import { type Message, said, say } from "../text/text.js";
import { classesOf, currentClass, rowOf, type Stretch, withRow } from "../practice/classes.js";
import { Dots } from "./dots.js";
import { type Lesson, LESSONS } from "./lessons.js";
import { answered, armsIn, isDue, NEEDED, NEW, nextIn, outcomeOf, type Skill } from "../practice/skills.js";
import { DialBoard, FIRST_DIALS, ratesOf, Shares, velocityOf } from "./tools.js";

export interface LessonProps {
  readonly lesson: Lesson;
  readonly told: Told;
  readonly index: Index;
  readonly skill: Skill;
  readonly practising: boolean;
  readonly onSkill: (skill: Skill) => void;
}

export function LessonView(props: LessonProps): JSX.Element {
  const { lesson, index } = props;
  const [practising, setPractising] = useState(props.practising);
  const classes = useMemo(() => classesOf(index, lesson), [index, lesson]);
  const items = useMemo(() => classes.flatMap(({ items }) => items), [classes]);
  return practising && items.length > 0 ? (
    <Practice {...props} classes={classes} arrived={!props.practising} onIdea={() => setPractising(false)} />
  ) : (
    <Idea {...props} classes={classes} items={items} onPractise={() => setPractising(true)} />
  );
}

type Classes = { readonly classes: readonly Stretch[] };

/** Which lesson this is, and the way to the others. */
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
  const { lesson, told, skill, classes, items, onSkill, onPractise } = props;
  const [stage, setStage] = useState<Stage | null>(null);
  const problems = useMemo(() => items.map(({ family, key }) => `${family}/${key}`), [items]);
  const [dials, setDials] = useState(FIRST_DIALS);
  const { tool, goals } = lesson;
  const rates = stage ? ratesOf(tool, dials, stage.state) : [];
  const velocity = stage ? velocityOf(stage.arm, stage.state, rates) : ZERO;
  const reached = stage ? goals.flatMap(({ reached }, i) => (reached({ stage, rates, velocity }) ? [i] : [])) : [];
  const moved = useRef(false); // the arm as it stands first reaches nothing
  const first = useRef("");
  const hasPath = useRef(false); // nor does the path as it is laid first
  useEffect(() => {
    if (!stage) return;
    const now = JSON.stringify([stage.pose, dials, stage.welding?.place, stage.welding?.weld]);
    const isLaid = stage.welding !== null && !hasPath.current;
    if (!first.current || isLaid) [first.current, moved.current] = [now, false];
    if (isLaid) hasPath.current = true;
    if (now !== first.current) moved.current = true;
    const fresh = reached.filter((i) => !skill.goals.includes(i));
    if (moved.current && fresh.length > 0) onSkill({ ...skill, goals: [...skill.goals, ...fresh] });
  });
  const over = useMemo(
    () =>
      tool
        ? (now: Stage, view: View) => <Shares stage={now} view={view} rates={ratesOf(tool, dials, now.state)} />
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
          <Onward lesson={lesson} quiet />
        </p>
        {items.length > 0 ? <Offline title={say("offline.lesson")} problems={problems} /> : null}
      </article>
      <section class="stage" aria-label={say("practice.move")}>
        <Arm
          key={lesson.id}
          robot={told.robot}
          symbols={told.symbols}
          first={told.pose}
          factors={told.factors}

          layers={lesson.layers}
          pane={lesson.pane}
          onStage={setStage}
          over={over}
          rates={ratesIn}
        />
      </section>
    </div>
  );
}

/** The way to the next lesson. */
function Onward({ lesson, quiet }: { lesson: Lesson; quiet: boolean }): JSX.Element | null {
  const next = LESSONS[LESSONS.indexOf(lesson) + 1];
  return next ? (
    <a class={quiet ? "button quiet" : "button"} href={`learn.html?lesson=${next.id}`}>
      {say("lesson.next", { title: say(next.title) })}
    </a>
  ) : null;
}

function Practice(props: LessonProps & Classes & { arrived: boolean; onIdea: () => void }): JSX.Element {
  const { lesson, index, skill, classes, arrived, onSkill, onIdea } = props;
  /** The question that is asked next, and the class whose arm it is about. */
  const drawn = (): { at: number; item: Item | null } => {
    const at = currentClass(skill, classes, Date.now());
    const item = nextIn(classes[at]!.items, rowOf(skill, classes, at), asked.current, Math.random);
    if (item) asked.current.push(nameOf(item));
    return { at, item };
  };
  const asked = useRef<string[]>([]);
  const [{ at, item }, setCurrent] = useState(drawn);
  const [count, setCount] = useState(0);
  const [note, setNote] = useState<Message | null>(null);
  const again = useRef(false); // whether this question was answered before
  const most = armsIn(classes[at]!.items);
  const row = rowOf(skill, classes, at);
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
          {row.mastered !== undefined
            ? say("lesson.mastered")
            : row.learned !== undefined
              ? say(isDue(row, Date.now()) ? "lesson.due" : "lesson.learned")
              : say("lesson.row", { count: row.row.length, needed: Math.min(NEEDED, most) })}
        </p>
        {skill.learned !== undefined ? (
          <p class="actions">
            <Onward lesson={lesson} quiet={false} />
          </p>
        ) : null}
      </div>
      {item ? (
        <Current
          key={`${nameOf(item)} ${count}`}
          item={item}
          level={index.feedback}
          arrived={arrived || count > 0}
          notes={note ? [said(note)] : []}
          onVerdict={(right, helped) => {
            const now = Date.now();
            const how = { right, helped, again: again.current, most };
            const after = answered(row, item, { ...how, now });
            again.current = true;
            setNote(outcomeOf(row, after, how));
            onSkill(withRow(skill, classes, at, after));
            keep(storage, attempted(kept(storage), item, right, now)); // what is wrong comes again where one practises
          }}
          onNext={() => {
            again.current = false;
            setNote(null);
            setCurrent(drawn());
            setCount(count + 1);
          }}
        />
      ) : null}
    </div>
  );
}

export { NEW };
