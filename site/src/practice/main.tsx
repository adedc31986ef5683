// The script of the practice page.
import "../site.css";

import { h } from "preact";

import { asksForRound } from "../course/link.js";
import { yieldToBrowser } from "../scheduling.js";
import { showPart } from "../pages/part.js";
import { Practice } from "./practice.js";

const { search } = window.location;
if (new URLSearchParams(search).has("embed")) document.body.classList.add("embedded");
await showPart("practice", ["Practise", "page.practise"], async () => {
  await yieldToBrowser();
  return h(asksForRound(search) ? (await import("../course/embedded.js")).Embedded : Practice, {});
});
