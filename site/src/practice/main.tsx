// The practice page's script.
import "../site.css";

import { render } from "preact";

import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { Practice } from "./practice.js";

await startPage();
const place = document.getElementById("practice");
if (place) {
  place.textContent = "";
  place.lang = chosenLanguage();
  render(<Practice />, place);
}
