// One problem of the bank: the answer is judged in the browser by its key; hints and the solution are shown.

import type { JSX } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { createSingularityTest } from "../arm/is-singular.js";
import type { Factor, Part, Problem } from "../bank.js";
import { isAtLeast, chooseLowerLevel, type Level, limitVerdict } from "../grade/levels.js";
import type { ColumnsAt } from "../grade/typed-jacobian.js";
import { isParsed, type Verdict } from "../grade/verdict.js";
import type { SymbolValues } from "../read/tree.js";
import { say } from "../text/text.js";
import { describeLoadError } from "../scheduling.js";
import { type Item, nameItem } from "./choice.js";
import { Feedback, findPose } from "./feedback.js";
import { Hints, Question, type QuestionProps, Solution } from "./question.js";
import { drawTypedColumns } from "./typed-columns.js";

const loadGrading = () => import("../grade/judge.js");

/** An answer with its verdict. */
export type JudgedPart = { readonly part: Part; readonly answer: string; readonly verdict: Verdict };

export interface TaskProps extends Pick<QuestionProps, "unknown"> {
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
  const { notes, onVerdict, onSolution, onNext, unknown } = props;
  const [answer, setAnswer] = useState("");
  const [verdict, setVerdict] = useState<Verdict | null>(null);
  const [loadError, setLoadError] = useState("");
  const [pose, setPose] = useState<SymbolValues | undefined>(undefined);
  const [typedColumns, setTypedColumns] = useState<ColumnsAt | null>(null);
  const [isSolutionShown, setSolutionShown] = useState(false); // an answer after the solution was shown does not count
  const [verdictNumber, setVerdictNumber] = useState(0);
  const hasSeenHints = useRef(false);
  const isPrepared = useRef(false);
  const lastJudged = useRef<string | null>(null);
  const isOpen = !isClosed && verdict?.outcome !== "correct" && !isSolutionShown; // still to be answered
  const wouldReveal = REVEALED_BY_FACTORS.has(part.kind) && verdict?.outcome !== "correct" && !isSolutionShown;
  const drawnColumns = answer === lastJudged.current ? typedColumns : null; // of no answer that was changed since
  const overlay = useMemo(() => (drawnColumns ? drawTypedColumns(drawnColumns) : undefined), [drawnColumns]);
  const showsFactors = mayShowFactors && !wouldReveal && isAtLeast(level, "solutions");
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
    setVerdictNumber((number) => number + 1);
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
  };
  const isDone = isClosed || verdict?.outcome === "correct";
  return (
    <Question
      name={nameItem(item)}
      {...{ problem, part, hasArrived, isOpen, isDone, isClosed, answer, pose, overlay, unknown, verdictNumber }}
      factors={(showsFactors && problem.factors) || NO_FACTORS}
      checkText={say("practice.check")}
      nextText={say(isDone ? "practice.next" : "practice.skip")}
      onAnswer={setAnswer}
      onCheck={() => void check()}
      onNext={onNext}
      onStart={prepare}
      error={loadError}
      verdict={
        verdict ? <Feedback problem={problem} verdict={verdict} isDrawn={drawnColumns !== null} notes={notes} /> : null
      }
      onVerdictShown={() => setPose(verdict ? findPose(problem, verdict) : undefined)}
    >
      <Help
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
    </Question>
  );
}

/** Questions whose answers the factors of det J would reveal: they are shown after it is solved. */
const REVEALED_BY_FACTORS: ReadonlySet<string> = new Set([
  ...["determinant", "inverse-jacobian", "inverse-velocity", "joint-rates", "manipulability"],
  ...["singular-angles", "singularity-type", "singularity-meaning", "rank", "invertibility"],
  ...["arm-block", "wrist-block", "block-determinants"],
]);

const NO_FACTORS: readonly Factor[] = [];

interface HelpProps {
  readonly part: Part;
  readonly lang: string | undefined;
  /** Whether solutions may be shown. */
  readonly hasSolutions: boolean;
  readonly isSolved: boolean;
  readonly onHint: () => void;
  readonly onSolution: () => void;
}

function Help({ part, lang, hasSolutions, isSolved, onHint, onSolution }: HelpProps) {
  const [hintCount, setHintCount] = useState(0);
  const [isShown, setShown] = useState(false);
  return (
    <section class="help-steps">
      <Hints
        part={part}
        lang={lang}
        onHint={() => {
          onHint();
          setHintCount(hintCount + 1);
        }}
      >
        {hasSolutions && part.solved && !isShown && (isSolved || hintCount > 0) ? (
          <Button
            text={say("practice.solution")}
            onClick={() => {
              onSolution();
              setShown(true);
            }}
          />
        ) : null}
      </Hints>
      {isShown && part.solved ? (
        <Solution {...part.solved} lang={lang} above={part.prompt + part.hints.slice(0, hintCount).join()} />
      ) : null}
    </section>
  );
}
