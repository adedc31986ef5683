// Show the part of a page that a script draws, in place of the page's English text.

import { type JSX, render } from "preact";

import { chosenLanguage } from "../text/languages.js";
import { say, type TextKey } from "../text/text.js";
import { startPage } from "./page.js";

/** Start a page, translate its title, and draw its part into the element with this id. */
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
