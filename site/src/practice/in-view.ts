// What has just come is brought into view, as far as that takes, and at once for who wants no motion.

/** Scroll until an element is in view; one that is taller than the window, until its beginning is. */
export function bringIntoView(element: Element): void {
  const { top, bottom } = element.getBoundingClientRect();
  const room = window.innerHeight - coveredAbove();
  const isStill = window.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? true;
  if (top >= coveredAbove() && bottom <= window.innerHeight) return;
  element.scrollIntoView({
    block: bottom - top > room ? "start" : "nearest",
    behavior: isStill ? "auto" : "smooth",
  });
}

/** So many pixels lie under the stage on a phone, as the style of the page says. */
function coveredAbove(): number {
  return parseFloat(getComputedStyle(document.documentElement).scrollPaddingTop) || 0;
}
