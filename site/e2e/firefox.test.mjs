// The built site in Firefox, if it is installed: at FIREFOX, or in the usual place of the system.
//
// Without it, or without WebSocket in Node, these optional tests are skipped.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, before, describe, test } from "node:test";

import { firefox, Keys, MISSING } from "./bidi.mjs";
import { served } from "./site.mjs";

describe("in Firefox", { skip: MISSING }, () => {
  let site, page;

  before(async () => {
    site = await served();
    page = await firefox();
    await page.size(1280, 900);
  });

  after(async () => {
    await page?.close();
    site?.close();
  });

  const ask = async (question) => {
    await page.open(`${site.root}/practice.html?arm=planar-2r&question=${question}`);
    await page.until(() => {
      document.querySelector("#arm")?.scrollIntoView(); // it loads when it is near the screen; its map loads last
      return Boolean(document.querySelector("form .answer") && document.querySelector(".arm-zero"));
    });
  };
  const press = (name) =>
    page.until((name) => {
      const found = [...document.querySelectorAll("button")].find((each) => each.textContent.trim() === name);
      found?.click();
      return Boolean(found);
    }, name);
  const answered = async (text) => {
    await page.run(() => document.querySelector(".formula-field").focus());
    await page.keys(...text);
    await press("Check");
    return page.until(() => document.querySelector(".verdict")?.innerText);
  };
  const pose = () =>
    page.run(() => [...document.querySelectorAll('.arm-joints input[type="number"]')].map((e) => Number(e.value)));
  const picture = async (name) => {
    if (process.env.SHOTS) writeFileSync(`${process.env.SHOTS}/firefox-${name}.png`, await page.shot());
  };

  test("a right answer is judged right, and typeset while it is typed", async () => {
    await ask("determinant");
    assert.match(await answered(site.typed("determinant")), /^Right/);
    await page.until(() => Boolean(document.querySelector(".preview math")));
    await picture("right");
  });

  test("feedback on a wrong answer shows a pose where it differs, and the arm moves there", async () => {
    await ask("determinant");
    const before = await pose();
    assert.match(await answered("a1*cos(theta2)"), /^Wrong[\s\S]*is wrong at/);
    await page.until((before) => {
      const fields = [...document.querySelectorAll('.arm-joints input[type="number"]')];
      return fields.some((each, index) => Number(each.value) !== before[index]); // after the verdict is painted
    }, before);
  });

  test("a formula is typed as mathematics", async () => {
    await ask("determinant");
    await press("Mathematics keyboard");
    await page.until(() =>
      Boolean(document.querySelector("math-field")?.shadowRoot?.querySelector("[part=keyboard-sink]")),
    );
    const middle = (place) =>
      page.run((place) => {
        const element = document.querySelector(place);
        element.scrollIntoView({ block: "center" });
        const { x, y, width, height } = element.getBoundingClientRect();
        return [x + Math.min(40, width / 2), y + height / 2];
      }, place);
    await page.drag("mouse", [await middle(".prompt p")]); // select some text of the page
    await page.drag("mouse", [await middle("math-field")]);
    await page.until(() => document.querySelector("math-field").shadowRoot.activeElement !== null);
    await page.keys(..."2sin(theta2");
    await page.until(() => document.querySelector("math-field").value.startsWith("2\\sin")); // MathLive lost the 2 here
    await picture("mathematics");
    await press("Check");
    assert.doesNotMatch(await page.until(() => document.querySelector(".verdict")?.innerText), /couldn't( be)? parse/i);
  });

  test("the arm is moved by keys, on the map, and along the path", async () => {
    await ask("position");
    const first = await pose();
    await page.run(() => document.querySelector(".arm-box").focus());
    await page.keys(Keys.right, Keys.right);
    assert.deepEqual(await pose(), [first[0] + 4, first[1]]);
    for (const pointer of ["mouse", "touch"]) {
      const [x, y, width, height] = await page.run(() => {
        const map = document.querySelector(".arm-map-frame");
        map.scrollIntoView({ block: "center" });
        const { x, y, width, height } = map.getBoundingClientRect();
        return [x, y, width, height];
      });
      const before = await pose();
      await page.drag(pointer, [
        [x + width / 2, y + height / 2],
        [x + width * (pointer === "mouse" ? 0.3 : 0.7), y + height / 4],
      ]);
      const after = await pose();
      assert.ok(Math.abs(after[0] - before[0]) > 5, `${pointer}: ${before} to ${after}`);
    }
    await picture("map");
    await press("Path");
    await press("Play");
    await page.until(() => Number(document.querySelector(".arm-play input").value) > 0.02);
    await press("Pause");
    await picture("path");
  });

  test("German pages have decimal commas", async () => {
    await page.run(() => localStorage.setItem("qdot-language", "de"));
    await ask("determinant");
    assert.match(await page.run(() => document.querySelector(".arm-figures").innerText), /\d,\d/);
    await page.run(() => localStorage.clear());
  });

  test("no page reports an error", async () => {
    await page.open(`${site.root}/index.html`);
    await page.run(() => navigator.serviceWorker.ready.then(() => true)); // Firefox calls what is cut off an error
    await page.until(() => Boolean(document.querySelector("[data-hero] svg")));
    await page.open(`${site.root}/practice.html?arm=planar-2r&set=a&sheet=2&key=1`);
    await page.until(() => Boolean(document.querySelector(".sheet-key math")));
    assert.deepEqual(page.errors, []);
  });
});
