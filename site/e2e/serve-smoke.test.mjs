// The smoke test of `qdot serve` in `make test`: a student answers, the staff see it, and both pages are accessible.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launched } from "../tools/browser.mjs";
import { assertAccessible } from "./opened.mjs";
import { openQuestion, RIGHT, signIn, startService, submit } from "./service.mjs";

let browser;
let service;
before(async () => {
  [browser, service] = [await launched(), await startService()];
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

test("a student's answer is judged by the server, and the staff see its points at once", async () => {
  const staff = await signIn(browser, service, "staff:Grace Hopper");
  const table = await staff.open("class/");
  const row = table.getByRole("row", { name: /Ada Lovelace/ });
  await row.getByText("nothing yet").waitFor();
  const student = await signIn(browser, service, "s1");
  const page = await openQuestion(student, "determinant");
  await page.getByLabel("Your answer").fill(RIGHT.determinant);
  await submit(page);
  await page.locator(".verdict.correct").waitFor();
  await assertAccessible(page);
  await row.locator(".correct").waitFor();
  await assertAccessible(table);
  assert.deepEqual([...student.wrong, ...staff.wrong], []);
});
