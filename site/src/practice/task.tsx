// One problem: the arm, the question, the answer, the feedback, hints and the solution.

import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import type * as Panel from "../arm/panel.js";
import { Words } from "../arm/letters.js";
import { createSingularityTest } from "../arm/is-singular.js";
import type { Stage } from "../arm/stage.js";
import type { View } from "../arm/view.js";
import { type Factor, nameJoint, type Part, type Problem, type Solutions } from "../bank.js";
import { isAtLeast, chooseLowerLevel, type Level, limitVerdict } from "../grade/levels.js";
import type { ColumnsAt } from "../grade/typed-jacobian.js";
import { isParsed, type Verdict } from "../grade/verdict.js";
import { loadSolutions } from "../load.js";
import type { SymbolValues } from "../read/tree.js";
import { getLanguage, say } from "../text/text.js";
import { afterPaint, describeLoadError, useSteps } from "../scheduling.js";
import { bringIntoView } from "./in-view.js";
import { Answer, Preview } from "./answer.js";
import { type Item, nameItem } from "./choice.js";
import { Feedback, findPose } from "./feedback.js";
import { Html } from "./math.js";
import { TypedColumns } from "./typed-columns.js";
import { removeOptions } from "./prompt.js";

/** The movable arm; or a message if it could not be loaded, because practice works without it. */
type ArmPart = typeof Panel.Arm | typeof NoArm;
let armComponent: ArmPart | null = null;

/** Return the movable arm once it is wanted and loaded, else null. */
function useArm(isWanted: boolean): ArmPart | null {
  const [, setLoaded] = useState(armComponent !== null);
  useEffect(() => {
    if (!isWanted || armComponent !== null) return;
    let isMounted = true;
    void import("../arm/panel.js")
      .then(
        ({ Arm }) => (armComponent = Arm),
        () => (armComponent = NoArm),
      )
      .then(() => isMounted && setLoaded(true));
    return () => void (isMounted = false);
  }, [isWanted]);
  return isWanted ? armComponent : null;
}

const NoArm = () => (
  <p role="status" class="stage-failed">
    {say("practice.arm-failed")}
  </p>
);
const loadGrading = () => import("../grade/judge.js");

/** An answer with its verdict. */
export type JudgedPart = { readonly part: Part; readonly answer: string; readonly verdict: Verdict };

export interface TaskProps {
  readonly item: Item;
  readonly problem: Problem;
  readonly part: Part;
  readonly level: Level;
  /** The highest level of feedback while another try may still earn points. */
  readonly maxLevel?: Level;
  readonly hasArrived: boolean;
  /** Whether the question is closed: the solution may be shown, and nothing more is checked. */
  readonly isClosed?: boolean;
  /** Whether the factors of det J may be shown, unless they reveal this very answer. */
  readonly mayShowFactors?: boolean;
  /** Sentences on the answer's effect on the progress, shown below the verdict. */
  readonly notes?: readonly string[];
  /** Called with whether a parsed answer is right, whether hints or the solution were shown, and the judged answer. */
  readonly onVerdict: (isRight: boolean, isHelped: boolean, judged: JudgedPart) => void;
  /** Called if the solution is shown before the answer is right. */
  readonly onSolution?: () => void;
  readonly onNext: () => void;
}

export function Task(props: TaskProps): JSX.Element {
  const { item, problem, part, level, maxLevel = level, hasArrived, isClosed = false, mayShowFactors = true } = props;
  const { notes, onVerdict, onSolution, onNext } = props;
  const [answer, setAnswer] = useState("");
  const [verdict, setVerdict] = useState<Verdict | null>(null);
  const [loadError, setLoadError] = useState("");
  const [pose, setPose] = useState<SymbolValues | undefined>(undefined);
  const [typedColumns, setTypedColumns] = useState<ColumnsAt | null>(null);
  const [isSolutionShown, setSolutionShown] = useState(false); // an answer after the solution was shown does not count
  const hasSeenHints = useRef(false);
  const isPrepared = useRef(false);
  const lastJudged = useRef<string | null>(null);
  const article = useRef<HTMLElement>(null);
  const verdictPlace = useRef<HTMLDivElement>(null);
  const step = useSteps(3); // the question comes first, because a phone shows little else
  const Arm = useArm(step > 2);
  const isPosed = problem.robot.joints.every((joint, i) => part.pose?.[nameJoint(joint, i)] !== undefined);
  const initialPose = useMemo(() => ({ ...problem.pose, ...part.pose }), [problem, part]);
  const figure = (isPosed && part.figure) || problem.figure; // until the movable arm is loaded
  const isOpen = !isClosed && verdict?.outcome !== "correct" && !isSolutionShown; // still to be answered
  const wouldReveal = REVEALED_BY_FACTORS.has(part.kind) && verdict?.outcome !== "correct" && !isSolutionShown;
  const drawnColumns = answer === lastJudged.current ? typedColumns : null; // of no answer that was changed since
  const overlay = useMemo(
    () =>
      drawnColumns
        ? (stage: Stage, view: View) => <TypedColumns stage={stage} view={view} columns={drawnColumns} />
        : undefined,
    [drawnColumns],
  );
  const [factors, setFactors] = useState<readonly Factor[]>([]);
  const showsFactors = step === 3 && mayShowFactors && !wouldReveal && isAtLeast(level, "solutions");
  useEffect(() => {
    if (!showsFactors) return;
    loadSolutions(item.family, item.key).then(
      (solutions) => setFactors(solutions.factors),
      () => undefined, // without a connection, the stage has no factors
    );
  }, [showsFactors]);
  const isSingular = useMemo(() => createSingularityTest(problem), [problem]);
  /** Load the grading code before there is an answer, and run it once: the first run takes ten times as long. */
  const prepare = () => {
    if (isPrepared.current) return;
    isPrepared.current = true;
    const firstRun = loadGrading().then(({ judge }) => judge(problem, part, "sin(1)/2", isSingular));
    void firstRun.catch(() => undefined); // Check reports if it can't be loaded
  };
  const check = async () => {
    if (isClosed) return;
    setLoadError("");
    const grading = await loadGrading().catch((error: unknown) => setLoadError(describeLoadError(error)));
    if (!grading) return;
    const fullVerdict = grading.judge(problem, part, answer, isSingular);
    const shownVerdict = limitVerdict(fullVerdict, chooseLowerLevel(level, maxLevel));
    setVerdict(shownVerdict);
    const isDrawn =
      fullVerdict.outcome !== "correct" && fullVerdict.outcome !== "missing" && isAtLeast(level, "counterexample");
    const columns = isDrawn ? grading.parseTypedColumns(problem, part, answer) : null;
    setTypedColumns(() => columns);
    const isNew = answer !== lastJudged.current && !(isSolutionShown && fullVerdict.outcome === "correct");
    lastJudged.current = answer;
    if (isParsed(fullVerdict) && isNew)
      onVerdict(fullVerdict.outcome === "correct", hasSeenHints.current || isSolutionShown, {
        part,
        answer,
        verdict: fullVerdict,
      });
    afterPaint(() => {
      setPose(findPose(problem, shownVerdict)); // the feedback is on the page before the arm moves
      // a change of the page would end a scroll
      afterPaint(() => verdictPlace.current && bringIntoView(verdictPlace.current));
    });
  };
  useEffect(() => {
    if (!hasArrived) return;
    article.current?.focus({ preventScroll: true });
    article.current?.scrollIntoView({ block: "start" });
  }, []);
  const isDone = isClosed || verdict?.outcome === "correct";
  const answerForm = (
    <>
      <form
        onFocusIn={prepare}
        onSubmit={(event) => {
          event.preventDefault();
          void check();
        }}
      >
        <Answer problem={problem} part={part} onAnswer={setAnswer} onCheck={() => void check()} />
        <p class="actions">
          <button type="submit" class={isDone ? "quiet" : "button"} aria-disabled={isClosed}>
            {say("practice.check")}
          </button>
          <Button
            className={isDone ? "button" : "quiet"}
            text={say(isDone ? "practice.next" : "practice.skip")}
            onClick={onNext}
          />
        </p>
        <Preview problem={problem} part={part} answer={answer} />
      </form>
      {loadError ? <p role="alert">{loadError}</p> : null}
      <div role="status" ref={verdictPlace}>
        {verdict ? (
          <Feedback problem={problem} verdict={verdict} isDrawn={drawnColumns !== null} notes={notes} />
        ) : null}
      </div>
      <Help
        item={item}
        part={part}
        lang={problem.lang}
        hasSolutions={isAtLeast(level, "solutions")}
        isSolved={isDone}
        onHint={() => (hasSeenHints.current = true)}
        onSolution={() => {
          setSolutionShown(verdict?.outcome !== "correct");
          if (verdict?.outcome !== "correct") onSolution?.();
        }}
      />
    </>
  );
  return (
    <>
      <article
        class="task"
        data-item={nameItem(item)}
        ref={article}
        tabIndex={-1}
        aria-label={`${problem.title}: ${part.title}`}
      >
        <p class="kicker">
          <span lang={problem.lang ?? "en"}>{problem.title}</span>{" "}
          <span class="muted">· {say("practice.points", { difficulty: problem.difficulty })}</span>
        </p>
        <h2 lang={problem.lang ?? "en"}>{part.title}</h2>
        {getLanguage().code === "en" ? null : (
          <p class={problem.lang ? "visually-hidden" : "muted"}>
            {say(problem.lang ? "practice.english-drawings" : "practice.english")}
          </p>
        )}
        <figure class="printed" lang="en" dangerouslySetInnerHTML={{ __html: problem.figure }} />
        {part.figure ? (
          <figure class={isPosed ? "printed" : ""} lang="en" dangerouslySetInnerHTML={{ __html: part.figure }} />
        ) : null}
        {step > 0 ? <Html html={removeOptions(part)} class="prompt" lang={problem.lang} /> : null}
        {step > 1 ? (
          <>
            <p class="muted to-given">
              <a href="#given">
                <Words text={say("practice.to-given")} />
              </a>
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
            isMapHidden={isOpen && REVEALED_BY_MAP.has(part.kind)}
            pose={pose}
            overlay={overlay}
            factors={factors}
          />
        ) : (
          <figure class="drawn" lang="en" dangerouslySetInnerHTML={{ __html: figure }} />
        )}
      </section>
    </>
  );
}

/** Questions whose answers the map of det J would reveal: it is shown after they are answered. */
const REVEALED_BY_MAP: ReadonlySet<string> = new Set([
  ...["singular-angles", "singular-configurations", "singular-angles-choice", "singularity-type"],
]);

/** Questions whose answers the factors of det J would reveal: they are shown after it is solved. */
const REVEALED_BY_FACTORS: ReadonlySet<string> = new Set([
  ...["determinant", "inverse-jacobian", "inverse-velocity", "joint-rates", "manipulability"],
  ...["singular-angles", "singularity-type", "singularity-meaning", "rank", "invertibility"],
  ...["arm-block", "wrist-block", "block-determinants"],
]);

/** Questions that begin in a pose, but do not ask about this pose. */
const PATH_QUESTIONS: ReadonlySet<string> = new Set(["path-rates", "path-limit"]);

interface HelpProps {
  readonly item: Item;
  readonly part: Part;
  readonly lang: string | undefined;
  /** Whether the bank has solutions. */
  readonly hasSolutions: boolean;
  readonly isSolved: boolean;
  readonly onHint: () => void;
  readonly onSolution: () => void;
}

function Help({ item, part, lang, hasSolutions, isSolved, onHint, onSolution }: HelpProps) {
  const [hintCount, setHintCount] = useState(0);
  const [solution, setSolution] = useState<(Solutions["parts"][number] & { lang?: string | undefined }) | null>(null);
  const [loadError, setLoadError] = useState("");
  const showSolution = () => {
    onSolution();
    loadSolutions(item.family, item.key).then(
      ({ parts, lang }) => {
        const solvedPart = parts.find(({ name }) => name === part.name);
        setSolution(solvedPart ? { ...solvedPart, lang } : null);
      },
      (error: unknown) => setLoadError(describeLoadError(error)),
    );
  };
  return (
    <section class="help-steps">
      {part.hints.slice(0, hintCount).map((hint, i) => (
        <div class="hint" key={i}>
          <h3>{say("practice.hint", { number: i + 1 })}</h3>
          <Html html={hint} lang={lang} />
        </div>
      ))}
      <p class="actions">
        {hintCount < part.hints.length ? (
          <Button
            text={say("practice.more-hints", { number: hintCount + 1 })}
            onClick={() => {
              onHint();
              setHintCount(hintCount + 1);
            }}
          />
        ) : null}
        {hasSolutions && solution === null && (isSolved || hintCount > 0) ? (
          <Button text={say("practice.solution")} onClick={showSolution} />
        ) : null}
      </p>
      {loadError ? <p role="alert">{loadError}</p> : null}
      {solution ? (
        <div class="solution">
          <h3>{say("practice.solution-title")}</h3>
          <Html html={solution.solution} lang={solution.lang} />
          {solution.figure ? <figure lang="en" dangerouslySetInnerHTML={{ __html: solution.figure }} /> : null}
          <details>
            <summary>{say("practice.typed")}</summary>
            <pre>
              <code>{solution.typed}</code>
            </pre>
          </details>
        </div>
      ) : null}
    </section>
  );
}
