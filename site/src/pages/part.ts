// Show the part of a page that a script draws, in place of the page's English text.

import { type JSX, render } from "preact";

import { getLanguageCode } from "../text/languages.js";
import { say, type TextKey } from "../text/text.js";
import { startPage } from "./page.js";

/** Start a page, translate its title, and draw its part into the element with this id. */
export async function showPart(
  id: string,
  [english, title]: readonly [english: string, title: TextKey],
  makePart: (data: DOMStringMap) => JSX.Element | Promise<JSX.Element>,
): Promise<void> {
  await startPage();
  const container = document.getElementById(id)!;
  const part = await makePart(container.dataset);
  container.textContent = "";
  container.lang = getLanguageCode();
  document.title = document.title.replace(english, say(title));
  render(part, container);
}
