// Redraw the numbers beside a moving arm by turns: the arm is drawn in every frame, but only one table in every other
// frame, because each makes the browser lay out the page. At rest, and after keys, everything is up to date.

import { Component, type ComponentType, type FunctionComponent, h, type JSX } from "preact";

const waitingComponents = new Set<{ forceUpdate: () => void }>();

let isPointerDown = false;
let animationCount = 0;
if (typeof addEventListener === "function") {
  const options = { capture: true, passive: true };
  addEventListener("pointerdown", () => void (isPointerDown = true), options);
  for (const end of ["pointerup", "pointercancel", "blur"]) addEventListener(end, endDrag, options);
}

function endDrag(): void {
  isPointerDown = false;
  for (const part of waitingComponents) part.forceUpdate();
  waitingComponents.clear();
}

/** Report that the arm moves by itself, until the returned function is called. */
export function startAnimation(): () => void {
  animationCount += 1;
  return () => void (animationCount -= 1);
}

/** The properties whose changes a component shows at once, and those for which it waits for its turn. */
type Pace<P> = Readonly<Record<"atOnce" | "inTurn", readonly (keyof P)[]>>;

/**
 * Return a component that is drawn again only if a property changed. Preact's own memo needs its React layer, in which
 * every onChange of an input fires at each key, for example after a minus sign alone.
 */
export const memo = <P extends object>(part: FunctionComponent<P>): ComponentType<P> => withPace(part, null);

/** Return a component with a pace; other properties are ignored. Without a pace, all changes are shown at once. */
export function withPace<P extends object>(part: FunctionComponent<P>, pace: Pace<P> | null): ComponentType<P> {
  return class extends Component<P> {
    override shouldComponentUpdate(next: Readonly<P>): boolean {
      const hasChanged = (names: readonly (keyof P)[]): boolean =>
        names.some((name) => !Object.is((this.props as P)[name], next[name]));
      if (!pace) return hasChanged(Object.keys({ ...this.props, ...next }) as (keyof P)[]);
      if (hasChanged(pace.atOnce)) return true;
      if (!hasChanged(pace.inTurn)) return false;
      const isMoving = (isPointerDown || animationCount > 0) && !document.hidden;
      if (!isMoving) return true;
      if (waitingComponents.size === 0) requestAnimationFrame(drawNext);
      waitingComponents.add(this);
      return false;
    }

    override componentDidUpdate(): void {
      waitingComponents.delete(this);
    }

    override componentWillUnmount(): void {
      waitingComponents.delete(this);
    }

    override render(): JSX.Element {
      return h(part, this.props as P);
    }
  };
}

function drawNext(): void {
  const [first] = waitingComponents;
  if (!first) return;
  waitingComponents.delete(first);
  if (waitingComponents.size > 0) requestAnimationFrame(() => requestAnimationFrame(drawNext));
  first.forceUpdate();
}
