// What is due for review, on top of the practice page, and the way to it.

import type { JSX } from "preact";

import { Button } from "../button.js";
import { message, said, say } from "../text/text.js";

/** Minutes that a question takes, as a rule. */
const EACH = 1.5;

interface DueProps {
  readonly count: number;
  /** Whether what is due is being answered. */
  readonly going: boolean;
  /** The lesson, and the class of its arms, of which is asked now, in words; null for what went wrong. */
  readonly of: string | null;
  readonly onStart: () => void;
}

export function Due({ count, going, of, onStart }: DueProps): JSX.Element | null {
  if (count === 0 && !going) return null;
  return (
    <p class="due" role="status">
      {going ? (
        <span>
          {said(count > 0 ? message("practice.due-left", { count }) : message("practice.due-done"))}
          {of && count > 0 ? <span class="muted"> · {of}</span> : null}
        </span>
      ) : (
        <>
          <strong>{say("practice.due-now", { count, minutes: Math.ceil(EACH * count) })}</strong>
          <Button style="quiet small" text={say("practice.due-start")} onClick={onStart} />
        </>
      )}
    </p>
  );
}
