// What prompts say of typing letters is left out where letters are ticked; everything else stays.
import { expect, test } from "vitest";

import type { Part } from "../src/bank.js";
import { removeOptions, removeLetterInstructions } from "../src/practice/prompt.js";

const part = (prompt: string, options: string[] | null, type = "values"): Part =>
  ({ prompt, options, key: { type } }) as unknown as Part;
const LIST = "<ul>\n<li><strong>A.</strong> one</li>\n<li><strong>B.</strong> two</li>\n</ul>\n";

test.each([
  ["<p><strong>Answer:</strong> the letter, typed in quotes, for example <code>&quot;A&quot;</code>.</p>"],
  ["<p><strong>Antwort:</strong> <code>&quot;true&quot;</code> oder <code>&quot;false&quot;</code>.</p>"],
  ['<p><strong>Answer:</strong> three letters in quotes, as in <code>"ABC"</code>.</p>'],
])("%s is removed", (said) => {
  const asked = `<p><em>Which</em> of <strong>these</strong>?</p>\n${LIST}${said}\n`;
  expect(removeOptions(part(asked, ["one", "two"])).trim()).toBe("<p><em>Which</em> of <strong>these</strong>?</p>");
  expect(removeLetterInstructions(part(asked, ["one", "two"]))).toContain("<strong>B.</strong> two");
  expect(removeLetterInstructions(part(asked, ["one", "two"]))).not.toContain("quot");
});

test("the prompt for a formula is unchanged", () => {
  const asked = '<p><strong>Answer:</strong> as in <code>"A"</code>.</p>';
  expect(removeOptions(part(asked, null))).toBe(asked);
});

test("the prompt for a set of configurations has no examples in the syntax of a notebook", () => {
  const asked = "<p>Find all singular configurations.</p>";
  const typing = "<p><strong>Answer:</strong> a list. Examples: <code>[Eq(cos(theta1), 0)]</code>; values.</p>";
  expect(removeOptions(part(`${asked}\n${typing}`, null, "configurations")).trim()).toBe(asked);
});
