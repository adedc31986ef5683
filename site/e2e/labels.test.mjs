// The letters of the stage lie over no other, for arms of all kinds, wide and on a phone, as they stand and moved.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, inChromium, openedAnew, PHONE } from "./opened.mjs";

const there = inChromium();
const ROBOTS = ["planar-2r", "scara", "anthropomorphic-6r", "puma560", "ur5e", "panda", "stanford"];

/** Letters that lie over each other, by the middle of the room that a browser gives them. */
const crowded = (page) =>
  page.locator(".arm-letter-layer text").evaluateAll((texts) => {
    const boxes = texts.map((text) => {
      const { left, right, top, bottom } = text.getBoundingClientRect();
      const middle = (top + bottom) / 2;
      return {
        name: text.textContent,
        left: left + 1,
        right: right - 1,
        top: middle - 6,
        bottom: middle + 6,
      };
    });
    return boxes.flatMap((a, i) =>
      boxes
        .slice(i + 1)
        .filter((b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
        .map((b) => `${a.name} over ${b.name}`),
    );
  });

for (const [name, options] of Object.entries({
  wide: { viewport: { width: 1440, height: 900 } },
  phone: PHONE,
})) {
  test(`no letter of the stage lies over another: ${name}`, async () => {
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
    }
    await context.close();
  });
}
