// SCORM packages in Moodle's own player, in Chromium, by students who log in: all is answered right but the last question,
// the player is left and opened again, and what it has kept is looked at. The request is JSON on standard input.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { launched } from "../../site/tools/browser.mjs";
import { about, answer, itemAt } from "./scorm_answers.mjs";

const { root, folder, students, activities } = JSON.parse(readFileSync(0, "utf8"));

async function loggedIn(browser, { username, password }) {
  const context = await browser.newContext({
    viewport: { width: 1400, height: 1000 },
  });
  const page = await context.newPage();
  await page.goto(`${root}/login/index.php`);
  await page.locator("#username").fill(username);
  await page.locator("#password").fill(password);
  await page.locator("#loginbtn").click();
  await page.waitForURL((url) => !url.pathname.includes("/login/"));
  return page;
}

/** The package in the player, where its first question is there to be answered. */
async function opened(page, { scorm, unit }) {
  await page.goto(`${root}/mod/scorm/player.php?a=${scorm}&scoid=${unit}&currentorg=&mode=normal`);
  const frame = page.frameLocator("#scorm_object");
  await frame.locator(".task[data-item] form .answer").waitFor({ timeout: 60000 });
  return frame;
}

/** What the places of a round show: which have been answered. */
const places = (frame) =>
  frame
    .locator(".round-places button")
    .evaluateAll((all) => all.map((place) => place.getAttribute("aria-label") ?? place.textContent));

async function ran(page, name, activity, isWhole) {
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  let frame = await opened(page, activity);
  const count = await frame.locator(".round-places button").count();
  const items = [];
  for (let place = 0; place < count; place += 1) {
    const item = await itemAt(frame, place);
    items.push(item);
    const isRight = isWhole || place < count - 1;
    await answer(frame, about(join(folder, name), item), isRight);
    await frame.locator(".verdict").first().waitFor();
  }
  const before = await places(frame);
  await page.waitForTimeout(1500); // the package tells the platform when nothing has happened for a while
  await page.goto(`${root}/my/`);
  frame = await opened(page, activity);
  const again = { places: await places(frame), items: [] };
  for (let place = 0; place < count; place += 1) {
    again.items.push(await itemAt(frame, place));
  }
  await page.goto(`${root}/my/`);
  return { items, before, again, errors };
}

const browser = await launched();
const told = {};
for (const [student, login] of Object.entries(students)) {
  const page = await loggedIn(browser, login);
  told[student] = {};
  for (const [name, activity] of Object.entries(activities))
    told[student][name] = await ran(page, name, activity, student === "ada");
  await page.context().close();
}
console.log(JSON.stringify(told));
await browser.close();
