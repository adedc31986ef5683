// A lesson from its idea to mastery of all classes of its arms, in Chromium: by keys alone and by a finger, in both
// languages, and with no connection, each class of arms by what was kept. `make whole` walks all of it, with more arms.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { served } from "../tools/browser.mjs";
import { chromiumPage, keyboard, touch } from "./hands.mjs";
import { CLASSES, keptOffline, siteOfClasses, walkedToMastery } from "./lesson.mjs";
import { inChromium, openedAnew, PHONE, WIDE } from "./opened.mjs";

const WHOLE = process.env.QDOT_SUITE === "whole";
const ARMS = WHOLE ? 3 : 1;
const HANDS = { keyboard: [keyboard, WIDE], touch: [touch, PHONE] };
const WALKS = Object.keys(HANDS).flatMap((by) =>
  ["en", "de"].flatMap((code) => [false, true].map((offline) => ({ by, code, offline }))),
);
/** Every hand in either language, two of these walks with no connection. */
const taken = ({ by, code, offline }) => WHOLE || offline === ((by === "touch") === (code === "de"));

const there = inChromium();
let site;
before(() => (site = siteOfClasses(ARMS)));
after(() => site?.remove());

for (const { by, code, offline } of WALKS.filter(taken))
  test(`a lesson to mastery by ${by}: ${code}${offline ? ", offline" : ""}`, async () => {
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
