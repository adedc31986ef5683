// The practice page's script.
import "../site.css";

import { render } from "preact";

import { breath } from "../later.js";
import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { message, said } from "../text/text.js";
import { Practice } from "./practice.js";

await startPage();
await breath();
const place = document.getElementById("practice");
if (place) {
  place.textContent = "";
  place.lang = chosenLanguage();
  document.title = document.title.replace("Practise", said(message("page.practise")));
  render(<Practice />, place);
}
