// The script of the page on which students check a notebook before they submit it.
import "../site.css";

import { showPart } from "../pages/part.js";
import { CheckPage } from "./check-page.js";

await showPart("check", ["Check your notebook", "check.title"], ({ maxMegabytes }) => (
  <CheckPage maxMegabytes={Number(maxMegabytes)} />
));
