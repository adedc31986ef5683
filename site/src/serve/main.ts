// The script of every page of `qdot serve`: the part that the page has is loaded and shown.
import "../site.css";
import "./serve.css";

import { type ComponentType, h, render } from "preact";

import { showTexts } from "../pages/page.js";
import { loadLanguage } from "../text/languages.js";
import { ENGLISH, getLanguage, setLanguage } from "../text/text.js";
import { keepSession } from "./frame.js";

/** The parts by the ids of their elements; pages without any are text: how to get in, choosing an assignment. */
const PARTS: Readonly<Record<string, () => Promise<ComponentType>>> = {
  work: async () => (await import("./student.js")).StudentPage,
  class: async () => (await import("./class-page.js")).ClassPage,
};

/** The share of the screen's height for which a page with such a part asks in the frame of a platform. */
const SCREEN_SHARE = 0.8;

keepSession();
setLanguage(await loadLanguage().catch(() => ENGLISH));
showTexts();
const launchForm = document.querySelector<HTMLFormElement>("form#launch");
if (launchForm)
  void (await import("./launching.js")).launch(launchForm).catch(() => {
    launchForm.hidden = true;
    document.querySelector<HTMLElement>("#no-launch")!.hidden = false;
  });
const place = document.querySelector<HTMLElement>("#work, #class");
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
