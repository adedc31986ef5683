// Complete a lesson from its idea to mastery of every class of arms, by keyboard or touch, in any browser and language.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { until } from "./hands.mjs";

const DAYS = 2 * 24 * 3600 * 1000;

/** Return a text of the page in its language. */
export const WORDS = {
  en: {
    practise: "Go straight to practice",
    skip: "Skip these steps",
    asText: "Type it as text",
    right: "Right",
    next: "Next problem",
    learned: "Learned.",
    mastered: "Mastered.",
    isMastered: "mastered",
    offline: { lesson: "Save this lesson for offline use", course: "Save this course for offline use" },
    keep: "Store the rest",
    kept: "All ",
    classes: { plain: "planar arms", space: "spatial arms", any: "any arms" },
  },
  de: {
    practise: "Gleich üben",
    skip: "Diese Schritte überspringen",
    asText: "Als Text eingeben",
    right: "Richtig",
    next: "Nächste Aufgabe",
    learned: "Gelernt.",
    mastered: "Das sitzt.",
    isMastered: "gemeistert",
    offline: { lesson: "Diese Lektion offline speichern", course: "Diesen Kurs offline speichern" },
    keep: "Den Rest speichern",
    kept: "Alle ",
    classes: { plain: "ebene Arme", space: "räumliche Arme", any: "beliebige Arme" },
  },
};

export const CLASSES = ["plain", "space", "any"];

/** Build a site with `variants` arms of every class, and of other families; return it, its bank, and how to delete it. */
export function siteOfClasses(variants, besides = []) {
  const folder = mkdtempSync(join(tmpdir(), "qdot-classes-"));
  const families = ["planar-2r", "elbow-3r", "random-2", ...besides];
  const arms = ["--families", families.join(), "--variation", "lengths"];
  execFileSync(
    process.env.QDOT ?? "qdot",
    ["site", "build", "--out", folder, "--variants", String(variants), ...arms],
    { stdio: "ignore" },
  );
  const bank = (name) => JSON.parse(readFileSync(join(folder, "bank", `${name}.json`), "utf8"));
  return { folder, families, bank, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** Return the text on the class of the current arm. */
const told = (page) => page.run(() => document.querySelector(".choosing [role=status]")?.textContent ?? "");

/** Answer the current question correctly, once it differs from `last`; return the question. */
export async function answered(page, hand, { code, bank }, last = "") {
  const item = await until(
    page,
    (last) => {
      const found = document.querySelector(".task[data-item] form .answer");
      const name = found?.closest(".task").dataset.item;
      return name !== last && !document.querySelector(".verdict") && name;
    },
    last,
  );
  const { key, solved } = bank(item);
  if (await page.run(() => Boolean(document.querySelector('form input[type="radio"]'))))
    await hand.choose('form input[type="radio"]', key.right[0]);
  else {
    const { asText } = WORDS[code];
    const isGrid = (name) =>
      [...document.querySelectorAll("form button")].some((each) => each.textContent.trim() === name);
    if (await page.run(isGrid, asText)) await hand.press(asText);
    await hand.type(".formula-field", solved.typed);
  }
  await hand.send();
  const verdict = await until(page, () => document.querySelector(".verdict h3")?.innerText);
  assert.equal(verdict, WORDS[code].right, item);
  return item;
}

/** Save the open lesson or course for offline use. */
export async function keptOffline(page, hand, code, what = "lesson") {
  const { offline, keep, kept } = WORDS[code];
  await page.run(() => navigator.serviceWorker.ready.then(() => true));
  await until(page, () => Boolean(document.querySelector(".offline summary")));
  await hand.press(offline[what]);
  await until(
    page,
    (keep) => [...document.querySelectorAll("button")].some((each) => each.textContent.startsWith(keep)),
    keep,
  );
  await hand.press(keep);
  const isKept = (kept) => document.querySelector(".offline [role=status]").innerText.startsWith(kept);
  await until(page, isKept, kept);
}

/** Open a lesson, try its idea with the first dial, and go on to the questions; if it `isKnown`, its goals are reached. */
async function begun(page, hand, { root, code, lesson }, isKnown) {
  await page.open(`${root}/learn.html?lesson=${lesson}`);
  await until(page, () => Boolean(document.querySelector(".dial input")));
  assert.equal(await page.run(() => document.querySelector(".dials").closest("[lang]").lang), code);
  assert.equal(await page.run(() => document.querySelector(".goals .reached") !== null), isKnown);
  await hand.slide(".dial + .dial input");
  await until(page, () => Boolean(document.querySelector(".goals li.reached")));
  await hand.press(WORDS[code].practise);
  if (isKnown) return;
  const itemOf = (last) => {
    const name = document.querySelector(".task[data-item]")?.dataset.item;
    return name !== last && name;
  };
  const step = await until(page, itemOf, "");
  await hand.press(WORDS[code].skip);
  await until(page, itemOf, step); // a step is not asked again at once
}

/**
 * Complete a lesson: answer about `arms` different arms of each class in a row, one class after the other, then about one
 * more of each class some days later. `walk` has root, code, bank, lesson, and the classes in their order.
 */
export async function walkedToMastery(page, hand, walk, arms) {
  const { classes, code } = walk;
  const words = WORDS[code];
  let last = "";
  /** Answer about arms of a class until the text on the class begins with the given words. */
  const goOn = async (name, outcome, most) => {
    const seen = new Set();
    const wanted = classes.length > 1 ? `${words.classes[name]} · ${outcome}` : outcome;
    for (let isDone = false; !isDone;) {
      assert.ok(seen.size < most, `${[...seen]} are answered, and it says: ${await told(page)}`);
      last = await answered(page, hand, walk, last);
      await until(page, () => Boolean(document.querySelector(".verdict-note"))); // the result is shown there
      const [family, key] = last.split("/");
      seen.add(`${family}/${key.replace("-quiz", "")}`);
      isDone = (await told(page)).startsWith(wanted);
      if (!isDone || name !== classes.at(-1)) await hand.press(words.next);
    }
    assert.equal(seen.size, most, `${[...seen]}`);
  };
  await begun(page, hand, walk, false);
  for (const name of classes) await goOn(name, words.learned, arms);
  await page.run(
    ([lesson, days]) => {
      const skills = JSON.parse(localStorage.getItem("qdot-lessons"));
      const { beyond = {}, ...first } = skills[lesson];
      for (const row of [first, ...Object.values(beyond)]) row.learned -= days; // some days pass
      localStorage.setItem("qdot-lessons", JSON.stringify({ ...skills, [lesson]: { ...first, beyond } }));
    },
    [walk.lesson, DAYS],
  );
  last = "";
  await begun(page, hand, walk, true);
  for (const name of classes) await goOn(name, words.mastered, 1);
  await page.open(`${walk.root}/learn.html`);
  const standing = await until(page, () => document.querySelector(".skill.is-mastered .skill-state")?.innerText);
  assert.ok(standing.endsWith(words.isMastered), standing);
  const next = () => document.querySelector(".way > .actions a").search;
  assert.equal(await page.run(next), "?lesson=columns");
}
