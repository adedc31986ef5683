// What `make test` tries in a browser: each kind of page opens, is reached by keyboard and is accessible; a right and a
// wrong answer are judged; the first goal of a lesson is reached by touch, in German. All other files are for `make whole`.
import assert from "node:assert/strict";
import { test } from "node:test";

import { KINDS } from "./kinds.mjs";
import { armOf, assertAccessible, inChromium, opened, PHONE } from "./opened.mjs";
import { bankOf } from "./site.mjs";
import { assertReached } from "./walk.mjs";

const there = inChromium();

for (const path of KINDS)
  test(`${path} opens without errors, can be used by keyboard, and is accessible`, async () => {
    const { page, wrong } = await opened(there, path);
    await armOf(page);
    await assertReached(page);
    await page.evaluate(() => (document.activeElement.blur(), scrollTo(0, 0)));
    await assertAccessible(page);
    assert.deepEqual([...wrong, ...(await page.evaluate(() => window.refused))], []);
  });

test("a wrong answer is judged wrong, a right one right, and then the solution is shown", async () => {
  const { page, wrong } = await opened(there, "practice.html?arm=planar-2r&question=determinant");
  const right = bankOf(there.site.folder).typed("determinant");
  const answer = async (text) => {
    await page.getByLabel("Your answer").fill(text);
    await page.locator(".preview math").waitFor();
    await page.getByRole("button", { name: "Check", exact: true }).click();
  };
  await answer(`-(${right})`);
  await page.locator(".verdict:not(.correct)", { hasText: "What seems to be wrong" }).waitFor();
  await answer(right);
  await page.locator(".verdict.correct").waitFor();
  await page.getByRole("button", { name: "Show the solution" }).click();
  await page.locator(".solution math").first().waitFor();
  assert.deepEqual(wrong, []);
});

test("a goal of a lesson is reached by touch, in Austrian German", async () => {
  const { page, wrong } = await opened(there, "learn.html?lesson=singular", { ...PHONE, locale: "de-AT" });
  await page.getByRole("heading", { name: "Singuläre Konfigurationen" }).waitFor();
  await page.getByRole("button", { name: "Gelenke", exact: true }).tap();
  const angle = page.locator('.arm-joints input[type="number"]').nth(1);
  await angle.fill("0");
  await angle.press("Enter");
  await page.locator(".goals li.reached").first().waitFor();
  assert.deepEqual(wrong, []);
});
