// A page of each kind on a phone in dark mode: the axe checker finds no errors, and nothing is wider than the screen.
import assert from "node:assert/strict";
import { test } from "node:test";

import { KINDS } from "./kinds.mjs";
import { armOf, assertAccessible, drawn, inChromium, opened, openedAnew, PHONE } from "./opened.mjs";

const there = inChromium();

for (const path of KINDS) {
  test(`${path} is accessible on a phone in the dark`, async () => {
    const { page, wrong } = await opened(there, path, { ...PHONE, colorScheme: "dark" });
    await armOf(page);
    await assertAccessible(page);
    assert.deepEqual(wrong, []);
  });
}

for (const locale of ["en-GB", "de-DE"])
  test(`the menu is one row on a narrow phone: ${locale}`, async () => {
    const narrow = { ...PHONE, viewport: { width: 360, height: 740 }, locale };
    const { page } = await opened(there, "accessibility.html", narrow);
    await page.locator("header.top .language select:enabled").waitFor(); // wait until the page is in its language
    const links = await page.locator("header.top nav a").evaluateAll((all) =>
      all.map((link) => {
        const { top, left, right } = link.getBoundingClientRect();
        return { top, left, right };
      }),
    );
    assert.ok(links.length >= 4);
    assert.deepEqual([...new Set(links.map(({ top }) => top))], [links[0].top]);
    links.slice(1).forEach(({ left }, i) => assert.ok(left >= links[i].right + 3, JSON.stringify(links)));
    assert.ok(links.at(-1).right <= 360, JSON.stringify(links.at(-1)));
  });

/** Move a finger slowly from one point to another; return how far the page scrolled. */
async function dragged(page, [x, y], [toX, toY]) {
  const finger = await page.context().newCDPSession(page);
  const send = (type, touchPoints) => finger.send("Input.dispatchTouchEvent", { type, touchPoints });
  const before = await page.evaluate(() => scrollY);
  await send("touchStart", [{ x, y }]);
  for (let step = 1; step <= 12; step += 1)
    await send("touchMove", [{ x: x + ((toX - x) * step) / 12, y: y + ((toY - y) * step) / 12 }]);
  await send("touchEnd", []);
  await finger.detach();
  await drawn(page);
  return (await page.evaluate(() => scrollY)) - before;
}

const middleOf = async (page, selector) => {
  const { x, y, width, height } = await page.locator(selector).first().boundingBox();
  return [x + width / 2, y + height / 2];
};

for (const path of ["", "learn.html?lesson=rates"])
  test(`a finger that begins on the arm moves the arm and not the page, on ${path || "the first page"}`, async () => {
    const { page } = await opened(there, path, PHONE);
    await armOf(page);
    for (const away of [
      [-40, -70],
      [0, -90],
      [0, 80],
    ]) {
      const [x, y] = await middleOf(page, ".arm-point-ring");
      assert.equal(await dragged(page, [x, y], [x + away[0], y + away[1]]), 0, `P by ${away}`);
      const now = await middleOf(page, ".arm-point-ring");
      assert.ok(Math.hypot(now[0] - x, now[1] - y) > 12, `P has moved by ${[now[0] - x, now[1] - y]}`);
    }
    const link = await page.locator(".arm-grip.arm-j2").evaluate((line) => {
      const [first, ...more] = line.points;
      const last = more.at(-1);
      const middle = new DOMPoint((first.x + last.x) / 2, (first.y + last.y) / 2);
      const { x, y } = middle.matrixTransform(line.getScreenCTM());
      return [x, y];
    });
    assert.equal(await dragged(page, link, [link[0], link[1] - 60]), 0, "a link");
  });

for (const locale of ["en-GB", "de-DE"])
  test(`no line of text is half under the arm after Next: ${locale}`, async () => {
    const { page, context } = await openedAnew(there, "learn.html?lesson=singular", { ...PHONE, locale });
    const cutLines = () =>
      page.evaluate(() => {
        const end = document.querySelector(".stage").getBoundingClientRect().bottom;
        const texts = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
        const cut = [];
        while (texts.nextNode()) {
          const range = document.createRange();
          range.selectNodeContents(texts.currentNode);
          const isCut = [...range.getClientRects()].some(({ top, bottom }) => top < end - 1 && bottom > end + 1);
          if (isCut && !texts.currentNode.parentElement.closest(".stage")) cut.push(texts.currentNode.data);
        }
        return cut;
      });
    await page.locator(".actions button").first().tap();
    let last = "";
    for (let step = 0; step < 3; step += 1) {
      await page.waitForFunction((last) => (document.querySelector(".task")?.dataset.item ?? last) !== last, last);
      last = await page.locator(".task").getAttribute("data-item");
      await page.locator(".stage .arm-point").waitFor();
      await page.waitForTimeout(1000); // until nothing moves
      assert.deepEqual(await cutLines(), [], `${last}, ${step}`);
      await page.locator("form .actions button.quiet").tap();
    }
    await context.close();
  });

test("a finger that begins beside the arm scrolls the first page", async () => {
  const { page } = await opened(there, "", PHONE);
  await armOf(page);
  const { x, y, height } = await page.locator(".arm-box").boundingBox();
  const start = [x + 12, y + height - 30];
  assert.ok((await dragged(page, start, [start[0], start[1] - 90])) > 30);
});

const PANES = { Joints: [], J: [], Map: [], Path: ["Rates", "Set it up", "Chart"], Shown: [] };

for (const [width, height] of [
  [360, 740],
  [390, 844],
])
  test(`the content of each pane of the stage is visible without scrolling: ${width} x ${height}`, async () => {
    const options = { ...PHONE, viewport: { width, height } };
    const { page, context } = await openedAnew(there, "own.html", options);
    const scrolled = () =>
      page
        .locator(".arm-pane, .arm-part, .arm-verdict")
        .evaluateAll((all) =>
          all
            .filter((each) => each.scrollHeight > each.clientHeight + 1)
            .map((each) => `${each.className} by ${each.scrollHeight - each.clientHeight}`),
        );
    for (const robot of ["planar-2r", "scara", "puma560", "panda"]) {
      await page.evaluate((key) => (location.hash = `#robot=${key}`), robot);
      await page.waitForFunction((key) => document.querySelector(".own-begin select")?.value === key, robot);
      for (const [pane, parts] of Object.entries(PANES)) {
        const tab = page.getByRole("button", { name: pane, exact: true });
        if ((await tab.getAttribute("aria-expanded")) === "false") await tab.tap();
        await drawn(page);
        if (pane === "Map") await page.locator(".arm-legend").waitFor();
        assert.deepEqual(await scrolled(), [], `${robot}, ${pane}`);
        for (const part of parts) {
          const button = page.getByRole("button", { name: part, exact: true });
          if ((await button.count()) === 0) continue; // the arm has no path
          await button.tap();
          await drawn(page);
          assert.deepEqual(await scrolled(), [], `${robot}, ${pane}, ${part}`);
        }
        const [arm, opened] = [
          await page.locator(".arm-box").boundingBox(),
          await page.locator(".arm-pane").boundingBox(),
        ];
        assert.ok(arm.height > 110 && opened.y >= arm.y + arm.height, `${robot}, ${pane}: the arm is above it`);
        assert.ok(opened.y + opened.height - arm.y < 0.72 * height, `${robot}, ${pane}: words have room below`);
      }
    }
    const chart = page.locator(".arm-chart-frame");
    await page.evaluate(() => (location.hash = "#robot=planar-2r"));
    await page.getByRole("button", { name: "Path", exact: true }).tap();
    assert.ok((await chart.boundingBox()).height > 80, "the chart is high enough to be read");
    await context.close();
  });

for (const [width, height] of [
  [360, 740],
  [900, 800],
])
  test(`the explanation of a dotted line covers no text about the arm at ${width} pixels`, async () => {
    const small = { ...PHONE, viewport: { width, height }, locale: "de-DE" };
    const { page } = await opened(there, "practice.html?arm=planar-2r&question=singular-angles", small);
    await page.locator(".arm-box").waitFor();
    await page.getByLabel("Deine Antwort").fill("theta2 = pi");
    await page.getByRole("button", { name: "Prüfen" }).click();
    const words = page.locator(".arm-lost-words");
    await words.waitFor();
    const [said, hint, box] = await Promise.all(
      [words, page.locator(".arm-drawing .arm-hint"), page.locator(".arm-box")].map((one) => one.boundingBox()),
    );
    if (width === 360) assert.equal(hint, null, "there is no room for both");
    else assert.ok(said.y + said.height <= hint.y + 1, "one lies over the other");
    const end = hint ?? said;
    assert.ok(end.y + end.height <= box.y + box.height, "below the drawing");
  });
