// One problem: the arm, the question, the answer, what is said of it, hints and the solution.

import type { JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import type * as Panel from "../arm/panel.js";
import { singularIn } from "../arm/singular.js";
import type { Stage } from "../arm/stage.js";
import type { View } from "../arm/view.js";
import type { Factor, Part, Problem, Solutions } from "../bank.js";
import { atLeast, lower, type Level, told } from "../grade/levels.js";
import type { OwnColumns } from "../grade/own.js";
import { type At, isRead, type Verdict } from "../grade/verdict.js";
import { loadSolutions } from "../load.js";
import { language, say } from "../text/text.js";
import { afterPaint, useSteps } from "../later.js";
import { bringIntoView } from "./in-view.js";
import { Answer, Preview } from "./answer.js";
import { type Item, nameOf } from "./choice.js";
import { Feedback, nameOfJoint, poseOf } from "./feedback.js";
import { Html } from "./math.js";
import { Own } from "./own.js";
import { promptOf } from "./prompt.js";

/** The arm that moves, or what says that there is none: practising goes on without it. */
type ArmPart = typeof Panel.Arm | typeof NoArm;
let arm: ArmPart | null = null;

/** The arm that moves as soon as it is wanted and there. */
function useArm(wanted: boolean): ArmPart | null {
  const [, setThere] = useState(arm !== null);
  useEffect(() => {
    if (!wanted || arm !== null) return;
    let here = true;
    void import("../arm/panel.js")
      .then(
        ({ Arm }) => (arm = Arm),
        () => (arm = NoArm),
      )
      .then(() => here && setThere(true));
    return () => void (here = false);
  }, [wanted]);
  return wanted ? arm : null;
}

const NoArm = () => (
  <p role="status" class="stage-failed">
    {say("practice.arm-failed")}
  </p>
);
const grading = () => import("../grade/judge.js");

/** An answer as it was judged. */
export type Judged = { readonly part: Part; readonly answer: string; readonly verdict: Verdict };

export interface TaskProps {
  readonly item: Item;
  readonly problem: Problem;
  readonly part: Part;
  readonly level: Level;
  /** What a verdict tells at most, where there is something to be had from another try. */
  readonly judgedAt?: Level;
  readonly arrived: boolean;
  /** Whether it is answered for good: the solution may be seen, and nothing more is checked. */
  readonly closed?: boolean;
  /** Whether the factors of det J may be shown, where they don't tell this very answer. */
  readonly factored?: boolean;
  /** What is said below a verdict of what comes of it. */
  readonly notes?: readonly string[];
  /** Told whether a readable answer is right, whether hints or the solution were seen, and how it was judged. */
  readonly onVerdict: (right: boolean, helped: boolean, judged: Judged) => void;
  /** Told that the solution is seen before the answer is right. */
  readonly onSolution?: () => void;
  readonly onNext: () => void;
}

export function Task(props: TaskProps): JSX.Element {
  const { item, problem, part, level, judgedAt = level, arrived, closed = false, factored = true } = props;
  const { notes, onVerdict, onSolution, onNext } = props;
  const [answer, setAnswer] = useState("");
  const [verdict, setVerdict] = useState<Verdict | null>(null);
  const [failed, setFailed] = useState("");
  const [pose, setPose] = useState<At | undefined>(undefined);
  const [own, setOwn] = useState<OwnColumns | null>(null);
  const [helped, setHelped] = useState(false); // what was copied from the solution is no success
  const hinted = useRef(false);
  const prepared = useRef(false);
  const judged = useRef<string | null>(null);
  const start = useRef<HTMLElement>(null);
  const verdictPlace = useRef<HTMLDivElement>(null);
  const step = useSteps(3); // the question first: a phone shows little else
  const Arm = useArm(step > 2);
  const isPosed = problem.robot.joints.every((joint, i) => part.pose?.[nameOfJoint(joint, i)] !== undefined);
  const first = useMemo(() => ({ ...problem.pose, ...part.pose }), [problem, part]);
  const figure = (isPosed && part.figure) || problem.figure;
  const isOpen = !closed && verdict?.outcome !== "correct" && !helped; // still to be answered
  const hidden = TOLD_BY_FACTORS.has(part.kind) && verdict?.outcome !== "correct" && !helped;
  const over = useMemo(
    () => (own ? (stage: Stage, view: View) => <Own stage={stage} view={view} columns={own} /> : undefined),
    [own],
  );
  const [factors, setFactors] = useState<readonly Factor[]>([]);
  const isShown = step === 3 && factored && !hidden && atLeast(level, "solutions");
  useEffect(() => {
    if (!isShown) return;
    loadSolutions(item.family, item.key).then(
      (solutions) => setFactors(solutions.factors),
      () => undefined, // without a connection the stage does without them
    );
  }, [isShown]);
  const isSingular = useMemo(() => singularIn(problem), [problem]);
  /** Load grading before there is an answer, and try it once: the first run takes ten times as long. */
  const prepare = () => {
    if (prepared.current) return;
    prepared.current = true;
    const tried = grading().then(({ judge }) => judge(problem, part, "sin(1)/2", isSingular));
    void tried.catch(() => undefined); // Check says so, where it can't be loaded
  };
  const check = async () => {
    if (closed) return;
    setFailed("");
    const loaded = await grading().catch((error: unknown) => setFailed(String(error)));
    if (!loaded) return;
    const found = loaded.judge(problem, part, answer, isSingular);
    const shown = told(found, lower(level, judgedAt));
    setVerdict(shown);
    const isDrawn = found.outcome !== "correct" && found.outcome !== "missing" && atLeast(level, "counterexample");
    const columns = isDrawn ? loaded.ownColumns(problem, part, answer) : null;
    setOwn(() => columns);
    const isNew = answer !== judged.current && !(helped && found.outcome === "correct");
    judged.current = answer;
    if (isRead(found) && isNew)
      onVerdict(found.outcome === "correct", hinted.current || helped, { part, answer, verdict: found });
    afterPaint(() => {
      setPose(poseOf(problem, shown)); // what is said of the answer is there before the arm goes
      // what changes meanwhile ends a scroll
      afterPaint(() => verdictPlace.current && bringIntoView(verdictPlace.current));
    });
  };
  useEffect(() => {
    if (!arrived) return;
    start.current?.focus({ preventScroll: true });
    start.current?.scrollIntoView({ block: "start" });
  }, []);
  const isDone = closed || verdict?.outcome === "correct";
  const answering = (
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
          <button type="submit" class={isDone ? "quiet" : "button"} aria-disabled={closed}>
            {say("practice.check")}
          </button>
          <Button
            style={isDone ? "button" : "quiet"}
            text={say(isDone ? "practice.next" : "practice.skip")}
            onClick={onNext}
          />
        </p>
        <Preview problem={problem} part={part} answer={answer} />
      </form>
      {failed ? <p role="alert">{say("practice.failed", { why: failed })}</p> : null}
      <div role="status" ref={verdictPlace}>
        {verdict ? <Feedback problem={problem} verdict={verdict} isDrawn={own !== null} notes={notes} /> : null}
      </div>
      <Help
        item={item}
        part={part}
        lang={problem.lang}
        solvable={atLeast(level, "solutions")}
        solved={isDone}
        onHint={() => (hinted.current = true)}
        onSolution={() => {
          setHelped(verdict?.outcome !== "correct");
          if (verdict?.outcome !== "correct") onSolution?.();
        }}
      />
    </>
  );
  return (
    <>
      <article
        class="task"
        data-item={nameOf(item)}
        ref={start}
        tabIndex={-1}
        aria-label={`${problem.title}: ${part.title}`}
      >
        <p class="kicker">
          <span lang={problem.lang ?? "en"}>{problem.title}</span>{" "}
          <span class="muted">· {say("practice.points", { difficulty: problem.difficulty })}</span>
        </p>
        <h2 lang={problem.lang ?? "en"}>{part.title}</h2>
        {language().code === "en" ? null : (
          <p class={problem.lang ? "visually-hidden" : "muted"}>
            {say(problem.lang ? "practice.english-drawings" : "practice.english")}
          </p>
        )}
        <figure class="printed" lang="en" dangerouslySetInnerHTML={{ __html: problem.figure }} />
        {part.figure ? (
          <figure class={isPosed ? "printed" : ""} lang="en" dangerouslySetInnerHTML={{ __html: part.figure }} />
        ) : null}
        {step > 0 ? <Html html={promptOf(part)} class="prompt" lang={problem.lang} /> : null}
        {step > 1 ? (
          <>
            <p class="muted to-given">
              <a href="#given">{say("practice.to-given")}</a>
            </p>
            {answering}
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
            first={first}
            concealed={isPosed && isOpen && !ALONG_A_PATH.has(part.kind)}
            pose={pose}
            over={over}
            factors={factors}
          />
        ) : (
          <Drawn figure={figure} />
        )}
      </section>
    </>
  );
}

/** Questions whose answers the factors of det J would tell: there they are shown once it is solved. */
const TOLD_BY_FACTORS: ReadonlySet<string> = new Set([
  ...["determinant", "inverse-jacobian", "inverse-velocity", "joint-rates", "manipulability"],
  ...["singular-angles", "singularity-type", "singularity-meaning", "rank", "invertibility"],
  ...["arm-block", "wrist-block", "block-determinants"],
]);

/** Questions that begin in a pose, and ask nothing of it. */
const ALONG_A_PATH: ReadonlySet<string> = new Set(["path-rates", "path-limit"]);

/** The printed figure in the stage's place, until the arm that moves has come. */
function Drawn({ figure }: { figure: string }) {
  return <figure class="drawn" lang="en" dangerouslySetInnerHTML={{ __html: figure }} />;
}

// --- hints and solution ---

interface HelpProps {
  readonly item: Item;
  readonly part: Part;
  readonly lang: string | undefined;
  /** Whether the bank has solutions. */
  readonly solvable: boolean;
  readonly solved: boolean;
  readonly onHint: () => void;
  readonly onSolution: () => void;
}

function Help({ item, part, lang, solvable, solved, onHint, onSolution }: HelpProps) {
  const [hints, setHints] = useState(0);
  const [solution, setSolution] = useState<(Solutions["parts"][number] & { lang?: string | undefined }) | null>(null);
  const [failed, setFailed] = useState("");
  const show = () => {
    onSolution();
    loadSolutions(item.family, item.key).then(
      ({ parts, lang }) => {
        const found = parts.find(({ name }) => name === part.name);
        setSolution(found ? { ...found, lang } : null);
      },
      (error: unknown) => setFailed(String(error)),
    );
  };
  return (
    <section class="help-steps">
      {part.hints.slice(0, hints).map((hint, i) => (
        <div class="hint" key={i}>
          <h3>{say("practice.hint", { number: i + 1 })}</h3>
          <Html html={hint} lang={lang} />
        </div>
      ))}
      <p class="actions">
        {hints < part.hints.length ? (
          <Button
            text={say("practice.more-hints", { number: hints + 1 })}
            onClick={() => {
              onHint();
              setHints(hints + 1);
            }}
          />
        ) : null}
        {solvable && solution === null && (solved || hints > 0) ? (
          <Button text={say("practice.solution")} onClick={show} />
        ) : null}
      </p>
      {failed ? <p role="alert">{say("practice.failed", { why: failed })}</p> : null}
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
