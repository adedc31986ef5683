// The languages of the site, and the one in use: named in the link, or chosen in this browser.

import { storeText, loadText, storage } from "../storage.js";
import { ENGLISH, type Language } from "./text.js";

const KEY = "qdot-language";
const PARAMETER = "lang";

/** Each language by its code: its own name, and how its texts are loaded. */
export const LANGUAGES: Readonly<Record<string, { name: string; load: () => Promise<Language> }>> = {
  en: { name: "English", load: async () => ENGLISH },
  de: { name: "Deutsch", load: async () => ({ code: "de", catalogue: (await import("./de.json")).default }) },
};

/** Return the code of the language in use; by default the browser's first supported language, or English. */
export function getLanguageCode(): string {
  const linkedCode = new URLSearchParams(window.location.search).get(PARAMETER);
  if (linkedCode && linkedCode in LANGUAGES) return linkedCode;
  const preferred = navigator.languages.map((tag) => tag.split("-")[0]!.toLowerCase());
  return loadText(storage, KEY) ?? preferred.find((code) => code in LANGUAGES) ?? "en";
}

export function chooseLanguage(code: string): void {
  storeText(storage, KEY, code);
  const address = new URL(window.location.href);
  address.searchParams.delete(PARAMETER); // the choice has precedence over the link
  if (loadText(storage, KEY) !== code) address.searchParams.set(PARAMETER, code); // the browser stores nothing
  window.history.replaceState(window.history.state, "", address); // with the question that is shown
  window.location.reload();
}

export async function loadLanguage(): Promise<Language> {
  return (LANGUAGES[getLanguageCode()]?.load ?? (async () => ENGLISH))();
}
