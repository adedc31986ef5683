// One problem, from when it is loaded until the next is asked for.

import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";

import type { Problem } from "../bank.js";
import type { Level } from "../grade/levels.js";
import { loadProblem } from "../load.js";
import { message, said } from "../text/text.js";
import type { Item } from "./choice.js";
import { Task } from "./task.js";

/** One problem; `arrived` at from the one before, it is gone to at once, for keyboards and screen readers, too. */
export function Current({
  item,
  level,
  arrived,
  onVerdict,
  onNext,
}: {
  item: Item;
  level: Level;
  arrived: boolean;
  /** Told whether an answer is right, and whether hints or the solution were seen before. */
  onVerdict: (right: boolean, helped: boolean) => void;
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
      <p role="status" class="task">
        {said(message("practice.loading"))}
      </p>
    );
  return (
    <>
      <Task
        item={item}
        problem={problem}
        part={part}
        level={level}
        arrived={arrived}
        onVerdict={(verdict, helped) => onVerdict(verdict.outcome === "correct", helped)}
        onNext={onNext}
      />
    </>
  );
}

export function Failed({ why, onAgain }: { why: string; onAgain: () => void }): JSX.Element {
  return (
    <div role="alert">
      <p>{said(message("practice.failed", { why }))}</p>
      <button type="button" class="button" onClick={onAgain}>
        {said(message("practice.again"))}
      </button>
    </div>
  );
}
