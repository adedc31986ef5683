// The practice page's script.
import "../site.css";

import { h } from "preact";

import { asksForRound } from "../course/link.js";
import { breath } from "../later.js";
import { showPart } from "../pages/part.js";
import { Practice } from "./practice.js";

const { search } = window.location;
if (new URLSearchParams(search).has("embed")) document.body.classList.add("embedded");
await showPart("practice", ["Practise", "page.practise"], async () => {
  await breath();
  return h(asksForRound(search) ? (await import("../course/embedded.js")).Embedded : Practice, {});
});
