// Redraw the numbers beside a moving arm in turns: the arm is drawn in every frame, but only one of its tables in every
// other frame, because each makes the browser lay out the page. At rest, and after keys, everything is up to date.

import { Component, type ComponentType, type FunctionComponent, h, type JSX } from "preact";

/** When a part shows what has changed. */
export type When = "at once" | "in turn";

const waiting = new Set<{ forceUpdate: () => void }>();

let isHeld = false; // something, by a finger or the mouse
let running = 0;
if (typeof addEventListener === "function") {
  const on = { capture: true, passive: true };
  addEventListener("pointerdown", () => void (isHeld = true), on);
  for (const end of ["pointerup", "pointercancel", "blur"]) addEventListener(end, letGo, on);
}

function letGo(): void {
  isHeld = false;
  for (const part of waiting) part.forceUpdate();
  waiting.clear();
}

/** Say that the arm moves by itself, until what is returned is called. */
export function moving(): () => void {
  running += 1;
  return () => void (running -= 1);
}

/** A part that is drawn at once if an "at once" property changes, and waits for its turn if only others change. */
export function paced<P extends object>(
  part: FunctionComponent<P>,
  when: Readonly<Record<keyof P, When>>,
): ComponentType<P> {
  const names = Object.keys(when) as (keyof P)[];
  return class extends Component<P> {
    override shouldComponentUpdate(next: Readonly<P>): boolean {
      const others = names.filter((name) => !Object.is((this.props as P)[name], next[name]));
      if (others.length === 0) return false;
      const isMoving = (isHeld || running > 0) && !document.hidden;
      if (!isMoving || others.some((name) => when[name] === "at once")) return true;
      if (waiting.size === 0) requestAnimationFrame(nextTurn);
      waiting.add(this);
      return false;
    }

    override componentDidUpdate(): void {
      waiting.delete(this);
    }

    override componentWillUnmount(): void {
      waiting.delete(this);
    }

    override render(): JSX.Element {
      return h(part, this.props as P);
    }
  };
}

function nextTurn(): void {
  const [first] = waiting;
  if (!first) return;
  waiting.delete(first);
  if (waiting.size > 0) requestAnimationFrame(() => requestAnimationFrame(nextTurn));
  first.forceUpdate();
}
