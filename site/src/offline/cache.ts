// Store problems in the service worker's cache before they are opened, so that they work offline.

import { ROOT } from "../load.js";

/** bank/sizes.json: for each "FAMILY/KEY", the endings of the problem's files and their sizes in bytes. */
export type Sizes = { readonly format: 1; readonly files: Readonly<Record<string, Readonly<Record<string, number>>>> };

export interface BankFile {
  /** The problem to which the file belongs, as "FAMILY/KEY". */
  readonly problem: string;
  /** Relative to the site's root. */
  readonly path: string;
  readonly bytes: number;
}

/** Return the files of some problems, in English and in the page's language. */
export function listFiles({ files }: Sizes, problems: Iterable<string>, language: string): BankFile[] {
  const isNeeded = (ending: string): boolean => /^[^.]*\.json$/.test(ending) || ending.endsWith(`.${language}.json`);
  return [...new Set(problems)].flatMap((problem) =>
    Object.entries(files[problem] ?? {})
      .filter(([ending]) => isNeeded(ending))
      .map(([ending, bytes]) => ({ problem, path: `bank/${problem}${ending}`, bytes })),
  );
}

const makeAddress = ({ path }: BankFile): string => new URL(`${ROOT}${path}`, window.location.href).href;

/** Return the cache of the service worker; null if the browser has none, or stores nothing. */
export async function openCache(): Promise<Cache | null> {
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
export async function listMissing(cache: Cache, files: readonly BankFile[]): Promise<BankFile[]> {
  const stored = new Set((await cache.keys()).map(({ url }) => url));
  return files.filter((file) => !stored.has(makeAddress(file)));
}

/** How many files are fetched at the same time. */
const PARALLEL_DOWNLOADS = 4;

/** Load files into the cache until stopped, and call `onStored` for every file. Return how many failed. */
export async function fetchAll(
  cache: Cache,
  files: readonly BankFile[],
  onStored: (file: BankFile) => void,
  signal: AbortSignal,
): Promise<number> {
  const queue = [...files];
  let failedCount = 0;
  const fetchFromQueue = async (): Promise<void> => {
    for (let file = queue.shift(); file && !signal.aborted; file = queue.shift()) {
      try {
        const response = await fetch(makeAddress(file), { signal });
        if (!response.ok) throw new Error(String(response.status));
        await cache.put(makeAddress(file), response);
        onStored(file);
      } catch {
        if (!signal.aborted) failedCount += 1;
      }
    }
  };
  await Promise.all(Array.from({ length: PARALLEL_DOWNLOADS }, fetchFromQueue));
  return failedCount;
}

/** Convert bytes to megabytes, rounded for display. */
export const roundToMegabytes = (bytes: number): number => {
  const size = bytes / 1e6;
  return Number(size < 10 ? size.toFixed(1) : size.toFixed(0));
};

export const sumBytes = (files: readonly BankFile[]): number => files.reduce((total, { bytes }) => total + bytes, 0);

export const countProblems = (files: readonly BankFile[]): number => new Set(files.map(({ problem }) => problem)).size;
