// A page of each kind by the Tab key alone: every stop is in sight, with its ring.
import assert from "node:assert/strict";
import { test } from "node:test";

import { armOf, inChromium, KINDS, opened, PHONE, WIDE } from "./opened.mjs";

const there = inChromium();

for (const path of KINDS) {
  test(`${path} is walked through by keyboard, and every stop is seen`, async () => {
    const { page, context } = await opened(there, path);
    await armOf(page); // what is there is walked through, nothing comes meanwhile
    await page.evaluate(() => scrollTo(0, 0));
    await page.keyboard.press("Tab");
    assert.equal(
      await page.evaluate(() => document.activeElement.className),
      "skip",
      "the way to the content",
    );
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.id), "main");
    await page.evaluate(() => document.activeElement.blur());
    const expected = await page.evaluate(stops);
    const met = [];
    for (let i = 0; i < expected + 50; i += 1) {
      await page.keyboard.press("Tab");
      const stop = await page.evaluate(here);
      if (stop === null) break;
      met.push(stop);
      if (stop.last) break;
    }
    assert.deepEqual(
      met.filter(({ seen }) => !seen).map(({ html }) => html),
      [],
      "stops that show no focus",
    );
    assert.ok(met.at(-1)?.last, `the walk ends before the end of the page: ${met.at(-1)?.html}`);
    await context.close();
  });
}

/** How many things on the page can be focused. */
function stops() {
  return document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex]").length;
}

/** Where the focus is: whether it shows, whether it is at the page's last link; null outside of the page. */
function here() {
  const element = document.activeElement;
  if (!element || element === document.body) return null;
  const style = getComputedStyle(element);
  const box = element.getBoundingClientRect();
  const ringed = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
  const inside = box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth;
  const all = document.querySelectorAll("footer a[href]");
  return {
    html: element.outerHTML.slice(0, 160),
    inside,
    seen: (ringed || getComputedStyle(element, ":focus").boxShadow !== "none") && inside,
    last: element === all[all.length - 1],
  };
}

for (const [name, options] of [
  ["wide", WIDE],
  ["on a phone", PHONE],
]) {
  test(`what has the focus stays in sight when the arm comes, ${name}`, async () => {
    const { page, context } = await opened(there, "practice.html?arm=planar-2r&question=jacobian", options);
    let release;
    const held = new Promise((done) => (release = done));
    const asked = page.waitForRequest(/panel[^/]*\.js$/);
    await page.route(/panel[^/]*\.js$/, async (route) => (await held, route.continue()));
    await page.locator("footer a").first().focus();
    await asked;
    assert.equal(await page.locator(".arm-box").count(), 0);
    release();
    await page.locator(".arm-zero").first().waitFor({ state: "attached" });
    const { html, inside } = await page.evaluate(here);
    assert.match(html, /accessibility\.html/);
    assert.ok(inside, "the arm pushed it away");
    await context.close();
  });
}
