// The script of pages of text. Code that draws an arm is loaded only if the page has one, after the page is shown.
import "../site.css";

import { startPage } from "./page.js";

await startPage();
makeWideReachable();
window.addEventListener("resize", makeWideReachable);

/** Arms are loaded when they come near the screen, so that a phone can first show the text. */
const armObserver = new IntersectionObserver(
  (entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      armObserver.unobserve(target);
      void import("./live.js").then(
        ({ showArm }) => showArm(target as HTMLElement),
        () => undefined, // without a connection, the page shows its text only
      );
    }
  },
  { rootMargin: "100px" },
);
for (const element of document.querySelectorAll("[data-arm], [data-hero]")) armObserver.observe(element);

/** Let wide formulas, tables and listings be scrolled by keys, in every browser. */
function makeWideReachable(): void {
  for (const element of document.querySelectorAll("main math[display=block], main table, main pre")) {
    if (element.scrollWidth > element.clientWidth + 1) element.setAttribute("tabindex", "0");
    else element.removeAttribute("tabindex");
  }
}
