// Go through a page with the Tab key alone.
import assert from "node:assert/strict";

/** Assert that the first Tab stop is the link to the content, and that the next one is in the content. */
export async function assertReached(page) {
  await page.evaluate(() => scrollTo(0, 0));
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.className), "skip", "the way to the content");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement.id), "main");
  await page.keyboard.press("Tab");
  const { html, seen } = await page.evaluate(focused);
  assert.ok(seen, `shows no focus: ${html}`);
}

/** Assert that every Tab stop is visible with its focus ring, and that none is missed. */
export async function assertWalked(page) {
  await page.evaluate(() => scrollTo(0, 0));
  const expected = await page.evaluate(stops);
  const met = [];
  for (let i = 0; i < expected + 50; i += 1) {
    await page.keyboard.press("Tab");
    const stop = await page.evaluate(focused);
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
}

/** Return the number of elements on the page that can have the focus. */
function stops() {
  return document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex]").length;
}

/** Describe the focus: whether it is visible, and whether it is at the page's last link; null outside the page. */
export function focused() {
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
    seen: (ringed || style.boxShadow !== "none") && inside,
    last: element === all[all.length - 1],
  };
}
