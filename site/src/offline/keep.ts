// Store problems in the service worker's cache before they are opened, so that they work offline.

import { ROOT } from "../load.js";

/** bank/sizes.json: for each "FAMILY/KEY", the endings of the problem's files and their sizes in bytes. */
export type Sizes = { readonly format: 1; readonly files: Readonly<Record<string, Readonly<Record<string, number>>>> };

export interface BankFile {
  /** The problem to which the file belongs, as "FAMILY/KEY". */
  readonly problem: string;
  readonly path: string;
  readonly bytes: number;
}

/** Return the files of some problems, in English and in the page's language. */
export function filesOf({ files }: Sizes, problems: Iterable<string>, language: string): BankFile[] {
  const isNeeded = (ending: string): boolean =>
    /^(\.solutions)?\.json$/.test(ending) || ending.endsWith(`.${language}.json`);
  return [...new Set(problems)].flatMap((problem) =>
    Object.entries(files[problem] ?? {})
      .filter(([ending]) => isNeeded(ending))
      .map(([ending, bytes]) => ({ problem, path: `bank/${problem}${ending}`, bytes })),
  );
}

export const addressOf = ({ path }: BankFile): string => new URL(`${ROOT}${path}`, window.location.href).href;

/** Return the cache of the service worker; null if the browser has none, or stores nothing. */
export async function cacheOf(): Promise<Cache | null> {
  if (!("serviceWorker" in navigator) || typeof caches === "undefined") return null;
  try {
    const { scope } = await navigator.serviceWorker.ready;
    const name = (await caches.keys()).find(
      (cacheName) => cacheName.startsWith("qdot-") && cacheName.endsWith(` ${scope}`),
    );
    return name === undefined ? null : await caches.open(name);
  } catch {
    return null;
  }
}

/** Return the files that are not stored yet. */
export async function missingOf(cache: Cache, files: readonly BankFile[]): Promise<BankFile[]> {
  const stored = new Set((await cache.keys()).map(({ url }) => url));
  return files.filter((file) => !stored.has(addressOf(file)));
}

/** How many files are loaded at a time. */
const AT_ONCE = 4;

/** Load files into the cache until stopped, and call `onStored` for every file. Return how many failed. */
export async function fetchAll(
  cache: Cache,
  files: readonly BankFile[],
  onStored: (file: BankFile) => void,
  stopped: AbortSignal,
): Promise<number> {
  const queue = [...files];
  let failed = 0;
  const work = async (): Promise<void> => {
    for (let file = queue.shift(); file && !stopped.aborted; file = queue.shift()) {
      try {
        const answer = await fetch(addressOf(file), { signal: stopped });
        if (!answer.ok) throw new Error(String(answer.status));
        await cache.put(addressOf(file), answer);
        onStored(file);
      } catch {
        if (!stopped.aborted) failed += 1;
      }
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
  return failed;
}

/** Return megabytes, rounded for display. */
export const megabytes = (bytes: number): number => {
  const size = bytes / 1e6;
  return Number(size < 10 ? size.toFixed(1) : size.toFixed(0));
};

export const totalBytes = (files: readonly BankFile[]): number => files.reduce((total, { bytes }) => total + bytes, 0);

export const problemsIn = (files: readonly BankFile[]): number => new Set(files.map(({ problem }) => problem)).size;
