// The script of the page of one's own arm.
import "../site.css";

import { render } from "preact";

import { loadKnownArms } from "../load.js";
import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { say } from "../text/text.js";
import { OwnArm } from "./own.js";

await startPage();
const place = document.getElementById("own");
if (place) {
  place.lang = chosenLanguage();
  document.title = document.title.replace("Your own arm", say("own.title"));
  const known = await loadKnownArms().catch(() => null);
  place.textContent = "";
  render(known ? <OwnArm known={known} /> : <p role="alert">{say("practice.arm-failed")}</p>, place);
}
