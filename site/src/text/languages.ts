// The languages of the site, and which one a link names, or the student chose in this browser.

import { keepText, keptText, storage } from "../storage.js";
import { ENGLISH, type Language } from "./text.js";

const KEY = "qdot-language";
const PARAMETER = "lang";

/** Each language by its code: what it calls itself, and how its texts are loaded. */
export const LANGUAGES: Readonly<Record<string, { name: string; load: () => Promise<Language> }>> = {
  en: { name: "English", load: async () => ENGLISH },
  de: { name: "Deutsch", load: async () => ({ code: "de", catalogue: (await import("./de.json")).default }) },
};

export function chosenLanguage(): string {
  const named = new URLSearchParams(window.location.search).get(PARAMETER);
  if (named && named in LANGUAGES) return named;
  return keptText(storage, KEY) ?? wished();
}

/** The first language of the browser that the site speaks; English where it speaks none of them. */
function wished(): string {
  const asked = navigator.languages.map((tag) => tag.split("-")[0]!.toLowerCase());
  return asked.find((code) => code in LANGUAGES) ?? "en";
}

export function chooseLanguage(code: string): void {
  keepText(storage, KEY, code);
  const address = new URL(window.location.href);
  address.searchParams.delete(PARAMETER); // what is chosen counts, and not what a link once said
  if (keptText(storage, KEY) !== code) address.searchParams.set(PARAMETER, code); // a browser that keeps nothing
  window.history.replaceState(null, "", address);
  window.location.reload();
}

export async function loadLanguage(): Promise<Language> {
  return (LANGUAGES[chosenLanguage()]?.load ?? (async () => ENGLISH))();
}
