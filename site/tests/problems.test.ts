// Problems in the language of the page: what is taken from a translation, and what stays English without one.
import { afterEach, expect, test, vi } from "vitest";

import type { Index, Problem, TranslatedArm, TranslatedQuestion } from "../src/bank.js";
import { translateIndex, translateProblem } from "../src/text/problems.js";
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
  solved: { solution: "<p>It is 2.</p>", figure: "<svg/>", typed: "2" },
};
const SAID = { 3: ["sign", "Sign", "Everything."] };
const ARM = {
  id: "scara/1",
  title: "SCARA arm",
  statement: "<p>The arm</p>",
  robot: { title: "SCARA arm", joints: [] },
};
const PROBLEM = { ...ARM, parts: [part], said: SAID } as unknown as Problem;
const ARM_TEXTS: TranslatedArm = { title: "SCARA-Arm", statement: "<p>Der Arm</p>" };
const TEXTS: TranslatedQuestion = {
  ...{ name: "rank", title: "Rang", prompt: "<p>Was?</p>", hints: ["d", "e", "f"], options: ["u", "v"] },
  said: { 3: ["sign", "Vorzeichen", "Alles."] },
  solved: { solution: "<p>Es ist 2.</p>" },
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
  const told = translateProblem("de", PROBLEM, ARM_TEXTS, TEXTS);
  expect([told.lang, told.title, told.robot.title, told.said[3]?.[1]]).toEqual([
    "de",
    "SCARA-Arm",
    "SCARA-Arm",
    "Vorzeichen",
  ]);
  const { said: _, ...texts } = TEXTS;
  expect(told.parts).toEqual([{ ...part, ...texts, solved: { ...part.solved, solution: "<p>Es ist 2.</p>" } }]);
});

test("without a translation, or with another problem's, it stays English", () => {
  expect(translateProblem("de", PROBLEM, null, TEXTS)).toBe(PROBLEM);
  for (const other of [
    null,
    { ...TEXTS, name: "speed" },
    { ...TEXTS, options: ["u"] },
    { ...TEXTS, options: null },
    { ...TEXTS, said: {} },
  ])
    expect(translateProblem("de", PROBLEM, ARM_TEXTS, other)).toBe(PROBLEM);
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

test("only a German page loads translations, and stays English without one", async () => {
  const files: Record<string, unknown> = {
    "bank/scara/001.json": ARM,
    "bank/scara/001/rank.json": { ...part, said: SAID },
    "bank/scara/001.de.json": ARM_TEXTS,
    "bank/scara/001/rank.de.json": TEXTS,
    "bank/scara/002.json": ARM,
    "bank/scara/002/rank.json": { ...part, said: SAID },
    "bank/scara/002.de.json": ARM_TEXTS,
  };
  const asked: string[] = [];
  vi.stubGlobal("fetch", async (path: string) => {
    asked.push(path);
    return { ok: path in files, status: path in files ? 200 : 404, json: async () => files[path] };
  });
  const { loadProblem } = await import("../src/load.js");
  expect((await loadProblem("scara", "001", "rank")).lang).toBeUndefined();
  expect(asked).toEqual(["bank/scara/001.json", "bank/scara/001/rank.json"]);
  setLanguage({ code: "de", catalogue: de });
  expect((await loadProblem("scara", "001", "rank")).title).toBe("SCARA-Arm");
  expect((await loadProblem("scara", "002", "rank")).lang).toBeUndefined();
  expect(asked.filter((path) => path.endsWith(".de.json"))).toHaveLength(4);
});
