// The script of the pages that are read. What draws an arm is loaded where there is one, after the page is shown.
import "../site.css";

import { startPage } from "./page.js";

await startPage();
reachWide();
window.addEventListener("resize", reachWide);

/** Arms are loaded when they come near to the screen: a phone that shows the text first has no work with them. */
const near = new IntersectionObserver(
  (entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      near.unobserve(target);
      void import("./live.js").then(
        ({ showArm }) => showArm(target as HTMLElement),
        () => undefined, // the connection is lost, or the page is being left: the text is there all the same
      );
    }
  },
  { rootMargin: "100px" },
);
for (const element of document.querySelectorAll("[data-arm], [data-hero]")) near.observe(element);

/** Formulas, tables and listings that are wider than their place are scrolled by keys, in every browser. */
function reachWide(): void {
  for (const element of document.querySelectorAll("main math[display=block], main table, main pre")) {
    if (element.scrollWidth > element.clientWidth + 1) element.setAttribute("tabindex", "0");
    else element.removeAttribute("tabindex");
  }
}
