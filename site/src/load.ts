// Load files of the bank when they are needed, and keep them while the page is open.

import type {
  Index,
  Problem,
  ProblemArm,
  ProblemQuestion,
  TranslatedArm,
  TranslatedQuestion,
  TranslatedTitles,
} from "./bank.js";
import type { KnownArms } from "./own/known-arms.js";
import type { Sizes } from "./offline/cache.js";
import { translateIndex, translateProblem } from "./text/problems.js";
import { getLanguage } from "./text/text.js";

/** The site's root relative to the page; a page shown at any address, such as 404, uses its script's address. */
export const ROOT = typeof document === "undefined" ? "" : findRoot(document.body.dataset);

function findRoot({ root, anywhere }: DOMStringMap): string {
  return anywhere === undefined ? (root ?? "") : new URL("../", import.meta.url).href;
}

const files = new Map<string, Promise<unknown>>();

function load<T>(path: string): Promise<T> {
  const knownFile = files.get(path);
  if (knownFile) return knownFile as Promise<T>;
  const file = fetch(`${ROOT}bank/${path}`).then((response) => {
    if (!response.ok) throw new Error(`${path}: ${response.status}`);
    return response.json() as Promise<T>;
  });
  file.catch(() => files.delete(path)); // try again next time
  files.set(path, file);
  return file;
}

/** Return the page's language, a file, and its translation; null for English, or if there is no translation. */
async function loadWithTranslation<T, U>(name: string): Promise<[string, T, U | null]> {
  const { code } = getLanguage();
  const translation = code === "en" ? null : load<U>(`${name}.${code}.json`).catch(() => null);
  return [code, await load<T>(`${name}.json`), await translation];
}

export const loadIndex = async (): Promise<Index> =>
  translateIndex(...(await loadWithTranslation<Index, TranslatedTitles>("index")));

/** Load an arm with one question about it. */
export async function loadProblem(family: string, key: string, question: string): Promise<Problem> {
  const [[lang, arm, armTexts], [, part, partTexts]] = await Promise.all([
    loadWithTranslation<ProblemArm, TranslatedArm>(`${family}/${key}`),
    loadWithTranslation<ProblemQuestion, TranslatedQuestion>(`${family}/${key}/${question}`),
  ]);
  return translateProblem(lang, { ...arm, parts: [part], said: part.said }, armTexts, partTexts);
}

export const loadSizes = (): Promise<Sizes> => load("sizes.json");

export const loadKnownArms = (): Promise<KnownArms> => load("robots.json");
