// Scroll new content into view, as far as needed, and without animation if the system asks for reduced motion.

import { prefersReducedMotion } from "../scheduling.js";

/** Milliseconds in which content above may still grow, such as an answer that is being typeset. */
const SETTLING_TIME = 700;
/** Events that show that the reader scrolls or types, after which the page must not scroll by itself. */
const READER_EVENTS = ["wheel", "touchstart", "pointerdown", "keydown"] as const;

/** Scroll an element (the top of a tall one) into view, and again once the page has settled, unless the reader acts. */
export function bringIntoView(element: Element): void {
  scrollTo(element);
  const readerAction = new AbortController();
  const { signal } = readerAction;
  for (const name of READER_EVENTS)
    window.addEventListener(name, () => readerAction.abort(), { passive: true, signal });
  setTimeout(() => {
    if (!signal.aborted) scrollTo(element);
    readerAction.abort();
  }, SETTLING_TIME);
}

function scrollTo(element: Element): void {
  const { top, bottom } = element.getBoundingClientRect();
  const coveredHeight = parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0; // by the stage
  const isTall = bottom - top > window.innerHeight - coveredHeight;
  if (top >= coveredHeight - 1 && (isTall ? top <= coveredHeight + 1 : bottom <= window.innerHeight + 1)) return;
  const behavior = prefersReducedMotion() ? "auto" : "smooth";
  element.scrollIntoView({ block: isTall ? "start" : "nearest", behavior });
}
