// The script of every page of `qdot serve`: the part that the page has is loaded and shown.
import "../site.css";
import "./serve.css";

import { type ComponentType, h, render } from "preact";

import { showTexts } from "../pages/page.js";
import { loadLanguage } from "../text/languages.js";
import { ENGLISH, getLanguage, setLanguage } from "../text/text.js";

/** The parts by the ids of their elements; pages without any are text: how to get in, choosing an assignment. */
const PARTS: Readonly<Record<string, () => Promise<ComponentType>>> = {
  work: async () => (await import("./student.js")).StudentPage,
  class: async () => (await import("./class-page.js")).ClassPage,
};

/** The share of the screen's height for which a page with such a part asks in the frame of a platform. */
const SCREEN_SHARE = 0.8;

setLanguage(await loadLanguage().catch(() => ENGLISH));
showTexts();
const place = document.querySelector<HTMLElement>(
  Object.keys(PARTS)
    .map((id) => `#${id}`)
    .join(),
);
if (window.parent !== window) {
  document.body.classList.add("embedded");
  const ask = (height: number) =>
    window.parent.postMessage({ subject: "lti.frameResize", height: Math.ceil(height) }, "*"); // reveals nothing else
  if (place) ask(SCREEN_SHARE * window.screen.availHeight);
  else new ResizeObserver(() => ask(document.body.scrollHeight)).observe(document.querySelector("main")!);
}
if (place) {
  const Part = await PARTS[place.id]!();
  place.textContent = "";
  place.lang = getLanguage().code;
  render(h(Part, {}), place);
}
