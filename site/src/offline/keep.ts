// Store problems in the service worker's cache before they are opened, so that they work offline.

import { ROOT } from "../load.js";

/** bank/sizes.json: by "FAMILY/KEY", the endings of the problem's files with their sizes in bytes. */
export type Sizes = { readonly format: 1; readonly files: Readonly<Record<string, Readonly<Record<string, number>>>> };

export interface Wanted {
  /** The problem that it belongs to, as "FAMILY/KEY". */
  readonly problem: string;
  readonly path: string;
  readonly bytes: number;
}

/** The files of some problems, in English and in the language of the page. */
export function filesOf({ files }: Sizes, problems: Iterable<string>, language: string): Wanted[] {
  const spoken = (ending: string): boolean =>
    /^(\.solutions)?\.json$/.test(ending) || ending.endsWith(`.${language}.json`);
  return [...new Set(problems)].flatMap((problem) =>
    Object.entries(files[problem] ?? {})
      .filter(([ending]) => spoken(ending))
      .map(([ending, bytes]) => ({ problem, path: `bank/${problem}${ending}`, bytes })),
  );
}

export const addressOf = ({ path }: Wanted): string => new URL(`${ROOT}${path}`, window.location.href).href;

/** The cache from which the service worker answers; null where the browser has none, or keeps nothing. */
export async function cacheOf(): Promise<Cache | null> {
  if (!("serviceWorker" in navigator) || typeof caches === "undefined") return null;
  try {
    const { scope } = await navigator.serviceWorker.ready;
    const name = (await caches.keys()).find((each) => each.startsWith("qdot-") && each.endsWith(` ${scope}`));
    return name === undefined ? null : await caches.open(name);
  } catch {
    return null;
  }
}

/** What of some files is not kept yet. */
export async function missingOf(cache: Cache, files: readonly Wanted[]): Promise<Wanted[]> {
  const kept = new Set((await cache.keys()).map(({ url }) => url));
  return files.filter((file) => !kept.has(addressOf(file)));
}

/** So many files are on the way at a time. */
const AT_ONCE = 4;

/** Fetch files into the cache until stopped, and call `each` for every file. Return how many failed. */
export async function fetchAll(
  cache: Cache,
  files: readonly Wanted[],
  each: (file: Wanted) => void,
  stopped: AbortSignal,
): Promise<number> {
  const left = [...files];
  let failed = 0;
  const work = async (): Promise<void> => {
    for (let file = left.shift(); file && !stopped.aborted; file = left.shift()) {
      try {
        const answer = await fetch(addressOf(file), { signal: stopped });
        if (!answer.ok) throw new Error(String(answer.status));
        await cache.put(addressOf(file), answer);
        each(file);
      } catch {
        if (!stopped.aborted) failed += 1;
      }
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
  return failed;
}

/** Megabytes, as they are told. */
export const megabytes = (bytes: number): number => {
  const size = bytes / 1e6;
  return Number(size < 10 ? size.toFixed(1) : size.toFixed(0));
};

export const sum = (files: readonly Wanted[]): number => files.reduce((total, { bytes }) => total + bytes, 0);

export const problemsIn = (files: readonly Wanted[]): number => new Set(files.map(({ problem }) => problem)).size;
