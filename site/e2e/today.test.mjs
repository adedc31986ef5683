// Today's arm: the way to it, tries that are counted and kept, and the score that is copied once it is right.
import assert from "node:assert/strict";
import { test } from "node:test";

import { runnerImport } from "vite";

import { inChromium, openedAnew, WIDE } from "./opened.mjs";
import { bankOf } from "./site.mjs";

const there = inChromium();
const HOURS = 3600 * 1000;
/** Noon of many days, on one of which the arm is asked for its determinant. */
const NOONS = Array.from({ length: 400 }, (_, i) => Date.parse("2026-11-25T12:00:00Z") + i * 24 * HOURS);

test("tries at today's arm are counted and kept, and the score is there to share once it is solved", async () => {
  const { bank, typed } = bankOf(there.site.folder);
  const root = new URL("..", import.meta.url).pathname;
  const read = { root, configFile: false, logLevel: "error" };
  const { dayOf, itemOf } = (await runnerImport("./src/practice/today.ts", read)).module;
  const noon = NOONS.find((each) => itemOf(bank("index"), dayOf(each)).question === "determinant");
  const { page, wrong, context } = await openedAnew(there, "practice.html", { ...WIDE, noon });
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.evaluate(
    (yesterday) => {
      const kept = { day: yesterday, item: "another", tries: [true], helped: false, row: 2, last: yesterday };
      localStorage.setItem("qdot-today", JSON.stringify(kept));
    },
    dayOf(noon - 24 * HOURS),
  );
  await page.getByRole("link", { name: "Today's arm" }).click();
  await page.getByText("Not tried yet.").waitFor();
  const answer = async (text) => {
    await page.getByLabel("Your answer").fill(text);
    await page.getByRole("button", { name: "Check", exact: true }).click();
  };
  await answer(`-(${typed("determinant")})`);
  await page.getByText("✗ – tries so far: 1").waitFor();
  await page.reload();
  await page.getByText("✗ – tries so far: 1").waitFor();
  await answer(typed("determinant"));
  await page.getByText("✗ ✓ – solved, tries: 2. Days in a row: 3.").waitFor();
  await page.getByRole("button", { name: "Copy the score to share it" }).click();
  await page.getByText("Copied.").waitFor();
  const [first, asked, marks, link] = (await page.evaluate(() => navigator.clipboard.readText())).split("\n");
  assert.equal(first, `qdot, today's arm, ${dayOf(noon)}`);
  assert.match(asked, /^\S.*: \S/);
  assert.equal(marks, "✗ ✓");
  assert.equal(link, `${there.server.root}/practice.html?today=1`);
  assert.deepEqual(wrong, []);
  await context.close();
});
