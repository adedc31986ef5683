// Problems kept for offline: a lesson's at a click, with how much there is; then it is practised without a connection.
import assert from "node:assert/strict";
import { test } from "node:test";

import { inChromium, openedAnew, WIDE } from "./opened.mjs";

const there = inChromium();

test("a lesson is kept whole, and is practised with no connection though no problem of it was opened", async () => {
  const { page, wrong, context } = await openedAnew(there, "learn.html?lesson=rates", {
    ...WIDE,
    serviceWorkers: "allow",
  });
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.getByText("Keep this lesson for offline").click();
  const keep = page.getByRole("button", { name: /^Keep the rest \([\d.]+ MB\)$/ });
  await keep.click();
  await page.getByText(/^All \d+ problems are kept here/).waitFor();
  assert.equal(await keep.count(), 0);
  await context.setOffline(true);
  await page.reload();
  await page.getByRole("button", { name: "Practise already" }).click();
  await page.locator("form .answer").waitFor();
  await page.getByText("Keep this lesson for offline").waitFor({ state: "detached" });
  await page.goto(`${there.server.root}/own.html#robot=panda`);
  await page.locator(".own-figures").waitFor();
  assert.deepEqual(
    wrong.filter((said) => !/ERR_INTERNET_DISCONNECTED/.test(said)),
    [],
  );
  await context.close();
});

test("a browser that keeps nothing is told so", async () => {
  const { page, context } = await openedAnew(there, "learn.html");
  await page.evaluate(() => Object.defineProperty(navigator, "serviceWorker", { value: {} }));
  await page.getByText("Keep this course for offline").click();
  await page.getByText(/This browser keeps nothing for offline here/).waitFor();
  await context.close();
});
