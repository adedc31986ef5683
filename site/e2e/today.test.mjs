// Today's arm: the way to it, a try that is counted and kept, and the score that is copied once it is right.
import assert from "node:assert/strict";
import { test } from "node:test";

import { inChromium, openedAnew } from "./opened.mjs";

const there = inChromium();

/** Answers whatever is asked today, in all likelihood wrongly. */
async function answer(page) {
  const asText = page.getByRole("button", { name: "Type it as text" });
  if (await asText.count()) await asText.click();
  const boxes = page.locator(".options input");
  const selects = page.locator(".match select");
  if (await boxes.count()) await boxes.last().check();
  else if (await selects.count())
    for (const select of await selects.all()) await select.selectOption({ index: 1 });
  const fields = page.locator(".answer .formula-field");
  const numbers = [1, 2, 3, 4, 5, 6, 7].map((count) => Array(count).fill("123456").join(", "));
  for (const typed of [numbers[0], "theta1 = 1", ...numbers.slice(1)]) {
    for (const field of await fields.all()) await field.fill(typed); // a formula, a condition, or so many numbers
    await page.getByRole("button", { name: "Check" }).click();
    await page.locator(".verdict").waitFor();
    if (!/can't be read/i.test(await page.locator(".verdict h3").innerText())) return;
  }
}

test("a try at today's arm is counted and kept, and the score is there to share once it is solved", async () => {
  const { page, wrong, context } = await openedAnew(there, "practice.html");
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.getByRole("link", { name: "Today's arm" }).click();
  await page.locator("form .answer").waitFor();
  await page.getByText("Not tried yet.").waitFor();
  await answer(page);
  const isRight = (await page.locator(".verdict h3").innerText()) === "Right";
  await page.getByText(isRight ? /^✓ – solved/ : /^✗ – tries so far: 1/).waitFor();
  await page.evaluate(() => {
    const kept = JSON.parse(localStorage.getItem("qdot-today"));
    localStorage.setItem(
      "qdot-today",
      JSON.stringify({ ...kept, tries: [false, true], row: 3, last: kept.day }),
    );
  });
  await page.reload();
  await page.getByText("✗ ✓ – solved, tries: 2. Days in a row: 3.").waitFor();
  await page.getByRole("button", { name: "Copy the score to share it" }).click();
  await page.getByText("Copied.").waitFor();
  const [first, asked, marks, link] = (await page.evaluate(() => navigator.clipboard.readText())).split("\n");
  assert.match(first, /^qdot, today's arm, \d{4}-\d\d-\d\d$/);
  assert.match(asked, /^\S.*: \S/);
  assert.equal(marks, "✗ ✓");
  assert.equal(link, `${there.server.root}/practice.html?today=1`);
  assert.deepEqual(wrong, []);
  await context.close();
});
