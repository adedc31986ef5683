// The script of the pages that are read. What draws an arm is loaded where there is one, after the page is shown.
import "../site.css";

import { startPage } from "./page.js";

await startPage();
reachWide();
window.addEventListener("resize", reachWide);
if (document.querySelector("[data-arm], [data-hero]")) {
  const { showArms } = await import("./live.js");
  showArms();
}

/** Formulas, tables and listings that are wider than their place are scrolled by keys, in every browser. */
function reachWide(): void {
  for (const element of document.querySelectorAll("main math[display=block], main table, main pre")) {
    if (element.scrollWidth > element.clientWidth + 1) element.setAttribute("tabindex", "0");
    else element.removeAttribute("tabindex");
  }
}
