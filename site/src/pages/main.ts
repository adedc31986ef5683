// The script of the pages that are read. What draws an arm is loaded where there is one, after the page is shown.
import "../site.css";

import { startPage } from "./page.js";

await startPage();
if (document.querySelector("[data-arm], [data-hero]")) {
  const { showArms } = await import("./live.js");
  showArms();
}
