// A student's work in Firefox from start to finish: a lesson up to mastery of all classes of arms, the student's own arm,
// a round in another page's frame, and a saved lesson offline.
import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { served } from "../tools/browser.mjs";
import { firefox, Keys, MISSING } from "./bidi.mjs";
import { firefoxPage, keyboard } from "./hands.mjs";
import { answered, CLASSES, keptOffline, siteOfClasses, walkedToMastery, WORDS } from "./lesson.mjs";

const ARMS = 2;
describe("in Firefox, from beginning to end", { skip: MISSING }, () => {
  let folder, bank, remove, site, page;

  before(async () => {
    ({ folder, bank, remove } = siteOfClasses(ARMS));
    site = await served(folder);
  });
  after(() => {
    site?.close();
    remove?.();
  });

  for (const code of ["en", "de"])
    test(`a lesson is mastered by keyboard: ${code}`, async () => {
      page = await firefox(code === "de" ? "de-DE, de" : "en-GB, en");
      try {
        await page.size(1280, 900);
        const walk = { root: site.root, code, bank, lesson: "rates", classes: CLASSES };
        await walkedToMastery(firefoxPage(page), keyboard(firefoxPage(page)), walk, ARMS);
        assert.deepEqual(page.errors, []);
      } finally {
        await page.close();
      }
    });

  test("own arm: a link opens it, a number is typed, a joint is moved, and J follows", async () => {
    page = await firefox();
    try {
      await page.size(1280, 900);
      await page.open(`${site.root}/own.html#dh=R_q1_0_0.5_0~R_q2_0_0.4_0&angles=degrees&at=30_90`);
      const first = () =>
        page.run(() => Number(document.querySelector(".own-figures tbody td").innerText.replace("−", "-")));
      await page.until(() => document.querySelector(".own-figures tbody td"));
      const due = (a2, theta2) => -0.5 * Math.sin(Math.PI / 6) - a2 * Math.sin(((30 + theta2) * Math.PI) / 180);
      assert.ok(Math.abs((await first()) - due(0.4, 90)) < 1e-5);
      await page.run(() => {
        const cell = document.querySelector('[aria-label="a2"]');
        cell.focus();
        cell.select();
      });
      await page.keys(..."2/5 + 0.1", Keys.tab);
      await page.until(() => location.hash.includes("0.1"));
      assert.ok(Math.abs((await first()) - due(0.5, 90)) < 1e-5);
      await page.run(() => {
        const angle = document.querySelectorAll('.arm-joints input[type="number"]')[1];
        angle.focus();
        angle.select();
      });
      await page.keys(..."-40", Keys.tab);
      await page.until(() => location.hash.includes("at=30_-40"));
      assert.ok(Math.abs((await first()) - due(0.5, -40)) < 1e-5);
      assert.deepEqual(page.errors, []);
    } finally {
      await page.close();
    }
  });

  test("a round in a frame of another origin sends its score to the origin in the link", async () => {
    const around = mkdtempSync(join(tmpdir(), "qdot-firefox-course-"));
    writeFileSync(join(around, "page.html"), "<!DOCTYPE html><title>A course</title><body></body>");
    const course = await served(around);
    page = await firefox();
    try {
      await page.size(1280, 900);
      await page.open(`${course.root}/page.html`);
      const asked = "embed=1&n=1&seed=a&arm=planar-2r&question=determinant";
      await page.run(
        (source) => {
          window.heard = [];
          addEventListener("message", ({ origin, data }) => window.heard.push([origin, data]));
          const frame = document.createElement("iframe");
          Object.assign(frame, { src: source, width: 1200, height: 850 });
          document.body.append(frame);
        },
        `${site.root}/practice.html?${asked}&origin=${encodeURIComponent(course.root)}`,
      );
      await page.until(() => window.heard.length > 0);
      const frame = await page.frame();
      const item = await frame.until(
        () => document.querySelector(".task[data-item] form .answer")?.closest(".task").dataset.item,
      );
      const middle = await frame.run(() => {
        const field = document.querySelector(".formula-field");
        field.scrollIntoView({ block: "center" });
        const { x, y, width, height } = field.getBoundingClientRect();
        return [x + width / 2, y + height / 2];
      });
      await frame.drag("mouse", [middle]);
      const { typed } = bank(item).solved;
      await frame.keys(...typed, Keys.enter);
      const heard = await page.until(() => window.heard.length > 1 && window.heard);
      assert.deepEqual(
        heard.map(([origin, { event }]) => [origin, event]),
        [
          [site.root, "opened"],
          [site.root, "completed"],
        ],
      );
      assert.deepEqual(heard[1][1].score, { points: 1, max: 1, scaled: 1, answered: 1, count: 1 });
      assert.deepEqual(page.errors, []);
    } finally {
      await page.close();
      course.close();
      rmSync(around, { recursive: true, force: true });
    }
  });

  test("a stored lesson works offline, and so does the own arm", async () => {
    const own = await served(folder);
    page = await firefox();
    try {
      await page.size(1280, 900);
      await page.open(`${own.root}/learn.html?lesson=rates`);
      const [stock, hand] = [firefoxPage(page), keyboard(firefoxPage(page))];
      await keptOffline(stock, hand, "en");
      own.close();
      await assert.rejects(fetch(`${own.root}/learn.html`));
      await page.open(`${own.root}/learn.html?lesson=rates`);
      await page.until(() => document.querySelector(".dial input"));
      await hand.press(WORDS.en.practise);
      await answered(stock, hand, { code: "en", bank });
      await page.open(`${own.root}/own.html#robot=panda`);
      await page.until(() => document.querySelectorAll(".own-figures thead th").length === 8);
    } finally {
      await page.close();
      own.close();
    }
  });
});
