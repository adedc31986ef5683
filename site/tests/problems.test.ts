// Problems in the language of the page: what is taken from a translation, and what stays English without one.
import { afterEach, expect, test, vi } from "vitest";

import type { Index, Problem, Solutions, TranslatedTexts } from "../src/bank.js";
import { translateSolutions, translateIndex, translateProblem } from "../src/text/problems.js";
import { ENGLISH, setLanguage } from "../src/text/text.js";
import de from "../src/text/de.json" with { type: "json" };

const part = {
  name: "rank",
  kind: "rank",
  title: "Rank",
  prompt: "<p>What?</p>",
  hints: ["a", "b", "c"],
  options: ["x", "y"],
  figure: "<svg/>",
};
const PROBLEM = {
  id: "scara/1",
  title: "SCARA arm",
  statement: "<p>The arm</p>",
  robot: { title: "SCARA arm", joints: [] },
  parts: [part],
  said: [["sign", "Sign", "Everything."]],
} as unknown as Problem;
const TEXTS: TranslatedTexts = {
  title: "SCARA-Arm",
  statement: "<p>Der Arm</p>",
  parts: [{ name: "rank", title: "Rang", prompt: "<p>Was?</p>", hints: ["d", "e", "f"], options: ["u", "v"] }],
  said: [["sign", "Vorzeichen", "Alles."]],
};
const INDEX: Index = {
  format: 1,
  feedback: "solutions",
  families: [
    { name: "scara", title: "SCARA arm", source: "", problems: [] },
    { name: "p1", title: "Our own arm", source: "", problems: [] },
  ],
  questions: [{ name: "rank", title: "Rank", source: "6.8", form: "" }],
};

afterEach(() => {
  setLanguage(ENGLISH);
  vi.unstubAllGlobals();
});

test("a translated problem has its texts from the translation, and everything else from the bank", () => {
  const told = translateProblem("de", PROBLEM, TEXTS);
  expect([told.lang, told.title, told.robot.title, told.said[0]?.[1]]).toEqual([
    "de",
    "SCARA-Arm",
    "SCARA-Arm",
    "Vorzeichen",
  ]);
  expect(told.parts[0]).toEqual({ ...part, ...TEXTS.parts[0] });
});

test("without a translation, or with another problem's, it stays English", () => {
  expect(translateProblem("de", PROBLEM, null)).toBe(PROBLEM);
  const [texts] = TEXTS.parts as [TranslatedTexts["parts"][number]];
  for (const other of [
    { ...TEXTS, parts: [{ ...texts, name: "speed" }] },
    { ...TEXTS, parts: [] },
    { ...TEXTS, parts: [{ ...texts, options: ["u"] }] },
    { ...TEXTS, parts: [{ ...texts, options: null }] },
    { ...TEXTS, said: [] },
  ])
    expect(translateProblem("de", PROBLEM, other)).toBe(PROBLEM);
});

test("titles are translated if there is a translation", () => {
  const titled = translateIndex("de", INDEX, { families: { scara: "SCARA-Arm" }, questions: { rank: "Rang" } });
  expect(titled.families.map(({ title, lang }) => [title, lang])).toEqual([
    ["SCARA-Arm", "de"],
    ["Our own arm", undefined],
  ]);
  expect(titled.questions[0]?.title).toBe("Rang");
  expect(translateIndex("de", INDEX, null)).toBe(INDEX);
});

test("solutions are translated part by part, or stay English", () => {
  const solutions: Solutions = {
    id: "scara/1",
    factors: [],
    parts: [{ name: "rank", solution: "<p>It is 2.</p>", figure: "<svg/>", typed: "2" }],
  };
  const told = translateSolutions("de", solutions, { parts: [{ name: "rank", solution: "<p>Es ist 2.</p>" }] });
  expect([told.lang, told.parts[0]?.solution, told.parts[0]?.typed]).toEqual(["de", "<p>Es ist 2.</p>", "2"]);
  expect(translateSolutions("de", solutions, null)).toBe(solutions);
  expect(translateSolutions("de", solutions, { parts: [{ name: "speed", solution: "" }] })).toBe(solutions);
});

test("only a German page loads translations, and stays English without one", async () => {
  const files: Record<string, unknown> = {
    "bank/scara/001.json": PROBLEM,
    "bank/scara/001.de.json": TEXTS,
    "bank/scara/002.json": PROBLEM,
  };
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (path: string) => {
    asked.push(path);
    return { ok: path in files, status: path in files ? 200 : 404, json: async () => files[path] };
  });
  const { loadProblem } = await import("../src/load.js");
  expect((await loadProblem("scara", "001")).lang).toBeUndefined();
  expect(asked).toEqual(["bank/scara/001.json"]);
  setLanguage({ code: "de", catalogue: de });
  expect((await loadProblem("scara", "001")).title).toBe("SCARA-Arm");
  expect((await loadProblem("scara", "002")).lang).toBeUndefined();
  expect(asked.filter((path) => path.endsWith(".de.json"))).toHaveLength(2);
});
