// What every page does: it speaks the language of the reader, and is kept for when there is no connection.

import { ROOT } from "../load.js";
import { chooseLanguage, chosenLanguage, LANGUAGES, loadLanguage } from "../text/languages.js";
import { ENGLISH, say, speak, type Values, type TextKey } from "../text/text.js";

export async function startPage(): Promise<void> {
  if ("serviceWorker" in navigator && window.isSecureContext) {
    window.addEventListener("load", () => void navigator.serviceWorker.register(`${ROOT}sw.js`).catch(() => undefined));
  }
  if (document.body.dataset["anywhere"] !== undefined) leadFromAnywhere();
  speak(await loadLanguage().catch(() => ENGLISH));
  await tellInLanguage().catch(() => undefined); // in English, then
  document.querySelector("main")!.lang ||= "en";
  document.documentElement.lang = chosenLanguage(); // which a screen reader takes for all that names none
  for (const element of document.querySelectorAll<HTMLElement>("[data-told]")) {
    const text = (JSON.parse(element.dataset["told"]!) as Record<string, string>)[chosenLanguage()];
    if (text === undefined) continue;
    element.textContent = text;
    element.lang = chosenLanguage();
  }
  for (const element of document.querySelectorAll<HTMLElement>("[data-text]")) {
    const { text, values } = element.dataset;
    element.textContent = say(text as TextKey, values ? (JSON.parse(values) as Values) : {});
    if (chosenLanguage() !== "en") element.lang = chosenLanguage();
  }
  document.querySelector("header.top nav")?.setAttribute("aria-label", say("page.main"));
  document.querySelector("header.top .language")?.replaceWith(languageChoice()); // its room is there already
}

/** Puts what a page says in the language of the reader in the place of the English, where there is a file with it. */
async function tellInLanguage(): Promise<void> {
  const code = chosenLanguage();
  const main = document.querySelector("main");
  if (!main || !document.body.dataset["toldIn"]?.split(" ").includes(code)) return;
  const page = window.location.pathname.replace(/\/$/, "/index.html");
  const answer = await fetch(page.replace(/\.html$/, `.${code}.json`));
  if (!answer.ok) return;
  const { title, body } = (await answer.json()) as { title: string; body: string };
  main.innerHTML = body;
  main.lang = code;
  document.title = document.title.replace(/^.*?(?= · |$)/, () => title);
}

/** Links of a page that is shown at any address lead where they would from the site's root. */
function leadFromAnywhere(): void {
  for (const link of document.querySelectorAll<HTMLAnchorElement>("a[href]:not([href^='#'])")) {
    link.href = new URL(link.getAttribute("href")!, ROOT).href;
  }
}

/** The choice of a language; the texts of problems and of the documentation are English. */
function languageChoice(): HTMLElement {
  const label = document.createElement("label");
  label.className = "language";
  const select = document.createElement("select");
  select.setAttribute("aria-label", say("page.language"));
  for (const [code, { name }] of Object.entries(LANGUAGES)) {
    const option = new Option(name, code, false, code === chosenLanguage());
    option.lang = code;
    select.add(option);
  }
  select.addEventListener("change", () => chooseLanguage(select.value));
  label.append(select);
  return label;
}
