// The catalogue: both languages fill in the same values, and no text that a student may see stands outside of it.
import { describe, expect, test } from "vitest";

import { judgeValues } from "../src/grade/values.js";
import { parse } from "../src/read/reader.js";
import { asMatrix, ParseError } from "../src/read/tree.js";
import { ENGLISH, formatNumber, message, textOf, type TextKey } from "../src/text/text.js";
import de from "../src/text/de.json" with { type: "json" };
import en from "../src/text/en.json" with { type: "json" };

const GERMAN = { code: "de", catalogue: de };
const filled = (text: string): string[] => [...text.matchAll(/\{([\w-]+)\}/g)].map(([all]) => all).sort();

describe("the catalogue", () => {
  test.each(Object.keys(en) as TextKey[])("%s has the same placeholders in both languages", (key) => {
    expect([...new Set(filled(de[key]))]).toEqual([...new Set(filled(en[key]))]);
  });

  test("numbers have the language's decimal sign, and inserted texts are translated", () => {
    const inside = message("read.at", { what: message("read.the-end"), at: 1.5, near: "x" });
    expect(textOf(inside)).toBe("the end (at character 1.5, near 'x')");
    expect(textOf(inside, GERMAN)).toBe("das Ende (bei Zeichen 1,5, nahe „x“)");
  });

  test.each([ENGLISH, GERMAN])(
    "numbers are written as browsers write them, with a true minus sign: $code",
    (language) => {
      const due = new Intl.NumberFormat(language.code, { maximumSignificantDigits: 6, useGrouping: false });
      const exponents = Array.from({ length: 60 }, (_, k) => 10 ** (k - 30));
      const sizes = exponents.flatMap((size) => [size, -1.5 * size, (size * 2) / 3, 9.999996 * size, 1234567 * size]);
      for (const value of [0, -0, 7, 100, 1e21, 0.30000000000000004, -123456.5, NaN, Infinity, -Infinity, ...sizes])
        expect(formatNumber(value, language)).toBe(due.format(value).replace("-", "−"));
    },
  );
});

describe("a text that can't be parsed", () => {
  const why = (text: string): ParseError => {
    try {
      parse(text, new Set(["theta1"]));
    } catch (error) {
      if (error instanceof ParseError) return error;
    }
    throw new Error(`${text} was read`);
  };

  test.each([
    ["2*(theta1", "')' is missing at the end (at character 10", "am Ende fehlt „)“"],
    [
      "2 3",
      "there is no operator between two numbers (at character 3",
      "zwischen zwei Zahlen fehlt ein Rechenzeichen (bei Zeichen 3",
    ],
    ["", "it is empty", "sie ist leer"],
    ["f(2)", "the function 'f' is unknown", "die Funktion „f“ ist unbekannt"],
  ])("%s is told in English and in German", (text, english, german) => {
    expect(why(text).message).toContain(english);
    expect(textOf(why(text).why, GERMAN)).toContain(german);
  });

  test("is reported in the page's language", () => {
    const key = {
      type: "values",
      symbols: ["theta1"],
      points: [[1]],
      rows: 1,
      columns: 1,
      right: [[1]],
      mistakes: [],
    } as const;
    const { reasons } = judgeValues("2*", key);
    expect(textOf(reasons[0]!, GERMAN)).toMatch(/^qdot kann deine Antwort nicht lesen: erwartet wird eine Zahl/);
  });
});

test("a matrix has the typed rows, one is enough, and an empty list is reported", () => {
  const shape = (text: string): number[] => asMatrix(parse(text, new Set())).map((row) => row.length);
  expect(shape("[[1, 2]]")).toEqual([2]);
  expect(shape("[5]")).toEqual([1]);
  expect(shape("[1, 2]")).toEqual([1, 1]);
  expect(shape("[[1, 2], [3, 4]]")).toEqual([2, 2]);
  expect(() => shape("[]")).toThrow("the list is empty");
});
