// One question about an arm: the arm to move, the prompt, the fields for the answer, the verdict, and hints.

import type { ComponentChildren, JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import type { ArmProps } from "../arm/panel.js";
import { Words } from "../arm/letters.js";
import { type AskedPart, type AskedProblem, nameJoint } from "../bank.js";
import { Button } from "../controls.js";
import { afterPaint, useSteps } from "../scheduling.js";
import { getLanguage, say } from "../text/text.js";
import { Answer, Preview } from "./answer.js";
import { useArm } from "./arm-part.js";
import { bringIntoView } from "./in-view.js";
import { Html } from "./math.js";
import { removeOptions } from "./prompt.js";

export interface QuestionProps extends Pick<ArmProps, "pose" | "overlay" | "factors" | "unknown"> {
  /** Identifies the question on the page. */
  readonly name: string;
  readonly problem: AskedProblem;
  readonly part: AskedPart;
  /** Whether the page moved here from another question. */
  readonly hasArrived: boolean;
  /** Whether the question is still to be answered: the arm then shows nothing that reveals the answer. */
  readonly isOpen: boolean;
  /** Whether nothing is left to do, so that the next question is the main way on. */
  readonly isDone: boolean;
  /** Why nothing can be submitted; undefined or false if it can. */
  readonly isClosed?: boolean;
  readonly checkText: string;
  readonly nextText: string;
  /** The text of the answer so far, if the page stores it. */
  readonly storedText?: string;
  readonly answer: string;
  readonly onAnswer: (text: string) => void;
  readonly onCheck: () => void;
  readonly onNext: () => void;
  /** Called when the fields get the focus. */
  readonly onStart?: () => void;
  /** Why the answer could not be judged, "" if it could. */
  readonly error: string;
  /** Shown between the answer and its verdict. */
  readonly notice?: ComponentChildren;
  readonly verdict: ComponentChildren;
  /** Changes with each new verdict, which is then brought into view. */
  readonly verdictNumber: number;
  /** Called before a new verdict is brought into view, after it is on the page. */
  readonly onVerdictShown?: () => void;
  /** Hints and solution. */
  readonly children?: ComponentChildren;
}

export function Question(props: QuestionProps): JSX.Element {
  const {
    problem,
    part,
    hasArrived,
    isOpen,
    isDone,
    isClosed = false,
    verdictNumber,
    pose,
    overlay,
    factors,
    unknown,
  } = props;
  const article = useRef<HTMLElement>(null);
  const verdictPlace = useRef<HTMLDivElement>(null);
  const step = useSteps(3); // the question comes first, because a phone shows little else
  const Arm = useArm(step > 2);
  const isPosed = problem.robot.joints.every((joint, i) => part.pose?.[nameJoint(joint, i)] !== undefined);
  const initialPose = useMemo(() => ({ ...problem.pose, ...part.pose }), [problem, part]);
  const figure = (isPosed && part.figure) || problem.figure; // until the movable arm is loaded
  const lang = problem.lang ?? "en";
  const prompt = removeOptions(part);
  useEffect(() => {
    if (verdictNumber === 0) return;
    afterPaint(() => {
      props.onVerdictShown?.(); // the feedback is on the page before the arm moves
      // a change of the page would end a scroll
      afterPaint(() => verdictPlace.current && bringIntoView(verdictPlace.current));
    });
  }, [verdictNumber]);
  useEffect(() => {
    if (!hasArrived) return;
    article.current?.focus({ preventScroll: true });
    article.current?.scrollIntoView({ block: "start" });
  }, []);
  const answerForm = (
    <>
      <form
        onFocusIn={props.onStart}
        onSubmit={(event) => {
          event.preventDefault();
          props.onCheck();
        }}
      >
        <Answer
          problem={problem}
          part={part}
          storedText={props.storedText}
          onAnswer={props.onAnswer}
          onCheck={props.onCheck}
        />
        <p class="actions">
          <button type="submit" class={isDone ? "quiet" : "button"} aria-disabled={isClosed}>
            {props.checkText}
          </button>
          <Button className={isDone ? "button" : "quiet"} text={props.nextText} onClick={props.onNext} />
        </p>
        <Preview problem={problem} part={part} answer={props.answer} />
      </form>
      {props.error ? <p role="alert">{props.error}</p> : null}
      {props.notice}
      <div role="status" ref={verdictPlace}>
        {props.verdict}
      </div>
      {props.children}
    </>
  );
  return (
    <>
      <article
        class="task"
        data-item={props.name}
        ref={article}
        tabIndex={-1}
        aria-label={`${problem.title}: ${part.title}`}
      >
        <p class="kicker">
          <span lang={lang}>{problem.title}</span>{" "}
          <span class="muted">· {say("practice.points", { difficulty: problem.difficulty })}</span>
        </p>
        <h2 lang={lang}>{part.title}</h2>
        {getLanguage().code === "en" ? null : (
          <p class={problem.lang ? "visually-hidden" : "muted"}>
            {say(problem.lang ? "practice.english-drawings" : "practice.english")}
          </p>
        )}
        <figure class="printed" lang="en" dangerouslySetInnerHTML={{ __html: problem.figure }} />
        <p class="printed">{say("practice.printed-figure")}</p>
        {part.figure ? (
          <figure class={isPosed ? "printed" : ""} lang="en" dangerouslySetInnerHTML={{ __html: part.figure }} />
        ) : null}
        {step > 0 ? <Html html={prompt} class="prompt" lang={problem.lang} /> : null}
        {step > 1 ? (
          <>
            <p class="muted to-given">
              <a href="#given">
                <Words text={say("practice.to-given")} />
              </a>
              {refersToChapter(prompt) ? <>. {say("practice.chapter")}</> : null}
            </p>
            {answerForm}
            <details open class="given" id="given">
              <summary>{say("practice.given")}</summary>
              <Html html={problem.statement} class="statement" lang={problem.lang} />
            </details>
          </>
        ) : null}
      </article>
      <section class="stage" id="arm" aria-label={say("practice.move")}>
        {Arm !== null ? (
          <Arm
            robot={problem.robot}
            symbols={problem.symbols}
            firstPose={initialPose}
            isConcealed={isPosed && isOpen && !PATH_QUESTIONS.has(part.kind)}
            isDeterminantHidden={isOpen && REVEALED_BY_DETERMINANT.has(part.kind)}
            pose={pose}
            overlay={overlay}
            factors={factors}
            unknown={unknown}
            layers={unknown ? FEW_LAYERS : undefined}
          />
        ) : (
          <figure class="drawn" lang="en" dangerouslySetInnerHTML={{ __html: figure }} />
        )}
      </section>
    </>
  );
}

/** The layers while something is unknown. */
const FEW_LAYERS = { ellipse: false };

/** Return whether a text has the number of an equation, such as (6.3). */
const refersToChapter = (html: string): boolean => /\(6\.\d+\)/.test(html);

/** Where the numbers of equations in a text are from, unless a text above the note has such numbers, too. */
const ChapterNote = ({ html, above = "" }: { readonly html: string; readonly above?: string }): JSX.Element | null =>
  refersToChapter(html) && !refersToChapter(above) ? <p class="muted">{say("practice.chapter")}</p> : null;

/** Questions whose answers det J and its map would reveal: they are shown after the answer is right. */
const REVEALED_BY_DETERMINANT: ReadonlySet<string> = new Set([
  ...["singular-angles", "singular-configurations", "singular-angles-choice", "singularity-type"],
]);

/** Questions that begin in a pose, but do not ask about this pose. */
const PATH_QUESTIONS: ReadonlySet<string> = new Set(["path-rates"]);

/** The hints on a part, shown one by one. */
export function Hints({ part, lang, onHint, children }: HintsProps): JSX.Element {
  const [hintCount, setHintCount] = useState(0);
  const isMore = hintCount < part.hints.length;
  const shownHints = part.hints.slice(0, hintCount);
  return (
    <>
      {shownHints.map((hint, i) => (
        <div class="hint" key={i}>
          <h3>{say("practice.hint", { number: i + 1 })}</h3>
          <Html html={hint} lang={lang} />
        </div>
      ))}
      <ChapterNote html={shownHints.join()} above={removeOptions(part)} />
      <p class="actions">
        {isMore ? (
          <Button
            text={say("practice.more-hints", { number: hintCount + 1 })}
            onClick={() => {
              onHint?.();
              setHintCount(hintCount + 1);
            }}
          />
        ) : null}
        {children}
      </p>
    </>
  );
}

interface HintsProps {
  readonly part: AskedPart;
  readonly lang: string | undefined;
  readonly onHint?: () => void;
  /** Buttons beside that for the next hint. */
  readonly children?: ComponentChildren;
}

/** The worked solution of a part, and the answer as it is typed. */
export function Solution({ solution, figure = "", typed, lang, above }: SolutionProps): JSX.Element {
  return (
    <div class="solution">
      <h3>{say("practice.solution-title")}</h3>
      <Html html={solution} lang={lang} />
      <ChapterNote html={solution} above={above ?? ""} />
      {figure ? <figure lang="en" dangerouslySetInnerHTML={{ __html: figure }} /> : null}
      <details>
        <summary>{say("practice.typed")}</summary>
        <pre>
          <code>{typed}</code>
        </pre>
      </details>
    </div>
  );
}

export interface SolutionProps {
  readonly solution: string;
  readonly figure?: string;
  readonly typed: string;
  readonly lang?: string | undefined;
  /** The prompt and the hints that are on the page. */
  readonly above?: string;
}
