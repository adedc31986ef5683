// One problem, from when it is loaded until the next is asked for.

import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";

import type { Problem } from "../bank.js";
import type { Level } from "../grade/levels.js";
import { loadProblem } from "../load.js";
import { say } from "../text/text.js";
import type { Item } from "./choice.js";
import { type Judged, Task } from "./task.js";

export type { Judged };

/** One problem; `arrived` at from the one before, it is gone to at once, for keyboards and screen readers, too. */
export function Current({
  item,
  level,
  judgedAt,
  arrived,
  closed = false,
  factored = true,
  notes,
  onVerdict,
  onSolution = () => undefined,
  onNext,
}: {
  item: Item;
  level: Level;
  /** What a verdict tells at most, where there is something to be had from another try. */
  judgedAt?: Level | undefined;
  arrived: boolean;
  /** Whether it is answered for good: the solution may be seen, and nothing more is checked. */
  closed?: boolean;
  /** Whether the factors of det J may be shown, where they don't tell this very answer. */
  factored?: boolean;
  /** What is said below a verdict of what comes of it. */
  notes?: readonly string[];
  /** Told whether an answer that could be read is right, whether hints or the solution were seen before, and how it was judged. */
  onVerdict: (right: boolean, helped: boolean, judged: Judged) => void;
  /** Told that the solution is seen before the answer is right. */
  onSolution?: () => void;
  onNext: () => void;
}) {
  const [problem, setProblem] = useState<Problem | null>(null);
  const [failed, setFailed] = useState("");
  const load = () => {
    setFailed("");
    loadProblem(item.family, item.key).then(setProblem, (error: unknown) => setFailed(String(error)));
  };
  useEffect(load, [item]);
  if (failed)
    return (
      <div class="task">
        <Failed why={failed} onAgain={load} />
      </div>
    );
  const part = problem?.parts.find(({ kind }) => kind === item.question);
  if (!problem || !part)
    return (
      <>
        <p role="status" class="task">
          {say("practice.loading")}
        </p>
        <div class="stage" />
      </>
    );
  return (
    <>
      <Task
        item={item}
        problem={problem}
        part={part}
        level={level}
        judgedAt={judgedAt}
        arrived={arrived}
        closed={closed}
        factored={factored}
        notes={notes}
        onVerdict={(judged, helped) => onVerdict(judged.verdict.outcome === "correct", helped, judged)}
        onSolution={onSolution}
        onNext={onNext}
      />
    </>
  );
}

export function Failed({ why, onAgain }: { why: string; onAgain: () => void }): JSX.Element {
  return (
    <div role="alert">
      <p>{say("practice.failed", { why })}</p>
      <button type="button" class="button" onClick={onAgain}>
        {say("practice.again")}
      </button>
    </div>
  );
}
