// What has just come is brought into view, as far as that takes, and at once for who wants no motion.

/** How long what is above may still grow, as an answer that is being typeset (ms). */
const SETTLING = 700;
/** What a reader does who looks elsewhere. */
const ELSEWHERE = ["wheel", "touchstart", "pointerdown", "keydown"] as const;

/** Scroll an element, or the top of a tall one, into view; again after all has settled, unless the reader acts. */
export function bringIntoView(element: Element): void {
  scrolledTo(element);
  const wait = setTimeout(() => {
    stop();
    scrolledTo(element);
  }, SETTLING);
  const stop = (): void => {
    clearTimeout(wait);
    for (const name of ELSEWHERE) window.removeEventListener(name, stop);
  };
  for (const name of ELSEWHERE) window.addEventListener(name, stop, { passive: true });
}

function scrolledTo(element: Element): void {
  const { top, bottom } = element.getBoundingClientRect();
  const above = coveredAbove();
  const isTall = bottom - top > window.innerHeight - above;
  if (top >= above - 1 && (isTall ? top <= above + 1 : bottom <= window.innerHeight + 1)) return;
  const isStill = window.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? true;
  element.scrollIntoView({ block: isTall ? "start" : "nearest", behavior: isStill ? "auto" : "smooth" });
}

/** So many pixels lie under the stage on a phone, as the style of the page says. */
const coveredAbove = (): number => parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0;
