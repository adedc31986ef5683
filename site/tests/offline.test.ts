// What is fetched for offline: the files of some problems in the page's language, those that are missing, failures counted.
import { afterEach, expect, test, vi } from "vitest";

import { fetchAll, listFiles, roundToMegabytes, listMissing, countProblems, sumBytes } from "../src/offline/cache.js";

const SIZES = {
  format: 1,
  files: {
    "a/1": { ".json": 10, ".de.json": 20, "/rank.json": 30, "/rank.de.json": 40 },
    "a/2": { ".json": 5, ".de.json": 6 },
  },
} as const;

const paths = (files: readonly { path: string }[]): string[] => files.map(({ path }) => path);
afterEach(() => vi.unstubAllGlobals());

test("each problem is stored once: in English, and in the language of the page", () => {
  expect(paths(listFiles(SIZES, ["a/2", "a/2", "b/1"], "en"))).toEqual(["bank/a/2.json"]);
  const all = listFiles(SIZES, ["a/1", "a/2"], "de");
  expect([sumBytes(all), countProblems(all), all.length]).toEqual([111, 2, 6]);
  expect(sumBytes(listFiles(SIZES, ["a/1"], "en"))).toBe(40);
});

test("stored files are not loaded again, failures are counted, and loading can be stopped", async () => {
  vi.stubGlobal("window", { location: { href: "https://site.example/course/learn.html" } });
  const all = listFiles(SIZES, ["a/1", "a/2"], "en");
  const base = "https://site.example/course/";
  const kept = new Map<string, unknown>([[`${base}bank/a/2.json`, 1]]);
  const cache = {
    keys: async () => [...kept.keys()].map((url) => ({ url })),
    put: async (url: string, answer: unknown) => void kept.set(url, answer),
  } as unknown as Cache;
  const missing = await listMissing(cache, all);
  expect(paths(missing)).toEqual(["bank/a/1.json", "bank/a/1/rank.json"]);
  vi.stubGlobal("fetch", async (url: string) => ({ ok: !url.includes("rank"), status: 404 }));
  const told: string[] = [];
  const control = new AbortController();
  expect(await fetchAll(cache, missing, ({ path }) => told.push(path), control.signal)).toBe(1);
  expect(told).toEqual(["bank/a/1.json"]);
  expect(paths(await listMissing(cache, all))).toEqual(["bank/a/1/rank.json"]);
  control.abort();
  expect(await fetchAll(cache, missing, ({ path }) => told.push(path), control.signal)).toBe(0);
  expect(told.length).toBe(1);
});

test.each([
  [0, 0],
  [1_234_000, 1.2],
  [9_960_000, 10],
  [123_400_000, 123],
])("%d bytes are %d MB", (bytes, shown) => expect(roundToMegabytes(bytes)).toBe(shown));
