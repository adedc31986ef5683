// The arm in the browser: the map of det J walked on, the path played, by keys, by mouse and by finger.
import assert from "node:assert/strict";
import { test } from "node:test";

import { inChromium } from "./opened.mjs";
import { pagesOf } from "./site.mjs";

const open = pagesOf(inChromium());

/** Joint values as the number fields show them, in degrees. */
const pose = (opened) =>
  opened
    .locator('.arm-joints input[type="number"]')
    .evaluateAll((fields) => fields.map(({ value }) => Number(value)));

/** Where a share of the map's frame is on the page. */
async function onMap(opened, across, up) {
  const map = opened.locator(".arm-map-frame");
  await map.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await map.boundingBox();
  return [x + across * width, y + up * height];
}

/** A page with its arm, which comes when it is near to the screen. */
const page = async (path, options) => {
  const found = await open(path, options);
  await found.opened.locator("#arm").scrollIntoViewIfNeeded();
  return found;
};
const POSITION = "practice.html?arm=planar-2r&question=position";
test("the map is walked on by keys and by mouse, and the arm follows", async () => {
  const { opened, context, errors } = await page(POSITION);
  await opened.locator(".arm-map-frame").focus();
  const first = await pose(opened);
  await opened.keyboard.press("ArrowRight");
  await opened.keyboard.press("Shift+ArrowUp");
  assert.deepEqual(await pose(opened), [first[0] + 2, first[1] + 10]);
  await opened.mouse.move(...(await onMap(opened, 0.5, 0.5)));
  await opened.mouse.down();
  await opened.mouse.move(...(await onMap(opened, 0.8, 0.2)), { steps: 4 });
  await opened.mouse.up();
  const dragged = await pose(opened);
  assert.ok(dragged[0] > 60 && dragged[1] > 60, String(dragged));
  await opened.mouse.move(...(await onMap(opened, 0.2, 0.8)));
  assert.deepEqual(await pose(opened), dragged, "moves with no button held");
  const det = await opened.locator(".arm-figures dd").first().innerText();
  await opened.getByText(`Here: det J = ${det}`).waitFor();
  assert.deepEqual(errors, []);
  await context.close();
});

test("the map's lines are the singular configurations: walking onto one says so", async () => {
  const { opened, context } = await page(POSITION);
  await opened.locator("polyline.arm-boundary").first().waitFor({ state: "attached" });
  await opened.locator(".arm-map-frame").scrollIntoViewIfNeeded();
  const [x, y] = await opened
    .locator("polyline.arm-boundary")
    .first()
    .evaluate((line) => {
      const { x, y, height } = line.getBoundingClientRect();
      return [x + 40, y + height / 2];
    });
  await opened.mouse.click(x, y);
  await opened.locator(".arm-singular-pose").waitFor();
  await opened.locator(".arm-nearness", { hasText: "At the boundary of what the arm reaches." }).waitFor();
  await context.close();
});

test("the map is walked on by finger", async () => {
  const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
  const { opened, context, errors } = await page(POSITION, phone);
  await opened.locator(".arm-map-frame").waitFor();
  for (const [across, up] of [
    [0.3, 0.7],
    [0.8, 0.3],
  ]) {
    const before = await pose(opened);
    await opened.touchscreen.tap(...(await onMap(opened, across, up)));
    assert.notDeepEqual(await pose(opened), before);
  }
  assert.deepEqual(errors, []);
  await context.close();
});

test("the path is played, and the arm runs into its limits", async () => {
  const { opened, context, errors } = await page(POSITION);
  await opened.getByRole("button", { name: "Welding path" }).click();
  const place = opened.getByLabel("Place on the path");
  const at = async () => Number(await place.inputValue());
  assert.equal(await at(), 0);
  await opened.locator(".arm-verdict", { hasText: /cannot go on|would have to turn faster/ }).waitFor();
  const before = await pose(opened);
  await opened.getByRole("button", { name: "Play" }).click();
  await opened.waitForFunction(() => Number(document.querySelector(".arm-play input").value) > 0.02);
  await opened.getByRole("button", { name: "Pause" }).click();
  const paused = await at();
  assert.notDeepEqual(await pose(opened), before);
  await opened.waitForTimeout(200);
  assert.equal(await at(), paused);
  await place.focus();
  await opened.keyboard.press("End");
  await opened.locator(".arm-rates .arm-over").first().waitFor();
  await opened.keyboard.press("Home");
  assert.equal(await at(), 0);
  assert.deepEqual(errors, []);
  await context.close();
});

test("the path goes by steps where the system asks for no motion", async () => {
  const { opened, context, errors } = await page(POSITION, {
    reducedMotion: "reduce",
    viewport: { width: 390, height: 844 },
    hasTouch: true,
    isMobile: true,
  });
  await opened.getByRole("button", { name: "Welding path" }).tap();
  assert.equal(await opened.getByRole("button", { name: "Play" }).count(), 0);
  const place = opened.getByLabel("Place on the path");
  await opened.getByRole("button", { name: "Next step" }).tap();
  const once = Number(await place.inputValue());
  assert.ok(once > 0);
  await opened.waitForTimeout(200);
  assert.equal(Number(await place.inputValue()), once);
  assert.deepEqual(errors, []);
  await context.close();
});
