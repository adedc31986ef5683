// The script of the page on which an instructor makes links to rounds.
import "../site.css";

import { render } from "preact";

import { loadIndex } from "../load.js";
import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { message, said } from "../text/text.js";
import { Maker } from "./maker.js";

await startPage();
const place = document.getElementById("course");
if (place) {
  place.lang = chosenLanguage();
  document.title = document.title.replace("In a course", said(message("page.course")));
  await loadIndex().then(
    (index) => {
      place.textContent = "";
      render(<Maker index={index} />, place);
    },
    (error: unknown) => (place.textContent = said(message("practice.failed", { why: String(error) }))),
  );
}
