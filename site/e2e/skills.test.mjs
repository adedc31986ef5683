// The graph of a student's progress: its boxes don't overlap, the keyboard reaches all of them, and texts repeat its lines.
import assert from "node:assert/strict";
import { test } from "node:test";

import { faults } from "./faults.mjs";
import { inChromium, openedAnew, PHONE, WIDE } from "./opened.mjs";

const there = inChromium();
const KEPT = {
  "qdot-lessons": {
    rates: { row: ["a/1", "a/2", "a/3"], learned: 1, mastered: 2e8, goals: [0, 1, 2] },
    columns: { row: ["a/1"], learned: 1, goals: [] },
  },
};

for (const [name, options] of Object.entries({ wide: WIDE, "on a German phone": { ...PHONE, locale: "de-DE" } })) {
  test(`the map of lessons, ${name}: nothing overlaps, and no word is broken`, async () => {
    const { page, wrong, context } = await openedAnew(there, "learn.html", options);
    await page.evaluate((kept) => {
      for (const [key, value] of Object.entries(kept)) localStorage.setItem(key, JSON.stringify(value));
    }, KEPT);
    await page.reload();
    await page.locator(".skill").nth(11).waitFor();
    assert.deepEqual(await page.evaluate(faults), []);
    // a word broken without a hyphen leaves a letter or two on a separate line
    const narrowest = await page
      .locator(".skill a")
      .evaluateAll((all) => Math.min(...all.flatMap((one) => [...one.getClientRects()].map(({ width }) => width))));
    assert.ok(narrowest >= 14, `a line of ${narrowest} pixels`);
    assert.deepEqual(wrong, []);
    await context.close();
  });
}

test("a lesson's state and what it builds on are available by keys and in words", async () => {
  const { page, context } = await openedAnew(there, "learn.html");
  await page.evaluate((kept) => {
    for (const [key, value] of Object.entries(kept)) localStorage.setItem(key, JSON.stringify(value));
  }, KEPT);
  await page.reload();
  const map = page.locator(".skill-map");
  await map.getByText("not started, comes next").first().waitFor();
  assert.equal(await map.getByText("comes next").count(), 3);
  await map.getByText("This lesson builds on: By differentiation, By cross products.").waitFor({ state: "attached" });
  await map.getByRole("link", { name: "By differentiation" }).focus();
  await page.keyboard.press("Enter");
  await page.waitForURL(/learn\.html\?lesson=differentiation$/);
  await context.close();
});
