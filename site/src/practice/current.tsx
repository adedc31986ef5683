// One problem, from loading until the next problem is requested.

import type { JSX } from "preact";

import { Failed } from "../controls.js";
import { useLoaded } from "../scheduling.js";
import { loadProblem } from "../load.js";
import { say } from "../text/text.js";
import { Task, type TaskProps } from "./task.js";

/** One problem. If it follows another one, the page moves to it, also for keyboards and screen readers. */
export function Current(props: Omit<TaskProps, "problem" | "part">): JSX.Element {
  const { item } = props;
  const { loaded: problem, error, retry } = useLoaded(() => loadProblem(item.family, item.key, item.question), [item]);
  if (error)
    return (
      <div class="task">
        <Failed reason={error} onAgain={retry} />
      </div>
    );
  const part = problem?.parts[0];
  if (!problem || !part)
    return (
      <>
        <p role="status" class="task">
          {say("practice.loading")}
        </p>
        <div class="stage" />
      </>
    );
  return <Task {...props} problem={problem} part={part} />;
}
