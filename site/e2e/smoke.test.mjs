// The browser tests of `make test`: each kind of page opens, is accessible, and can be reached by keyboard; a right and a
// wrong answer are judged; a notebook is read; the first goal of a lesson is reached by touch, in German. `make whole`
// runs all other files, too, and goes through the pages by keyboard.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { KINDS } from "./kinds.mjs";
import { armOf, assertAccessible, inChromium, opened, PHONE } from "./opened.mjs";
import { bankOf } from "./site.mjs";
import { assertReached, assertWalked } from "./walk.mjs";

const IS_WHOLE = process.env.QDOT_SUITE === "whole";
const there = inChromium();

for (const path of KINDS)
  test(`${path} opens without errors, can be used by keyboard, and is accessible`, async () => {
    const { page, wrong } = await opened(there, path);
    await armOf(page);
    await (IS_WHOLE ? assertWalked(page) : assertReached(page));
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

test("a student's notebook is dropped: its answers are listed as they are read; so are a broken and a foreign file", async () => {
  const { notebook } = JSON.parse(readFileSync(new URL("../tests/notebook.json", import.meta.url), "utf8"));
  const typed = {
    "p1-determinant": "'a1*a2*s2'",
    "p1-jacobian": "'[a1, <b>x</b>]'",
    "p1-position": "Matrix([a1, a2])",
  };
  for (const cell of notebook.cells)
    if (typed[cell.id]) cell.source = `${cell.id.replace("-", "_")} = ${typed[cell.id]}`;
  const { page, wrong } = await opened(there, "check.html#velocity/501");
  const drop = (name, text) =>
    page.evaluate(
      ([name, text]) => {
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([text], name));
        document.querySelector(".drop").dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
      },
      [name, text],
    );
  await drop("velocity.ipynb", JSON.stringify(notebook));
  await page.locator(".checked.read math").waitFor();
  const found = await page.locator(".checked").allInnerTexts();
  const says = ["Python code", "Can't be read", "Can be read", "Left blank", "Left blank", "Left blank"];
  for (const [i, text] of found.entries()) assert.ok(text.includes(says[i]), text);
  assert.equal(found.length, says.length);
  assert.equal(
    await page.getByRole("heading", { name: "velocity.ipynb" }).evaluate((it) => it === document.activeElement),
    true,
  );
  await assertAccessible(page);
  await drop("essay.ipynb", '{"cells": [');
  await page.getByRole("alert").getByText("essay.ipynb is not a Jupyter notebook").waitFor();
  await drop("other.ipynb", '{"cells": [{"cell_type": "code", "source": "1"}]}');
  await page.getByRole("alert").getByText("no answer cells from qdot").waitFor();
  assert.equal(await page.locator(".checked").count(), 0);
  assert.deepEqual([...wrong, ...(await page.evaluate(() => window.refused))], []);
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
