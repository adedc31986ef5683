// The part of a page that a script shows, in the place of what the page has in English until then.

import { type JSX, render } from "preact";

import { chosenLanguage } from "../text/languages.js";
import { say, type TextKey } from "../text/text.js";
import { startPage } from "./page.js";

/** Start a page, say its title in the language of the reader, and show its part in the element of that id. */
export async function showPart(
  id: string,
  [english, title]: readonly [english: string, title: TextKey],
  partOf: (data: DOMStringMap) => JSX.Element | Promise<JSX.Element>,
): Promise<void> {
  await startPage();
  const place = document.getElementById(id)!;
  const part = await partOf(place.dataset);
  place.textContent = "";
  place.lang = chosenLanguage();
  document.title = document.title.replace(english, say(title));
  render(part, place);
}
