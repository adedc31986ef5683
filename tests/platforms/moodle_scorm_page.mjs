// Log in to Moodle as each student, answer SCORM packages in its player (in Chromium), leave the player, and open it again
// to see what it restores. Only "ada" answers the last question right. The request is JSON on standard input.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { launched } from "../../site/tools/browser.mjs";
import { answer, goToQuestion, loadQuestion } from "./scorm_answers.mjs";

const { root, folder, students, activities } = JSON.parse(readFileSync(0, "utf8"));

async function logIn(browser, { username, password }) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 1000 } });
  const page = await context.newPage();
  await page.goto(`${root}/login/index.php`);
  await page.locator("#username").fill(username);
  await page.locator("#password").fill(password);
  await page.locator("#loginbtn").click();
  await page.waitForURL((url) => !url.pathname.includes("/login/"));
  return page;
}

/** Open a package in the player, wait for its first question, and return its frame. */
async function openPackage(page, { scorm, unit }) {
  await page.goto(`${root}/mod/scorm/player.php?a=${scorm}&scoid=${unit}&currentorg=&mode=normal`);
  const frame = page.frameLocator("#scorm_object");
  await frame.locator(".task[data-item] form .answer").waitFor({ timeout: 60000 });
  return frame;
}

/** Return the labels of the places of a round, which say which have been answered. */
const readPlaces = (frame) =>
  frame
    .locator(".round-places button")
    .evaluateAll((buttons) => buttons.map((button) => button.getAttribute("aria-label") ?? button.textContent));

/** Answer a package, all right or all but the last question; return what was shown before and after reopening it. */
async function runPackage(page, name, activity, allRight) {
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  let frame = await openPackage(page, activity);
  const count = await frame.locator(".round-places button").count();
  const items = [];
  for (let place = 0; place < count; place += 1) {
    const item = await goToQuestion(frame, place);
    items.push(item);
    const isRight = allRight || place < count - 1;
    await answer(frame, loadQuestion(join(folder, name), item), isRight);
    await frame.locator(".verdict").first().waitFor();
  }
  const before = await readPlaces(frame);
  await page.waitForTimeout(1500); // the package reports to the platform when it has been idle for a while
  await page.goto(`${root}/my/`);
  frame = await openPackage(page, activity);
  const again = { places: await readPlaces(frame), items: [] };
  for (let place = 0; place < count; place += 1) {
    again.items.push(await goToQuestion(frame, place));
  }
  await page.goto(`${root}/my/`);
  return { items, before, again, errors };
}

const browser = await launched();
const visits = {};
for (const [student, login] of Object.entries(students)) {
  const page = await logIn(browser, login);
  visits[student] = {};
  for (const [name, activity] of Object.entries(activities))
    visits[student][name] = await runPackage(page, name, activity, student === "ada");
  await page.context().close();
}
console.log(JSON.stringify(visits));
await browser.close();
