// Files of the bank, loaded as they are needed and kept for as long as the page is open.

import type { Index, Problem, Solutions, SolvedTexts, Texts, Titles } from "./bank.js";
import type { KnownArms } from "./own/known.js";
import type { Sizes } from "./offline/keep.js";
import { solvedIn, titledIn, toldIn } from "./text/problems.js";
import { language } from "./text/text.js";

/** The site's root as seen from the page. A page that is shown at any address takes it from its script's address. */
export const ROOT = typeof document === "undefined" ? "" : rootOf(document.body.dataset);

function rootOf({ root, anywhere }: DOMStringMap): string {
  return anywhere === undefined ? (root ?? "") : new URL("../", import.meta.url).href;
}

const known = new Map<string, Promise<unknown>>();

function loaded<T>(path: string): Promise<T> {
  const found = known.get(path);
  if (found) return found as Promise<T>;
  const fresh = fetch(`${ROOT}bank/${path}`).then((answer) => {
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return answer.json() as Promise<T>;
  });
  fresh.catch(() => known.delete(path)); // a network that failed may be there again
  known.set(path, fresh);
  return fresh;
}

/** A file and its translation into the language of the page, if that is not English; null where there is none. */
async function withTranslation<T, U>(name: string): Promise<[string, T, U | null]> {
  const { code } = language();
  const translation = code === "en" ? null : loaded<U>(`${name}.${code}.json`).catch(() => null); // in English, then
  return [code, await loaded<T>(`${name}.json`), await translation];
}

export const loadIndex = async (): Promise<Index> => titledIn(...(await withTranslation<Index, Titles>("index")));

export const loadProblem = async (family: string, key: string): Promise<Problem> =>
  toldIn(...(await withTranslation<Problem, Texts>(`${family}/${key}`)));

export const loadSolutions = async (family: string, key: string): Promise<Solutions> =>
  solvedIn(...(await withTranslation<Solutions, SolvedTexts>(`${family}/${key}.solutions`)));

export const loadSizes = (): Promise<Sizes> => loaded("sizes.json");

export const loadKnownArms = (): Promise<KnownArms> => loaded("robots.json");
