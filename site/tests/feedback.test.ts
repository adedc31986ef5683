// @vitest-environment happy-dom
// What the page says of a wrong answer: the mistakes that are named, each with where it was made if it was there alone.
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { expect, test } from "vitest";

import type { Problem } from "../src/bank.js";
import { Words } from "../src/arm/letters.js";
import type { Verdict } from "../src/grade/verdict.js";
import { Feedback } from "../src/practice/feedback.js";
import { Rich } from "../src/practice/math.js";
import { message } from "../src/text/text.js";

const problem = {
  robot: { joints: [] },
  said: [
    ["relative-angle", "Relative angle", "An angle lacks the joints before it."],
    ["factor-lost", "Factor lost", "A factor is lacking.", "theta2, theta3"],
    ["column-of-p", "Wrong point", "Column 1 of J belongs to the velocity of P."],
  ],
} as unknown as Problem;

function told(more: Partial<Verdict>): string {
  const verdict: Verdict = { outcome: "wrong", share: 0, reasons: [], isSure: true, ...more };
  void act(() => render(h(Feedback, { problem, verdict, isDrawn: false }), document.body));
  return [...document.querySelectorAll(".mistake")].map((each) => each.textContent).join(" | ");
}

test("a mistake is reported with the missing part and the lost points", () => {
  expect(told({ mistake: 0 })).toMatch(/Relative angle\. An angle lacks the joints before it\.$/);
  told({ mistake: 2 });
  expect([...document.querySelectorAll(".mistake .letter")].map((letter) => letter.textContent)).toEqual(["J", "P"]);
  expect(told({ mistake: 1 })).toMatch(/A factor is lacking\. The missing factor contains θ2, θ3\. The arm/);
});

test("each of several mistakes is reported, with its place if it has one", () => {
  const where = message("slip.option", { letter: "B" });
  const slips = told({ slips: [{ mistake: 0, where }, { mistake: 1 }] });
  expect(slips).toContain("Option B: Relative angle");
  expect(slips).not.toContain("undefined");
  expect(document.querySelectorAll(".mistake li")).toHaveLength(2);
});

test("no line ends between a number and its unit, or beside the equals sign before a number", () => {
  const shown = (part: Parameters<typeof render>[0]): string => {
    void act(() => render(part, document.body));
    return document.body.textContent!.replaceAll("\u00a0", "~");
  };
  const text = "a1 = 1.02 m, fx = −1.4 N, qd2 = −1.12 rad/s: P moves at (1, 2) m/s and needs 3 N m or 5 more.";
  expect(shown(h(Words, { text }))).toBe(
    "a1~=~1.02~m, fx~=~−1.4~N, qd2~=~−1.12~rad/s: P moves at (1, 2)~m/s and needs 3~N~m or 5 more.",
  );
  shown(h(Rich, { text: "At $(1, 2)$ m/s, or $3$ metres." }));
  expect([...document.querySelectorAll(".whole")].map(({ lastChild }) => lastChild!.textContent)).toEqual([
    " m/s,",
    "",
  ]);
});
