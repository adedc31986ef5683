// Every page by its geometry, from a small phone to the widest screen, light or dark, in English or German: nothing lies
// over anything, nothing is wider than the screen or cut off, and no hole is left between what there is.
import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { test } from "node:test";

import { faults } from "./faults.mjs";
import { KINDS } from "./kinds.mjs";
import { armOf, drawn, inChromium, opened } from "./opened.mjs";

const there = inChromium();
/** Phones, then wider screens: a page is opened in the first size of a row, and gets the others while it is there. */
const SCREENS = [
  [
    [360, 740],
    [390, 844],
  ],
  [
    [900, 800],
    [1440, 900],
    [2560, 1440],
    [3840, 2160],
  ],
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

/** The smallest and the largest of some sizes: pages of text only have to fit these. */
const edgesOf = (sizes) => [sizes[0], sizes.at(-1)];

/** Pages with the languages and the colours in which they are looked at; of the others, the language is but at their edges. */
function looks(screen) {
  const all = readdirSync(there.site.folder, { recursive: true, encoding: "utf8" })
    .map((name) => name.replaceAll("\\", "/"))
    .filter((name) => name.endsWith(".html"));
  return [...new Set([...OWN, ...all.sort()])].flatMap((path, i) => {
    const locales = OWN.includes(path) ? ["en-GB", "de-DE"] : [(i + screen) % 2 === 0 ? "en-GB" : "de-DE"];
    return locales.map((locale) => ({ path, locale, colorScheme: i % 2 === 0 ? "light" : "dark" }));
  });
}

for (const [k, sizes] of SCREENS.entries())
  test(`nothing overlaps, is cut off, is too wide or leaves a gap, from ${sizes[0][0]} pixels on`, async () => {
    const found = {};
    const [first] = sizes.map(([width, height]) => ({ width, height }));
    for (const { path, ...options } of looks(k)) {
      const { page } = await opened(there, path, { viewport: first, ...options });
      await armOf(page);
      for (const [width, height] of OWN.includes(path) ? sizes : edgesOf(sizes)) {
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
