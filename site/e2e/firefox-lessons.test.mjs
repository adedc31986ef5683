// What a student does in Firefox from beginning to end: a lesson to mastery by keyboard alone, in both languages; one's own
// arm; a round in another page's frame; a lesson that is kept, with no connection. All of it in `make whole`.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { served } from "../tools/browser.mjs";
import { firefox, Keys, MISSING } from "./bidi.mjs";

const left = process.env.QDOT_SUITE === "whole" ? false : "`make whole` does this";
const DAYS = 2 * 24 * 3600 * 1000;
/** What the page says, in the browser's language. */
const WORDS = {
  en: {
    practise: "Practise already",
    asText: "Type it as text",
    right: "Right",
    next: "Next problem",
    learned: "Learned.",
    mastered: "Mastered.",
  },
  de: {
    practise: "Schon üben",
    asText: "Als Text eingeben",
    right: "Richtig",
    next: "Nächste Aufgabe",
    learned: "Gelernt.",
    mastered: "Das sitzt.",
  },
};

/** Goes on by the Tab key until what has the focus is wanted. */
async function tabbedTo(page, isWanted, ...values) {
  for (let stops = 0; stops < 120; stops += 1) {
    if (await page.run(isWanted, ...values)) return;
    await page.keys(Keys.tab);
  }
  throw new Error(`no stop of the Tab key is ${isWanted} of ${values}`);
}

const onButton = (name) => document.activeElement?.textContent.trim() === name;
const onFirst = (place) => document.activeElement === document.querySelector(place);

async function pressed(page, name) {
  await tabbedTo(page, onButton, name);
  await page.keys(Keys.enter);
}

describe("in Firefox, from beginning to end", { skip: MISSING || left }, () => {
  let folder, site, page;

  before(async () => {
    folder = mkdtempSync(join(tmpdir(), "qdot-firefox-site-"));
    const arms = ["--families", "planar-2r", "--variants", "3", "--variation", "lengths"];
    execFileSync(process.env.QDOT ?? "qdot", ["site", "build", "--out", folder, ...arms], {
      stdio: "ignore",
    });
    site = await served(folder);
  });
  after(() => {
    site?.close();
    if (folder) rmSync(folder, { recursive: true, force: true });
  });

  const bank = (name) => JSON.parse(readFileSync(join(folder, "bank", `${name}.json`), "utf8"));
  const typed = (arm, kind) => bank(`${arm}.solutions`).parts.find(({ name }) => name === kind).typed;

  /** Answers the question that is there rightly, by keys; returns which it was. */
  async function answered(words, last = "") {
    const item = await page.until((last) => {
      const found = document.querySelector(".task[data-item] form .answer");
      const name = found?.closest(".task").dataset.item;
      return name !== last && !document.querySelector(".verdict") && name;
    }, last);
    const [family, key, kind] = item.split("/");
    if (await page.run(() => Boolean(document.querySelector('form input[type="radio"]')))) {
      const { right } = bank(`${family}/${key}`).parts.find(({ name }) => name === kind).key;
      await tabbedTo(page, onFirst, 'form input[type="radio"]');
      await page.keys(...Array.from({ length: right[0] }, () => Keys.down), Keys.space);
    } else {
      if (
        await page.run(
          (name) => [...document.querySelectorAll("button")].some((each) => each.textContent.trim() === name),
          words.asText,
        )
      )
        await pressed(page, words.asText);
      await tabbedTo(page, onFirst, ".formula-field");
      await page.keys(...typed(`${family}/${key}`, kind));
    }
    await page.keys(Keys.enter);
    const verdict = await page.until(() => document.querySelector(".verdict h3")?.innerText);
    assert.equal(verdict, words.right, item);
    return item;
  }

  for (const [code, words] of Object.entries(WORDS))
    test(`a lesson to mastery, by keyboard alone: ${code}`, async () => {
      page = await firefox(code === "de" ? "de-DE, de" : "en-GB, en");
      try {
        await page.size(1280, 900);
        await page.open(`${site.root}/learn.html?lesson=rates`);
        await page.until(() => document.querySelector(".dial input"));
        assert.equal(await page.run(() => document.querySelector(".dials").closest("[lang]").lang), code);
        await tabbedTo(page, onFirst, ".dial input");
        await page.keys(Keys.home);
        for (let i = 0; i < 60; i += 1) {
          if (await page.run(() => Number(document.activeElement.value) > -1e-6)) break;
          await page.keys(Keys.right);
        }
        await page.until(() => document.querySelector(".goals li.reached"));
        await pressed(page, words.practise);
        const told = () => page.run(() => document.querySelector(".choosing [role=status]")?.innerText ?? "");
        const arms = new Set();
        for (let last = ""; !(await told()).startsWith(words.learned);) {
          assert.ok(arms.size < 3, `${[...arms]} are answered, and it says: ${await told()}`);
          last = await answered(words, last);
          arms.add(last.split("/")[1]);
          if (!(await told()).startsWith(words.learned)) await pressed(page, words.next);
        }
        assert.equal(arms.size, 3);
        await page.run((days) => {
          const skills = JSON.parse(localStorage.getItem("qdot-lessons"));
          skills.rates.learned -= days; // the days go by
          localStorage.setItem("qdot-lessons", JSON.stringify(skills));
        }, DAYS);
        await page.open(`${site.root}/learn.html?lesson=rates`);
        await page.until(() => document.querySelector(".dial input"));
        await pressed(page, words.practise);
        await answered(words);
        await page.until(
          (mastered) => document.querySelector(".choosing [role=status]").innerText === mastered,
          words.mastered,
        );
        assert.deepEqual(page.errors, []);
      } finally {
        await page.close();
      }
    });

  test("one's own arm: a link opens it, a number is typed, the joint moved, and J follows", async () => {
    page = await firefox();
    try {
      await page.size(1280, 900);
      await page.open(`${site.root}/own.html#dh=R_q1_0_0.5_0~R_q2_0_0.4_0&angles=degrees&at=30_90`);
      const first = () =>
        page.run(() => Number(document.querySelector(".own-figures tbody td").innerText.replace("−", "-")));
      await page.until(() => document.querySelector(".own-figures tbody td"));
      const due = (a2, theta2) =>
        -0.5 * Math.sin(Math.PI / 6) - a2 * Math.sin(((30 + theta2) * Math.PI) / 180);
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

  test("a round in a frame of another origin tells its score to the page that the link names", async () => {
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
      const [family, key] = item.split("/");
      const middle = await frame.run(() => {
        const field = document.querySelector(".formula-field");
        field.scrollIntoView({ block: "center" });
        const { x, y, width, height } = field.getBoundingClientRect();
        return [x + width / 2, y + height / 2];
      });
      await frame.drag("mouse", [middle]);
      await frame.keys(...typed(`${family}/${key}`, "determinant"), Keys.enter);
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

  test("a lesson that is kept is practised with no connection, and one's own arm is there, too", async () => {
    const own = await served(folder);
    page = await firefox();
    try {
      await page.size(1280, 900);
      await page.open(`${own.root}/learn.html?lesson=rates`);
      await page.run(() => navigator.serviceWorker.ready.then(() => true));
      await page.until(() => document.querySelector(".offline summary"));
      await page.run(() => document.querySelector(".offline summary").click());
      await page.until(() => {
        const keep = [...document.querySelectorAll(".offline button")].find((each) =>
          /^Keep/.test(each.textContent),
        );
        keep?.click();
        return Boolean(keep);
      });
      await page.until(() =>
        /All \d+ problems are kept/.test(document.querySelector(".offline [role=status]").innerText),
      );
      own.close();
      await assert.rejects(fetch(`${own.root}/learn.html`));
      await page.open(`${own.root}/learn.html?lesson=rates`);
      await page.until(() => document.querySelector(".dial input"));
      await pressed(page, WORDS.en.practise);
      await answered(WORDS.en);
      await page.open(`${own.root}/own.html#robot=panda`);
      await page.until(() => document.querySelectorAll(".own-figures thead th").length === 8);
    } finally {
      await page.close();
      own.close();
    }
  });
});
