// Files of the bank, loaded as they are needed and kept for as long as the page is open.

import type { Index, Problem, Solutions } from "./bank.js";

/** Where the site's root is, as seen from the page. */
export const ROOT = typeof document === "undefined" ? "" : (document.body.dataset["root"] ?? "");

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

export const loadIndex = (): Promise<Index> => loaded("index.json");

export const loadProblem = (family: string, key: string): Promise<Problem> => loaded(`${family}/${key}.json`);

export const loadSolutions = (family: string, key: string): Promise<Solutions> =>
  loaded(`${family}/${key}.solutions.json`);
