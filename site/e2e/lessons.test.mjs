// A lesson from its idea to mastery of all classes of arms, in Chromium: by keyboard alone and offline, each class with
// stored progress, and by touch in German.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { served } from "../tools/browser.mjs";
import { chromiumPage, keyboard, touch } from "./hands.mjs";
import { answered, CLASSES, keptOffline, siteOfClasses, walkedToMastery, WORDS } from "./lesson.mjs";
import { drawn, inChromium, openedAnew, PHONE, WIDE } from "./opened.mjs";

/** The number of arms of each class; all of them must be answered before a lesson is learned. */
const ARMS = 2;
const HANDS = { keyboard: [keyboard, WIDE], touch: [touch, PHONE] };
const WALKS = [
  ["keyboard", "en", true],
  ["touch", "de", false],
];

const there = inChromium();
let site;
before(() => (site = siteOfClasses(ARMS, ["puma-560"])));
after(() => site?.remove());

for (const [by, code, offline] of WALKS)
  test(`a lesson is mastered by ${by}: ${code}${offline ? ", offline" : ""}`, async () => {
    const server = await served(site.folder);
    const [handOf, options] = HANDS[by];
    const { page, wrong, context } = await openedAnew({ ...there, server }, "learn.html?lesson=rates", {
      ...options,
      locale: code === "de" ? "de-DE" : "en-GB",
      serviceWorkers: offline ? "allow" : "block",
    });
    const [chromium, hand] = [chromiumPage(page), handOf(chromiumPage(page))];
    try {
      if (offline) {
        await keptOffline(chromium, hand, code);
        await context.setOffline(true);
        server.close();
      }
      const walk = { root: server.root, code, bank: site.bank, lesson: "rates", classes: CLASSES };
      await walkedToMastery(chromium, hand, walk, ARMS);
      assert.deepEqual(wrong, []);
    } finally {
      await context.close();
      server.close();
    }
  });

test("free practice counts for the class of the arm, which is due for review after a day", async () => {
  const server = await served(site.folder);
  const path = "practice.html?arm=elbow-3r&question=position";
  const { page, wrong, context } = await openedAnew({ ...there, server }, path, WIDE);
  const chromium = chromiumPage(page);
  const practised = () => answered(chromium, keyboard(chromium), { code: "en", bank: site.bank });
  try {
    await practised();
    await page.getByText(`By differentiation, spatial arms: 1 of ${ARMS} right in a row`).waitFor();
    await page.evaluate(() => {
      const { differentiation } = JSON.parse(localStorage.getItem("qdot-lessons"));
      differentiation.beyond.space.learned = 1; // as if all answers were right some days ago
      localStorage.setItem("qdot-lessons", JSON.stringify({ differentiation }));
    });
    await page.goto(`${server.root}/practice.html`);
    await page.getByText("1 to review, about 2 minutes").waitFor();
    await page.getByRole("button", { name: "Answer them now" }).click();
    await page.locator(".due").getByText("By differentiation, spatial arms").waitFor();
    await page.locator('.task[data-item^="elbow-3r/"]').waitFor();
    await practised();
    await page.locator(".verdict").getByText("By differentiation, spatial arms: Mastered.").waitFor();
    await page.getByText("Nothing left to review.").waitFor();
    if (process.env.SHOTS) await page.screenshot({ path: `${process.env.SHOTS}/due.png` });
    await page.goto(`${server.root}/learn.html`);
    const link = page.getByRole("link", { name: "By differentiation", exact: true });
    const skill = page.locator(".skill", { has: link }).locator(".skill-state");
    await skill.getByText("started").waitFor(); // planar arms are not done yet
    assert.deepEqual(wrong, []);
  } finally {
    await context.close();
    server.close();
  }
});

test("a stored course has the arms of every class of every lesson offline", async () => {
  const server = await served(site.folder);
  const { page, wrong, context } = await openedAnew({ ...there, server }, "learn.html", {
    ...WIDE,
    locale: "de-DE",
    serviceWorkers: "allow",
  });
  const mastered = { row: [], learned: 1, mastered: 2e8 };
  try {
    await keptOffline(chromiumPage(page), keyboard(chromiumPage(page)), "de", "course");
    await context.setOffline(true);
    server.close();
    const lessons = await page
      .locator(".skill > a")
      .evaluateAll((all) => all.map(({ href }) => new URL(href).searchParams.get("lesson")));
    assert.equal(lessons.length, 12);
    const asked = new Set();
    for (const lesson of lessons)
      for (const done of [[], ["plain"], ["plain", "space"]]) {
        const beyond = Object.fromEntries(done.slice(1).map((name) => [name, mastered]));
        const skill = { goals: [], ...(done.length > 0 ? mastered : { row: [] }), beyond };
        await page.evaluate((kept) => localStorage.setItem("qdot-lessons", kept), JSON.stringify({ [lesson]: skill }));
        await page.goto(`${server.root}/learn.html?lesson=${lesson}&practise=1`);
        await page.locator(".task[data-item] form .answer").waitFor();
        assert.equal(await page.locator(".task h2").getAttribute("lang"), "de");
        const words = WORDS.de.classes[CLASSES[done.length]];
        assert.equal(await page.locator(".class-name").textContent(), words, lesson);
        asked.add((await page.locator(".task").getAttribute("data-item")).split("/")[0]);
      }
    assert.deepEqual([...asked].sort(), ["elbow-3r", "planar-2r", "random-2"]);
    await page.goto(`${server.root}/own.html#robot=panda`);
    await page.locator(".own-figures").waitFor();
    assert.deepEqual(wrong, []);
  } finally {
    await context.close();
    server.close();
  }
});

for (const locale of ["en-GB", "de-DE"])
  test(`all numbers and sliders beside a question are visible at 1440 x 900, for every arm: ${locale}`, async () => {
    const server = await served(site.folder);
    const options = { viewport: { width: 1440, height: 900 }, locale };
    const { page, wrong, context } = await openedAnew({ ...there, server }, "", options);
    const scrolled = () =>
      page
        .locator(".arm-side, .arm-side *, .arm-pane, .arm-pane *")
        .evaluateAll((all) =>
          all
            .filter((each) => getComputedStyle(each).overflowY === "auto" && each.scrollHeight > each.clientHeight + 1)
            .map((each) => `${each.className} by ${each.scrollHeight - each.clientHeight}`),
        );
    try {
      for (const path of [
        ...site.families.map((family) => `practice.html?arm=${family}&question=velocity`),
        "learn.html?lesson=kinds",
        ...["ur5", "puma560", "panda"].map((robot) => `own.html#robot=${robot}`),
      ]) {
        await page.goto("about:blank"); // a change after # alone would not load a new page
        await page.goto(`${server.root}/${path}`);
        await page.locator(".arm-side .arm-jacobian").waitFor();
        await page.waitForLoadState("networkidle"); // factors of det J, if any, load last
        await page.locator(".arm-map .arm-legend").waitFor();
        await drawn(page);
        assert.deepEqual(await scrolled(), [], path);
        const height = async () => (await page.locator(".arm-scene").boundingBox()).height;
        assert.ok((await height()) > 900 / 3, `${path}: the arm has ${await height()} pixels`);
        for (const angle of await page.locator('.arm-side input[type="number"]').all()) {
          await angle.fill("0");
          await angle.press("Enter");
        }
        await page.waitForTimeout(1000); // until the kind of a singularity is shown
        assert.deepEqual(await scrolled(), [], `${path}, stretched`);
        assert.ok((await height()) > 900 / 3, `${path}, stretched: the arm has ${await height()} pixels`);
        await page.locator(".arm-tabs button").nth(1).click(); // the path
        await drawn(page);
        assert.deepEqual(await scrolled(), [], `${path}, its path`);
      }
      assert.deepEqual(wrong, []);
    } finally {
      await context.close();
      server.close();
    }
  });
