// What every page does: it shows texts in the reader's language, and is stored for offline use.

import { ROOT } from "../load.js";
import { chooseLanguage, getLanguageCode, LANGUAGES, loadLanguage } from "../text/languages.js";
import { ENGLISH, say, setLanguage, type Values, type TextKey } from "../text/text.js";

export async function startPage(): Promise<void> {
  if ("serviceWorker" in navigator && window.isSecureContext) {
    window.addEventListener("load", () => void navigator.serviceWorker.register(`${ROOT}sw.js`).catch(() => undefined));
  }
  if (document.body.dataset["anywhere"] !== undefined) resolveLinks();
  setLanguage(await loadLanguage().catch(() => ENGLISH));
  await translatePage().catch(() => undefined); // without a translation, the page stays English
  document.querySelector("main")!.lang ||= "en";
  showTexts();
}

/** Show the texts of a page's elements, and the menu of languages, in the page's language. */
export function showTexts(): void {
  document.documentElement.lang = getLanguageCode(); // for texts without a language of their own
  for (const element of document.querySelectorAll<HTMLElement>("[data-translations]")) {
    const text = (JSON.parse(element.dataset["translations"]!) as Record<string, string>)[getLanguageCode()];
    if (text === undefined) continue;
    element.textContent = text;
    element.lang = getLanguageCode();
  }
  for (const element of document.querySelectorAll<HTMLElement>("[data-text]")) {
    const { text, values } = element.dataset;
    element.textContent = say(text as TextKey, values ? (JSON.parse(values) as Values) : {});
    if (getLanguageCode() !== "en") element.lang = getLanguageCode();
  }
  document.querySelector("header.top nav")?.setAttribute("aria-label", say("page.main"));
  document.querySelector("header.top .language")?.replaceWith(makeLanguageMenu()); // an element of the same size
}

/** Replace the page's English text by that in the reader's language, if there is a file with it. */
async function translatePage(): Promise<void> {
  const code = getLanguageCode();
  const main = document.querySelector("main");
  if (!main || !document.body.dataset["languages"]?.split(" ").includes(code)) return;
  const page = window.location.pathname.replace(/\/$/, "/index.html");
  const response = await fetch(page.replace(/\.html$/, `.${code}.json`));
  if (!response.ok) return;
  const { title, body } = (await response.json()) as { title: string; body: string };
  main.innerHTML = body;
  main.lang = code;
  document.title = document.title.replace(/^.*?(?= · |$)/, () => title);
}

/** Make links relative to the site's root, on a page that is shown at any address. */
function resolveLinks(): void {
  for (const link of document.querySelectorAll<HTMLAnchorElement>("a[href]:not([href^='#'])")) {
    link.href = new URL(link.getAttribute("href")!, ROOT).href;
  }
}

/** Return the menu of languages. */
function makeLanguageMenu(): HTMLElement {
  const label = document.createElement("label");
  label.className = "language";
  const select = document.createElement("select");
  select.setAttribute("aria-label", say("page.language"));
  for (const [code, { name }] of Object.entries(LANGUAGES)) {
    const option = new Option(name, code, false, code === getLanguageCode());
    option.lang = code;
    select.add(option);
  }
  select.addEventListener("change", () => chooseLanguage(select.value));
  label.append(select);
  return label;
}
