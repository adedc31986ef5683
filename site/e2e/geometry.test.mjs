// Every page by its geometry, from a small phone to the widest screen, light and dark, in English and in German: nothing lies
// over anything, nothing is wider than the screen or cut off, and no hole is left between what there is. QDOT_SUITE=whole
// looks at every page in every size and language; else at one of each kind in three sizes, and at kinds of questions and
// lessons in one, others each day.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { test } from "node:test";

import { faults } from "./faults.mjs";
import { KINDS } from "./kinds.mjs";
import { armOf, drawn, inChromium, opened } from "./opened.mjs";

const there = inChromium();
const SIZES = [
  [360, 740],
  [390, 844],
  [900, 800],
  [1440, 900],
  [2560, 1440],
  [3840, 2160],
];
const MORE = ["practice.html?today=1", "own.html#robot=panda", "course.html", "404.html", "licences.html"];
const ROUND = "practice.html?embed=1&arm=planar-2r&n=3&seed=a";
/** A question of each kind of answer: a vector, conditions, numbers, a direction, letters of three kinds. */
const QUESTIONS = [
  ...["position", "singular-angles", "joint-rates", "lost-direction", "inverse-velocity", "joint-torques"],
  ...["joint-effect", "singularity-type", "jacobian-size", "path-rates", "invertibility"],
].map((question) => `practice.html?arm=planar-2r&question=${question}`);
const LESSONS = ["rates", "columns", "differentiation", "propagation", "singular", "kinds", "path"].map(
  (lesson) => `learn.html?lesson=${lesson}`,
);
const IN_TURN = [...QUESTIONS, ...LESSONS, ROUND, `${ROUND}&lesson=columns`];
const WHOLE = process.env.QDOT_SUITE === "whole";

/** Other pages each day, as in Python's tests/support/suites.py; a number of a day repeats a draw. */
const DAY = Number(process.env.QDOT_ROTATION ?? Math.floor(Date.now() / 86_400_000));

/** Pages that are looked at in the size with this number. */
function pages(size) {
  if (!WHOLE)
    return [
      ...[...KINDS, ...MORE].filter((_, i) => (i + size + DAY) % 2 === 0),
      ...IN_TURN.filter((_, i) => (i + size + DAY) % SIZES.length === 0),
    ];
  const all = readdirSync(there.site.folder, { recursive: true, encoding: "utf8" })
    .map((name) => name.replaceAll("\\", "/"))
    .filter((name) => name.endsWith(".html"));
  return [...new Set([...KINDS, ...MORE, ...IN_TURN, ...all.sort()])];
}

for (const [k, [width, height]] of SIZES.entries()) {
  test(`nothing lies over anything, is cut off, too wide or leaves a hole at ${width} pixels`, async () => {
    const found = {};
    for (const [i, path] of pages(k).entries()) {
      const colorScheme = i % 2 === 0 ? "light" : "dark";
      for (const locale of WHOLE ? ["en-GB", "de-DE"] : [(i + k + DAY) % 4 < 2 ? "en-GB" : "de-DE"]) {
        const { page } = await opened(there, path, { viewport: { width, height }, colorScheme, locale });
        await armOf(page).catch(() => undefined); // a page whose arm has no map is looked at as it is
        await page.evaluate(() => scrollTo(0, 0));
        await drawn(page);
        const wrong = await page.evaluate(faults);
        if (wrong.length > 0) found[`${path} ${locale}`] = wrong;
      }
    }
    assert.deepEqual(found, {});
  });
}

test("what lies over something, is too wide or leaves a hole is found", async () => {
  const { page } = await opened(there, "learn.html", { viewport: { width: 900, height: 800 } });
  await page.evaluate(() => {
    const put = (style) => {
      const text = Object.assign(document.createElement("p"), { textContent: "put here" });
      text.style.cssText = style;
      document.querySelector("main").append(text);
    };
    put("position: absolute; left: 30px; top: 120px");
    put("margin-top: 400px");
    put("width: 2000px");
    put("width: 20px; overflow: hidden; white-space: nowrap");
  });
  const wrong = (await page.evaluate(faults)).join("; ");
  for (const due of [
    /lie over each other/,
    /too wide: p “put here”/,
    /a hole of \d+ pixels/,
    /wider than the screen/,
    /cut off: p “put here”/,
  ])
    assert.match(wrong, due);
});
