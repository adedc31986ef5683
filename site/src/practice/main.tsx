// The practice page's script.
import "../site.css";

import { h, render } from "preact";

import { breath } from "../later.js";
import { startPage } from "../pages/page.js";
import { chosenLanguage } from "../text/languages.js";
import { say } from "../text/text.js";
import { asksForRound } from "../course/link.js";
import { Practice } from "./practice.js";

const { search } = window.location;
if (new URLSearchParams(search).has("embed")) document.body.classList.add("embedded");
await startPage();
await breath();
const place = document.getElementById("practice");
if (place) {
  const shown = asksForRound(search) ? (await import("../course/embedded.js")).Embedded : Practice;
  place.textContent = "";
  place.lang = chosenLanguage();
  document.title = document.title.replace("Practise", say("page.practise"));
  render(h(shown, {}), place);
}
