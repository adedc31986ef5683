// The letters in the drawing don't overlap, for arms of all kinds, on wide screens and on a phone, before and after moving
// the arm. They don't cover text or buttons either, even if the arm has moved to a counterexample.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, inChromium, openedAnew, PHONE } from "./opened.mjs";
import { bankOf } from "./site.mjs";

const there = inChromium();
const ROBOTS = ["planar-2r", "scara", "anthropomorphic-6r", "puma560", "ur5e", "panda", "stanford"];

/** Return letters that overlap, by the centres of their boxes. */
const crowded = (page) =>
  page.locator(".arm-letter-layer text").evaluateAll((texts) => {
    const boxes = texts.map((text) => {
      const { left, right, top, bottom } = text.getBoundingClientRect();
      const middle = (top + bottom) / 2;
      return { name: text.textContent, left: left + 1, right: right - 1, top: middle - 6, bottom: middle + 6 };
    });
    return boxes.flatMap((a, i) =>
      boxes
        .slice(i + 1)
        .filter((b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
        .map((b) => `${a.name} over ${b.name}`),
    );
  });

for (const [name, options] of Object.entries({ wide: { viewport: { width: 1440, height: 900 } }, phone: PHONE })) {
  test(`no labels of the stage overlap: ${name}`, async () => {
    const { page, context } = await openedAnew(there, "own.html", options);
    for (const robot of ROBOTS) {
      await page.evaluate((key) => (location.hash = `#robot=${key}`), robot);
      await page.waitForFunction((key) => document.querySelector(".own-begin select")?.value === key, robot);
      await page.locator(".arm-letter-layer text").first().waitFor({ state: "attached" });
      await drawn(page);
      assert.deepEqual(await crowded(page), [], robot);
      const letters = await page.locator(".arm-letter-layer text").allTextContents();
      assert.ok(
        letters.some((each) => each.startsWith("P")),
        `${robot}: P has its letter`,
      );
      for (const key of ["ArrowRight", "ArrowUp", "ArrowRight"]) {
        await page.locator(".arm-box").focus();
        await page.keyboard.press(`Shift+${key}`);
        await drawn(page);
        assert.deepEqual(await crowded(page), [], `${robot}, moved`);
      }
      await page.getByRole("button", { name: "Path", exact: true }).click();
      await page.locator(".arm-target").waitFor({ state: "attached" });
      await drawn(page);
      assert.deepEqual(await crowded(page), [], `${robot}, with a path`);
      const ends = await page.locator(".arm-letter-layer .arm-end text").allTextContents();
      assert.deepEqual([...ends].sort(), ["A", "B"], `${robot}: both ends are named`);
      await page.getByRole("button", { name: name === "wide" ? "Map" : "Path", exact: true }).click();
    }
    await context.close();
  });
}

/** Return letters that cover text or buttons, and parts of the arm and arrows that leave the drawing. */
const hidden = (page) =>
  page.locator(".arm-scene").evaluate((scene) => {
    const boxOf = (element) => element.getBoundingClientRect();
    const over = [...scene.querySelectorAll(".arm-readout, .arm-hint > span, .arm-view")]
      .map((element) => [element.textContent, boxOf(element)])
      .filter(([, { width }]) => width > 0);
    const letters = [...scene.querySelectorAll(".arm-letter-layer text")].flatMap((text) => {
      const { left, right, top, bottom } = boxOf(text);
      const middle = (top + bottom) / 2;
      return over
        .filter(([, b]) => left + 1 < b.right && b.left < right - 1)
        .filter(([, b]) => middle - 6 < b.bottom && b.top < middle + 6)
        .map(([words]) => `${text.textContent} over “${words}”`);
    });
    const frame = boxOf(scene.querySelector(".arm-box"));
    const outside = [...scene.querySelectorAll(".arm-grip, .arm-point-ring, .arm-column, .arm-view")]
      .filter((element) => element.getClientRects().length > 0)
      .filter((element) => {
        const { left, right, top, bottom } = boxOf(element);
        return left < frame.left || right > frame.right || top < frame.top || bottom > frame.bottom;
      });
    return [...letters, ...outside.map((element) => `${element.getAttribute("class")} is cut off`)];
  });

/** A wrong entry to type into every field, whose counterexample is far from the first pose, or near it. */
const WRONG = [
  ["planar-2r", "jacobian", "a1*c1 - a2*s12"],
  ["planar-2r", "position", "1000*s12"],
  ["scara", "position", "a1*c1 + d3"],
  ["scara", "jacobian", "a2*s1"],
  ["elbow-3r", "jacobian", "a2*c23*s1"],
];

for (const [name, options] of Object.entries({
  "on a narrow phone": { ...PHONE, viewport: { width: 360, height: 740 } },
  "on a phone": PHONE,
  "on a German phone": { ...PHONE, locale: "de-DE" },
  wide: { viewport: { width: 1440, height: 900 } },
}))
  test(`at a counterexample, labels avoid texts, and the arm and its arrows are visible: ${name}`, async () => {
    const { page, context } = await openedAnew(there, "404.html", options);
    const families = bankOf(there.site.folder)
      .bank("index")
      .families.map((family) => family.name);
    for (const [arm, question, answer] of WRONG.filter(([arm]) => families.includes(arm))) {
      await page.goto(`${there.server.root}/practice.html?arm=${arm}&question=${question}&variation=chapter`);
      await page.locator(".arm-letter-layer text").first().waitFor({ state: "attached" });
      await drawn(page);
      assert.deepEqual(await hidden(page), [], `${arm} as it stands first`);
      const fields = page.locator(".formula-field");
      for (let i = 0; i < (await fields.count()); i += 1) await fields.nth(i).fill(answer);
      await fields.last().press("Enter");
      await page.locator(".verdict").waitFor();
      await drawn(page);
      assert.deepEqual(await hidden(page), [], `${arm} at a counterexample`);
      assert.deepEqual(await crowded(page), [], arm);
    }
    await context.close();
  });
