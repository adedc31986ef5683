// The script of the page on which an instructor makes links to rounds.
import "../site.css";

import { render } from "preact";

import { loadIndex } from "../load.js";
import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { say } from "../text/text.js";
import { Maker } from "./maker.js";

await startPage();
const place = document.getElementById("course");
if (place) {
  place.lang = chosenLanguage();
  document.title = document.title.replace("In a course", say("page.course"));
  await loadIndex().then(
    (index) => {
      place.textContent = "";
      render(<Maker index={index} />, place);
    },
    (error: unknown) => (place.textContent = say("practice.failed", { why: String(error) })),
  );
}
