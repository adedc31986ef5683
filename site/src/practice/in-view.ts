// Scroll new content into view, as far as needed, and without animation if the system asks for reduced motion.

/** How long content above may still grow, such as an answer that is being typeset (ms). */
const SETTLING = 700;
/** Events by which a reader turns to something else. */
const READER_EVENTS = ["wheel", "touchstart", "pointerdown", "keydown"] as const;

/** Scroll an element (the top of a tall one) into view, and again once the page has settled, unless the reader acts. */
export function bringIntoView(element: Element): void {
  scrollTo(element);
  const waiting = new AbortController();
  const { signal } = waiting;
  for (const name of READER_EVENTS) window.addEventListener(name, () => waiting.abort(), { passive: true, signal });
  setTimeout(() => {
    if (!signal.aborted) scrollTo(element);
    waiting.abort();
  }, SETTLING);
}

function scrollTo(element: Element): void {
  const { top, bottom } = element.getBoundingClientRect();
  const above = parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0; // covered by the stage
  const isTall = bottom - top > window.innerHeight - above;
  if (top >= above - 1 && (isTall ? top <= above + 1 : bottom <= window.innerHeight + 1)) return;
  const isStill = window.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? true;
  element.scrollIntoView({ block: isTall ? "start" : "nearest", behavior: isStill ? "auto" : "smooth" });
}
