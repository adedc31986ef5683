// The parser and the grader give the same results as in Python (readings.json is written by tests.tools.site_corpus).
import { readFileSync } from "node:fs";

import { describe, expect, test } from "vitest";

import { parse } from "../src/read/reader.js";
import { ParseError } from "../src/read/tree.js";
import { LIMITS, VOCABULARY } from "../src/read/vocabulary.js";
import { type Results, resultsOf, type Input, treeText } from "./readings.js";
import forms from "./forms.json" with { type: "json" };
import expected from "./readings.json" with { type: "json" };

interface Expected extends Pick<Input, "symbols" | "problems"> {
  readonly readings: readonly (readonly [text: string, symbols: number, tree: string | null])[];
  readonly answers: readonly (readonly [k: number, part: string, text: string, outcome: string, share: number])[];
}

const EXPECTED = expected as unknown as Expected;
const RESULTS: Results = resultsOf(EXPECTED as unknown as Input);
const shortened = (text: string): string => text.slice(0, 60);

/** Words with a meaning in the grammar itself, and kinds of nodes. */
const GRAMMAR = new Set(
  "pi theta sin cos abs in and or list set eq name number blank qd rate matrix diagonal image radians sqrt ... Derivative condition transposed inverse modulo \\\\ ±".split(
    " ",
  ),
);

describe("both parsers", () => {
  test("there are many texts, and some can't be parsed", () => {
    const refused = EXPECTED.readings.filter(([, , tree]) => tree === null).length;
    expect(EXPECTED.readings.length - refused).toBeGreaterThan(800);
    expect(refused).toBeGreaterThan(100);
  });

  test("return the same trees, and refuse the same texts", () => {
    const differing = EXPECTED.readings.flatMap(([text, symbols, tree], i) =>
      tree === RESULTS.readings[i] ? [] : [{ text: shortened(text), symbols, python: tree, site: RESULTS.readings[i] }],
    );
    expect(differing).toEqual([]);
  });

  // If a function has branches, or values are very small, the browser may miss a difference; then it is not sure.
  test("lead to the same verdicts", () => {
    const types = EXPECTED.problems.map(({ parts }) => new Map(parts.map(({ name, key }) => [name, key.type])));
    const differing = EXPECTED.answers.flatMap(([k, part, text, outcome, share], i) => {
      const [verdict, points, isSure] = RESULTS.verdicts[i]!;
      if (verdict === "correct" && !isSure && types[k]!.get(part) !== "configurations") return [];
      if (verdict === outcome && Math.abs(points - share) < 1e-6) return [];
      return [{ part, text: shortened(text), python: [outcome, share], site: [verdict, points] }];
    });
    expect(differing).toEqual([]);
  });

  test("judge every form that is typed as text in the same way", () => {
    const { answers, problems } = forms as unknown as Expected;
    const results = resultsOf(forms as unknown as Input);
    const types = new Map(problems[0]!.parts.map(({ name, key }) => [name, key.type]));
    const differing = answers.flatMap(([, part, text, outcome, share], i) => {
      const [verdict, points, isSure] = results.verdicts[i]!;
      const isUnsure = verdict === "correct" && !isSure && types.get(part) !== "configurations";
      const isSame = verdict === outcome && Math.abs(points - share) < 1e-6;
      return isUnsure || isSame ? [] : [{ part, text, python: [outcome, share], site: [verdict, points] }];
    });
    expect(answers.length).toBeGreaterThan(300);
    expect(differing).toEqual([]);
  });

  test.each(["correct", "partial", "wrong", "missing"])("some answers are %s", (outcome) => {
    expect(EXPECTED.answers.filter((answer) => answer[3] === outcome).length).toBeGreaterThan(10);
  });
});

describe("the vocabulary", () => {
  test.each(Object.entries(VOCABULARY.functions))("%s is %s", (name, standardName) => {
    const inner = standardName === "atan2" ? "(1, 2)" : "(1)";
    expect(treeText(`${name}${inner}`, new Set())).toBe(treeText(`${standardName}${inner}`, new Set()));
  });

  test.each(Object.keys(VOCABULARY.undefined))("%s is refused", (name) => expect(treeText(name, new Set())).toBeNull());

  // The grader would not know a synonym added in a module. Single letters and signs belong to the grammar.
  test.each(["names", "notation", "latex", "tokens", "reader"])("%s has no list of its own", (module) => {
    const { limits: _, patterns: __, about: ___, habits: ____, ...tables } = VOCABULARY;
    const words = (table: unknown): string[] =>
      typeof table === "string" ? [table] : Object.entries(table as object).flatMap(([k, v]) => [k, ...words(v)]);
    const listed = new Set(words(tables).filter((word) => /..|[^\x00-\x7f]/u.test(word)));
    const source = readFileSync(new URL(`../src/read/${module}.ts`, import.meta.url), "utf8");
    const quoted = [...source.matchAll(/"((?:[^"\\]|\\.)*)"/g)].map(([, text]) => text as string);
    expect(quoted.filter((text) => listed.has(text) && !GRAMMAR.has(text))).toEqual([]);
  });

  test("a text that is too long is refused", () => {
    expect(treeText("1".padEnd(LIMITS.characters + 1), new Set())).toBeNull();
  });
});

test("an error shows invisible characters as escapes", () => {
  const refusals = ["2*\u202e\u0007theta1 @", "2*\ud835\udf03 @ 1"].map((text) => {
    try {
      return parse(text, new Set(["theta1"])).text;
    } catch (error) {
      return String(error);
    }
  });
  expect(refusals[0]).toContain("\\u202e\\u0007theta1");
  expect(refusals[1]).toContain("\ud835\udf03");
});

const TOKENS = [
  ..."; , [ ] { } ( ) [[ ]] a1 theta1 0 pi 2.5 + - * / ^ = < | & : ' .. sin cos( and or in not for lambda mod matrix".split(
    " ",
  ),
  "\n",
];

test("tokens in any order are parsed or raise a ParseError", () => {
  let seed = 7;
  const randomInteger = (count: number): number => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor((seed / 2 ** 32) * count);
  };
  const known = new Set(["a1", "theta1"]);
  for (let k = 0; k < 5000; k += 1) {
    const text = Array.from({ length: randomInteger(10) }, () => TOKENS[randomInteger(TOKENS.length)]!).join(" ");
    try {
      parse(text, known);
    } catch (error) {
      if (!(error instanceof ParseError)) expect.fail(`${JSON.stringify(text)}: ${String(error)}`);
    }
  }
});
