// The arm in the browser: moving on the map of det J and playing the path, by keys, mouse and touch.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, emptyTab, inChromium, opened, PHONE, WIDE } from "./opened.mjs";
import { focused } from "./walk.mjs";

const there = inChromium();

/** Joint values as the number fields show them, in degrees. */
const pose = (page) =>
  page.locator('.arm-joints input[type="number"]').evaluateAll((fields) => fields.map(({ value }) => Number(value)));

/** Return the position on the page of a point that is given as shares of the map's frame. */
async function onMap(page, across, up) {
  const map = page.locator(".arm-map-frame");
  await map.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await map.boundingBox();
  return [x + across * width, y + up * height];
}

/** Open a page, and wait for its arm, which loads when it is near the screen. */
const withArm = async (path, options) => {
  const found = await opened(there, path, options);
  await found.page.locator(".arm-box").waitFor();
  return found;
};
const POSITION = "practice.html?arm=planar-2r&question=position";
test("the pose moves on the map by keys and by mouse, and the arm follows", async () => {
  const { page, wrong } = await withArm(POSITION);
  await page.locator(".arm-map-frame").focus();
  const first = await pose(page);
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowUp");
  assert.deepEqual(await pose(page), [first[0] + 2, first[1] + 10]);
  await page.mouse.move(...(await onMap(page, 0.5, 0.5)));
  await page.mouse.down();
  await page.mouse.move(...(await onMap(page, 0.8, 0.2)), { steps: 4 });
  await page.mouse.up();
  const dragged = await pose(page);
  assert.ok(dragged[0] > 60 && dragged[1] > 60, String(dragged));
  await page.mouse.move(...(await onMap(page, 0.2, 0.8)));
  assert.deepEqual(await pose(page), dragged, "moves with no button held");
  const det = await page.locator(".arm-figures dd").first().innerText();
  await page.getByText(`Here: det J = ${det}`).waitFor();
  assert.deepEqual(wrong, []);
});

test("the map's lines are singular configurations, which is reported when the pose is on one", async () => {
  const { page } = await withArm(POSITION);
  await page.locator("polyline.arm-boundary").first().waitFor({ state: "attached" });
  await page.locator(".arm-map-frame").scrollIntoViewIfNeeded();
  const [x, y] = await page
    .locator("polyline.arm-boundary")
    .first()
    .evaluate((line) => {
      const { x, y, height } = line.getBoundingClientRect();
      return [x + 40, y + height / 2];
    });
  await page.mouse.click(x, y);
  await page.locator(".arm-singular-pose").waitFor();
  await page.locator(".arm-nearness", { hasText: "At the boundary of the workspace." }).waitFor();
});

test("the pose moves on the map by touch", async () => {
  const { page, wrong } = await withArm(POSITION, PHONE);
  await page.getByRole("button", { name: "Map", exact: true }).tap();
  await page.locator(".arm-zero").first().waitFor({ state: "attached" });
  const here = () => page.locator(".arm-here").evaluate((dot) => dot.parentElement.getAttribute("transform"));
  for (const [across, up] of [
    [0.3, 0.7],
    [0.8, 0.3],
  ]) {
    const [before, arm] = [await here(), await page.locator(".arm-grip").first().getAttribute("points")];
    await page.touchscreen.tap(...(await onMap(page, across, up)));
    assert.notDeepEqual(await here(), before);
    assert.notEqual(await page.locator(".arm-grip").first().getAttribute("points"), arm, "the arm follows");
  }
  assert.deepEqual(wrong, []);
});

test("the path is played, and the arm runs into its limits", async () => {
  const { page, wrong } = await withArm(POSITION);
  await page.getByRole("button", { name: "Path", exact: true }).click();
  const place = page.getByLabel("Position on the path");
  const at = async () => Number(await place.inputValue());
  assert.equal(await at(), 0);
  await page.locator(".arm-verdict", { hasText: /can.t continue|would have to rotate faster/ }).waitFor();
  const before = await pose(page);
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction(() => Number(document.querySelector(".arm-play input").value) > 0.02);
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByRole("button", { name: "Play" }).waitFor();
  const paused = await at();
  assert.notDeepEqual(await pose(page), before);
  await drawn(page);
  assert.equal(await at(), paused);
  await place.focus();
  await page.keyboard.press("End");
  await page.getByRole("button", { name: "Rates", exact: true }).click();
  await page.locator(".arm-rates .arm-over").first().waitFor();
  await place.focus();
  await page.keyboard.press("Home");
  assert.equal(await at(), 0);
  assert.deepEqual(wrong, []);
});

test("the path advances by steps if the system asks for reduced motion", async () => {
  const { page, wrong } = await withArm(POSITION, { ...PHONE, reducedMotion: "reduce" });
  await page.getByRole("button", { name: "Path", exact: true }).tap();
  assert.equal(await page.getByRole("button", { name: "Play" }).count(), 0);
  const place = page.getByLabel("Position on the path");
  await page.getByRole("button", { name: "Next step" }).tap();
  const once = Number(await place.inputValue());
  assert.ok(once > 0);
  await drawn(page);
  assert.equal(Number(await place.inputValue()), once);
  assert.deepEqual(wrong, []);
});

for (const [name, options] of [
  ["wide", WIDE],
  ["on a phone", PHONE],
]) {
  test(`the focused element stays visible when the arm appears, ${name}`, async () => {
    const { page, context } = await emptyTab(there, options);
    let release;
    const held = new Promise((done) => (release = done));
    const asked = page.waitForRequest(/panel[^/]*\.js$/);
    await page.route(/panel[^/]*\.js$/, async (route) => (await held, route.continue()));
    await page.goto(`${there.server.root}/practice.html?arm=planar-2r&question=jacobian`);
    await asked;
    await page.locator("footer a").first().focus();
    assert.equal(await page.locator(".arm-box").count(), 0);
    release();
    await page.locator(".arm-box").waitFor({ state: "attached" });
    await drawn(page);
    const { html, inside } = await page.evaluate(focused);
    assert.match(html, /accessibility\.html/);
    assert.ok(inside, "the arm pushed it away");
    await context.close();
  });
}

test("arrows and parallelogram stay in the drawing in all poses of a lesson", async () => {
  const { page } = await opened(there, "learn.html?lesson=singular", { viewport: { width: 1440, height: 900 } });
  const fields = page.locator('.arm-side input[type="number"]');
  for (const [first, second] of [
    [40, 60], // near the first pose, the view is enlarged
    [30, 90],
    [20, 120],
    [60, 0],
    [0, 0],
    [90, 2],
    [-90, 0],
    [180, 0],
    [30, 45],
  ]) {
    for (const [i, angle] of [first, second].entries()) {
      await fields.nth(i).fill(String(angle));
      await fields.nth(i).press("Enter");
    }
    await drawn(page);
    const outside = await page.locator(".arm-box").evaluate((box) => {
      const { left, right, top, bottom } = box.getBoundingClientRect();
      return [...box.querySelectorAll(".arm-arrow, .arm-ellipse")]
        .map((mark) => mark.getBoundingClientRect())
        .filter((mark) => mark.left < left || mark.right > right || mark.top < top || mark.bottom > bottom).length;
    });
    assert.equal(outside, 0, `${first}, ${second}`);
  }
});

test("an arm that leaves its enlarged first view is shown whole, and comes under the pointer again", async () => {
  const { page, wrong } = await withArm(POSITION, WIDE);
  const box = await page.locator(".arm-box").boundingBox();
  const middle = async (name) => {
    const { x, y, width, height } = await page.locator(name).first().boundingBox();
    return [x + width / 2, y + height / 2];
  };
  const lengthOf = () =>
    page
      .locator(".arm-grip")
      .first()
      .evaluate((link) => link.getTotalLength());
  const near = await lengthOf();
  const point = await middle(".arm-point-dot");
  const base = [box.x + box.width / 2, box.y + box.height / 2]; // its position once everything is visible
  const drag = async ([x, y], [toX, toY], count) => {
    for (let k = 1; k <= count; k += 1) await page.mouse.move(x + ((toX - x) * k) / count, y + ((toY - y) * k) / count);
  };
  await page.mouse.move(...point);
  await page.mouse.down();
  const edge = [box.x + box.width / 2, box.y + box.height - 4];
  await drag(point, edge, 10);
  const there = [base[0] - 70, base[1] - 60];
  await drag(edge, there, 50);
  await drawn(page);
  const [x, y] = await middle(".arm-point-dot");
  assert.ok(Math.hypot(x - there[0], y - there[1]) < 1, `P is ${x - there[0]}, ${y - there[1]} away`);
  await page.mouse.up();
  assert.ok((await lengthOf()) < 0.8 * near);
  assert.deepEqual(wrong, []);
});

/** Drag P by some pixels, in steps. */
async function dragPoint(page, [dx, dy]) {
  const { x, y, width, height } = await page.locator(".arm-point-ring").boundingBox();
  const [px, py] = [x + width / 2, y + height / 2];
  await page.mouse.move(px, py);
  await page.mouse.down();
  await page.mouse.move(px + dx, py + dy, { steps: 8 });
  await page.mouse.up();
}

const angles = (page) =>
  page.locator('.arm-joints input[type="number"]').evaluateAll((fields) => fields.map(({ value }) => value));

test("the trace of P ends where P is, and First pose clears it", async () => {
  const { page } = await opened(there, "learn.html?lesson=singular", { viewport: { width: 1440, height: 900 } });
  await page.getByLabel("trace of P").check();
  await dragPoint(page, [-60, 50]);
  const points = (await page.locator(".arm-trace polyline").getAttribute("points")).split(" ");
  assert.ok(points.length > 8, points.join(" "));
  const [x, y] = points.at(-1).split(",").map(Number);
  const place = await page.locator(".arm-point").getAttribute("transform");
  const [px, py] = place.match(/[\d.]+/g).map(Number);
  assert.ok(Math.hypot(x - px, y - py) < 0.1, `${place} after ${points.at(-1)}`);
  await page.getByRole("button", { name: "First pose" }).click();
  assert.equal(await page.locator(".arm-trace polyline").count(), 0);
});

test("a drag is undone in one step, by a button or by Ctrl+Z in the drawing", async () => {
  const { page } = await opened(there, "learn.html?lesson=singular", { viewport: { width: 1440, height: 900 } });
  const first = await angles(page);
  await dragPoint(page, [-50, 30]);
  const second = await angles(page);
  await dragPoint(page, [20, 30]);
  const third = await angles(page);
  assert.equal(new Set([first, second, third].map(String)).size, 3);
  await page.locator(".arm-box").focus();
  await page.keyboard.press("Control+z");
  assert.deepEqual(await angles(page), second);
  await page.getByRole("button", { name: "Undo the move" }).click();
  assert.deepEqual(await angles(page), first);
  await page.getByRole("button", { name: "Redo the move" }).click();
  await page.locator(".arm-box").focus();
  await page.keyboard.press("Control+y");
  assert.deepEqual(await angles(page), third);
});

test("the slider of a symbolic length changes arm, J and map, and the pose stays", async () => {
  const { page } = await opened(there, "learn.html?lesson=singular", { viewport: { width: 1440, height: 900 } });
  const seen = async () => [
    await page.locator(".arm-jacobian tbody").innerText(),
    await page.locator(".arm-factors dd").first().innerText(),
    await page.locator(".arm-grip").first().getAttribute("points"),
  ];
  await page.getByRole("button", { name: "Map", exact: true }).click();
  const [before, pose] = [await seen(), await angles(page)];
  await page.getByRole("slider", { name: "Length a1" }).focus();
  for (let k = 0; k < 20; k += 1) await page.keyboard.press("ArrowRight");
  await page.locator(".arm-lengths").getByText("= 0.5 m").waitFor();
  await page.getByText("Here: det J = 0.109.").waitFor();
  (await seen()).forEach((text, i) => assert.notEqual(text, before[i]));
  assert.deepEqual(await angles(page), pose);
});
