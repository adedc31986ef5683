// The layout of every page, from a small phone to the widest screen, light or dark, in English or German: nothing overlaps,
// nothing is wider than the screen or cut off, and there are no holes.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { test } from "node:test";

import { faults } from "./faults.mjs";
import { KINDS } from "./kinds.mjs";
import { armOf, drawn, inChromium, opened } from "./opened.mjs";

const there = inChromium();
/** Sizes from a small phone to the widest screen, for phones and for wider screens. */
const SIZES = [
  [360, 740],
  [390, 844],
  [900, 800],
  [1440, 900],
  [3840, 2160],
];
const MORE = ["own.html#robot=panda", "course.html", "404.html", "licences.html"];
const ROUND = "practice.html?embed=1&arm=planar-2r&n=3&seed=a";
/** A question of each kind of answer: a vector, conditions, numbers, a direction, letters of three kinds. */
const QUESTIONS = [
  ...["position", "singular-angles", "joint-rates", "lost-direction", "inverse-velocity", "joint-torques"],
  ...["joint-effect", "singularity-type", "jacobian-size", "path-rates", "invertibility"],
].map((question) => `practice.html?arm=planar-2r&question=${question}`);
const LESSONS = ["rates", "columns", "differentiation", "propagation", "singular", "kinds", "path"].map(
  (lesson) => `learn.html?lesson=${lesson}`,
);
const OWN = [...KINDS, ...MORE, ...QUESTIONS, ...LESSONS, ROUND, `${ROUND}&lesson=columns`];

/**
 * Pages with the languages and colours in which they are tested. Each is opened once: half of them on a phone that
 * then grows, half on a wide screen that shrinks. German, which has longer words, is tested in all sizes. English, and
 * pages of text in one language, are tested at the smallest and the largest size.
 */
function looks() {
  const all = readdirSync(there.site.folder, { recursive: true, encoding: "utf8" })
    .map((name) => name.replaceAll("\\", "/"))
    .filter((name) => name.endsWith(".html"));
  return [...new Set([...OWN, ...all.sort()])].flatMap((path, i) => {
    const isOwn = OWN.includes(path);
    const locales = isOwn ? ["en-GB", "de-DE"] : [i % 2 === 0 ? "en-GB" : "de-DE"];
    return locales.map((locale, k) => {
      const sizes = isOwn && locale === "de-DE" ? SIZES : [SIZES[0], SIZES.at(-1)];
      return {
        path,
        locale,
        colorScheme: i % 4 < 2 ? "light" : "dark",
        sizes: (Math.floor(i / 2) + k) % 2 === 0 ? sizes : sizes.toReversed(),
      };
    });
  });
}

test("nothing overlaps, is cut off, is too wide or leaves a gap, from 360 pixels to 3840", async () => {
  const found = {};
  for (const { path, sizes, ...options } of looks()) {
    const [first] = sizes.map(([width, height]) => ({ width, height }));
    const { page } = await opened(there, path, { viewport: first, ...options });
    await armOf(page);
    for (const [width, height] of sizes) {
      await page.setViewportSize({ width, height });
      await page.evaluate(() => scrollTo(0, 0));
      await drawn(page);
      const wrong = await page.evaluate(faults);
      if (wrong.length > 0) found[`${path} ${options.locale} ${width}`] = wrong;
    }
  }
  assert.deepEqual(found, {});
});

test("overlaps, parts that are too wide, and gaps are found", async () => {
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
