// The same trees, refusals and verdicts as Python's reader and grader (readings.json by `python -m tests.tools.site_corpus`).
import { readFileSync } from "node:fs";

import { describe, expect, test } from "vitest";

import { parse } from "../src/read/reader.js";
import { ParseError } from "../src/read/tree.js";
import { LIMITS, VOCABULARY } from "../src/read/vocabulary.js";
import { type Answered, answered, type Asked, treeText } from "./readings.js";
import forms from "./forms.json" with { type: "json" };
import kept from "./readings.json" with { type: "json" };

interface Kept extends Pick<Asked, "symbols" | "problems"> {
  readonly readings: readonly (readonly [text: string, symbols: number, tree: string | null])[];
  readonly answers: readonly (readonly [k: number, part: string, text: string, outcome: string, share: number])[];
}

const KEPT = kept as unknown as Kept;
const SAID: Answered = answered(KEPT as unknown as Asked);
const shown = (text: string): string => text.slice(0, 60);

/** Words to which the grammar itself gives a meaning, and kinds of nodes that are called like one. */
const GRAMMAR = new Set(
  "pi theta sin cos abs in and or list set eq name number blank qd rate matrix diagonal image radians sqrt ... Derivative condition transposed inverse modulo \\\\ ±".split(
    " ",
  ),
);

describe("both readers", () => {
  test("there are many texts, some of them refused", () => {
    const refused = KEPT.readings.filter(([, , tree]) => tree === null).length;
    expect(KEPT.readings.length - refused).toBeGreaterThan(800);
    expect(refused).toBeGreaterThan(100);
  });

  test("read the same trees, and refuse the same texts", () => {
    const differing = KEPT.readings.flatMap(([text, symbols, tree], i) =>
      tree === SAID.readings[i] ? [] : [{ text: shown(text), symbols, python: tree, site: SAID.readings[i] }],
    );
    expect(differing).toEqual([]);
  });

  // Where a function has branches, or numbers are out of sight, the browser may not meet what differs, and says so.
  test("lead to the same verdicts", () => {
    const types = KEPT.problems.map(({ parts }) => new Map(parts.map(({ name, key }) => [name, key.type])));
    const differing = KEPT.answers.flatMap(([k, part, text, outcome, share], i) => {
      const [theirs, earned, sure] = SAID.verdicts[i]!;
      if (theirs === "correct" && !sure && types[k]!.get(part) !== "configurations") return [];
      if (theirs === outcome && Math.abs(earned - share) < 1e-6) return [];
      return [{ part, text: shown(text), python: [outcome, share], site: [theirs, earned] }];
    });
    expect(differing).toEqual([]);
  });

  test("give every form that is typed as text what the grader gives it", () => {
    const { answers, problems } = forms as unknown as Kept;
    const said = answered(forms as unknown as Asked);
    const types = new Map(problems[0]!.parts.map(({ name, key }) => [name, key.type]));
    const differing = answers.flatMap(([, part, text, outcome, share], i) => {
      const [theirs, earned, sure] = said.verdicts[i]!;
      const isUnsure = theirs === "correct" && !sure && types.get(part) !== "configurations";
      const isSame = theirs === outcome && Math.abs(earned - share) < 1e-6;
      return isUnsure || isSame ? [] : [{ part, text, python: [outcome, share], site: [theirs, earned] }];
    });
    expect(answers.length).toBeGreaterThan(300);
    expect(differing).toEqual([]);
  });

  test.each(["correct", "partial", "wrong", "missing"])("some answers are %s", (outcome) => {
    expect(KEPT.answers.filter((answer) => answer[3] === outcome).length).toBeGreaterThan(10);
  });
});

describe("the vocabulary", () => {
  test.each(Object.entries(VOCABULARY.functions))("%s is %s", (name, meant) => {
    const inner = meant === "atan2" ? "(1, 2)" : "(1)";
    expect(treeText(`${name}${inner}`, new Set())).toBe(treeText(`${meant}${inner}`, new Set()));
  });

  test.each(VOCABULARY.undefined)("%s is refused", (name) => expect(treeText(name, new Set())).toBeNull());

  // A synonym that is added in a module would be unknown to the grader. Single letters and signs are the grammar's own.
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

test("what nobody sees is written out where an error shows the place", () => {
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

const SIGNS = [
  ..."; , [ ] { } ( ) [[ ]] a1 theta1 0 pi 2.5 + - * / ^ = < | & : ' .. sin cos( and or in not for lambda mod matrix".split(
    " ",
  ),
  "\n",
];

test("signs in any order are read or refused", () => {
  let seed = 7;
  const drawn = (count: number): number => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor((seed / 2 ** 32) * count);
  };
  const known = new Set(["a1", "theta1"]);
  for (let k = 0; k < 5000; k += 1) {
    const text = Array.from({ length: drawn(10) }, () => SIGNS[drawn(SIGNS.length)]!).join(" ");
    try {
      parse(text, known);
    } catch (error) {
      if (!(error instanceof ParseError)) expect.fail(`${JSON.stringify(text)}: ${String(error)}`);
    }
  }
});
