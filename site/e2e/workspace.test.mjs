// The layout of the workspace: at every width, arm and question are both visible, nothing overlaps, and nothing is cut off.
// Pointing at an entry of J highlights it in the drawing.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, emptyTab, inChromium, opened, openedAnew, PHONE } from "./opened.mjs";
import { bankOf } from "./site.mjs";

const there = inChromium();
const JACOBIAN = "practice.html?arm=planar-2r&question=jacobian&variation=chapter";
const SIZES = [
  [900, 800],
  [1440, 900],
  [3840, 2160],
];

const boxOf = (page, selector) => page.locator(selector).first().boundingBox();

/** Return how many pixels two boxes share. */
function common(a, b) {
  const across = Math.min(a.x + a.width, b.x + b.width) - Math.max(a.x, b.x);
  const down = Math.min(a.y + a.height, b.y + b.height) - Math.max(a.y, b.y);
  return Math.max(0, across) * Math.max(0, down);
}

const inside = ({ x, y, width, height }, [w, h]) => x >= -1 && y >= -1 && x + width <= w + 1 && y + height <= h + 1;

for (const [width, height] of SIZES) {
  test(`arm, map and question are side by side at ${width} x ${height}`, async () => {
    const { page, wrong } = await opened(there, JACOBIAN, { viewport: { width, height } });
    await page.locator(".arm-zero").first().waitFor({ state: "attached" });
    const [arm, map, field, strip] = await Promise.all(
      [".arm-box", ".arm-map-frame", ".formula-field", ".arm-strip"].map((part) => boxOf(page, part)),
    );
    for (const box of [arm, map]) assert.ok(inside(box, [width, height]), JSON.stringify(box));
    assert.ok(field.y < height, `the answer begins ${field.y} pixels down`); // the number of lines of a question depends on its font
    assert.ok(arm.x + arm.width < field.x, "the question is beside the arm");
    assert.ok(arm.height > 0.3 * height, `the drawing is ${arm.height} pixels high`);
    assert.equal(common(arm, strip), 0);
    await page.evaluate(() => scrollTo(0, 300));
    const after = await boxOf(page, ".arm-box");
    assert.ok(inside(after, [width, height]), "the arm stays in view");
    const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
    assert.deepEqual(wrong, []);
  });
}

test("on a very wide screen letters and ticks grow with the page, and the pointer meets what is drawn", async () => {
  const { page, wrong } = await opened(there, JACOBIAN, { viewport: { width: 3840, height: 2160 } });
  await page.locator(".arm-zero").first().waitFor({ state: "attached" });
  const sizes = await page
    .locator(".arm-letter-layer text, .arm-tick text")
    .evaluateAll((texts) => texts.map((text) => parseFloat(getComputedStyle(text).fontSize) * text.getScreenCTM().a));
  assert.ok(sizes.length > 10 && Math.min(...sizes) > 15, `${sizes}`);
  const middle = async (part) => {
    const { x, y, width, height } = await boxOf(page, part);
    return [x + width / 2, y + height / 2];
  };
  const off = async (part, [x, y]) => Math.hypot(...(await middle(part)).map((value, k) => value - [x, y][k]));
  const [x, y] = await middle(".arm-map-canvas");
  await page.mouse.click(x + 60, y + 40);
  await drawn(page);
  assert.ok((await off(".arm-here", [x + 60, y + 40])) < 3, "the map's pose is where it was clicked");
  const [px, py] = await middle(".arm-point-dot");
  await page.mouse.move(px, py);
  await page.mouse.down();
  await page.mouse.move(px - 20, py + 30, { steps: 5 });
  await drawn(page);
  assert.ok((await off(".arm-point-dot", [px - 20, py + 30])) < 3, "P is under the pointer");
  await page.mouse.up();
  assert.deepEqual(wrong, []);
});

for (const [width, height] of [
  [900, 700],
  [1440, 900],
])
  test(`the chart of a path is high enough to be read at ${width} x ${height}`, async () => {
    const options = { viewport: { width, height }, locale: "de-DE" };
    const { page } = await opened(there, "learn.html?lesson=path", options);
    await page.locator(".arm-chart-frame svg").waitFor();
    await drawn(page);
    const chart = await boxOf(page, ".arm-chart-frame");
    assert.ok(chart.height > 90, `${chart.height} pixels`);
    assert.ok(inside(await boxOf(page, ".arm-verdict"), [width, height]), "the words below it are visible");
  });

for (const robot of ["anthropomorphic-6r", "panda"])
  test(`J and the map of ${robot} are completely visible in a narrow column`, async () => {
    const options = { viewport: { width: 1280, height: 900 } };
    const { page, context } = await openedAnew(there, `own.html#robot=${robot}`, options);
    await page.waitForFunction((key) => document.querySelector(".own-begin select")?.value === key, robot);
    await page.locator(".arm-jacobian td").first().waitFor();
    await page.locator(".arm-map-canvas:not([hidden])").waitFor();
    const parts = [".arm-map .arm-row", ".arm-map-frame", ".arm-map .arm-legend", ".arm-map > .arm-hint"];
    await drawn(page);
    const cut = await page.locator(".arm-jacobian").evaluate((table) => {
      const last = table.querySelector("tbody td:last-child").getBoundingClientRect();
      return last.right - table.parentElement.getBoundingClientRect().right;
    });
    assert.ok(cut <= 1, `${cut} pixels of J are cut off`);
    const measured = await page.waitForFunction((selectors) => {
      const found = selectors.map((part) => document.querySelector(part)?.getBoundingClientRect());
      return found.every((box) => box?.height > 0) && found.map(({ y, height }) => ({ y, height }));
    }, parts); // each appears when it is worked out
    const boxes = await measured.jsonValue();
    for (let i = 1; i < boxes.length; i += 1) {
      const above = boxes[i - 1].y + boxes[i - 1].height;
      assert.ok(boxes[i].y >= above - 1, `${parts[i]} lies ${above - boxes[i].y} pixels over what is above it`);
    }
    const lines = await page.locator(".arm-map .arm-legend").evaluate((list) => {
      const inner = [...list.children].map((one) => one.getBoundingClientRect().bottom);
      return Math.max(...inner) - list.getBoundingClientRect().bottom;
    });
    assert.ok(lines <= 1, `${lines} pixels of the legend have no room`);
    await context.close();
  });

for (const [name, options] of [
  ["at 1440 x 900", { viewport: { width: 1440, height: 900 } }],
  ["on a phone", PHONE],
])
  test(`a verdict is visible, Check stays in place, and then Next is the main button: ${name}`, async () => {
    const { page } = await opened(there, JACOBIAN, options);
    const verdict = page.locator(".verdict");
    const inView = async () => {
      const [box, stage] = [await verdict.boundingBox(), await boxOf(page, ".stage")];
      const under = options === PHONE ? stage.y + stage.height : 0;
      const end = Math.min(box.y + box.height, under + options.viewport.height / 2); // only its beginning, if it is long
      return box.y >= under - 1 && Math.max(end, box.y + 90) <= options.viewport.height + 1;
    };
    const check = page.getByRole("button", { name: "Check", exact: true });
    const below = () =>
      check.evaluate((button) => button.getBoundingClientRect().top - button.form.getBoundingClientRect().top);
    const fields = page.locator(".formula-field");
    await fields.first().waitFor();
    const before = await below();
    const right = bankOf(there.site.folder).typed("jacobian");
    for (let i = 0; i < (await fields.count()); i += 1) await fields.nth(i).fill("sin(theta1)/2/(a1+1)");
    await page.locator(".preview math").waitFor();
    assert.equal(await below(), before, "Check is where it was before the answer was read");
    await check.click();
    await verdict.waitFor();
    await settles(inView, "the verdict on a wrong answer");
    assert.match(await check.getAttribute("class"), /^button/);
    await page.getByRole("button", { name: "Type it as text" }).click();
    const field = page.getByLabel("Your answer");
    await field.fill("[[1, 2");
    await field.press("Enter");
    await verdict.getByText("it doesn't count").waitFor();
    await field.fill(right);
    await page.evaluate(() => scrollTo(0, 0));
    await field.press("Enter");
    await page.locator(".verdict.correct").waitFor();
    await settles(inView, "the verdict on a right answer");
    assert.equal(await check.getAttribute("class"), "quiet");
    assert.equal(await page.getByRole("button", { name: "Next problem" }).getAttribute("class"), "button");
  });

/** Wait until a condition holds, because scrolling takes time. */
async function settles(holds, what) {
  for (let i = 0; i < 100; i += 1) {
    if (await holds()) return;
    await new Promise((done) => setTimeout(done, 50));
  }
  assert.fail(`not in view: ${what}`);
}

test("on a phone, the arm stays at the top while a student answers, and can be folded", async () => {
  const { page } = await opened(there, JACOBIAN, PHONE);
  await page.locator(".arm-box").waitFor();
  const field = page.locator(".formula-field").last();
  await field.scrollIntoViewIfNeeded();
  await field.focus();
  const [arm, typed] = [await boxOf(page, ".arm-box"), await field.boundingBox()];
  for (const box of [arm, typed]) assert.ok(inside(box, [390, 844]), JSON.stringify(box));
  assert.equal(common(await boxOf(page, ".stage"), typed), 0, "the field is not under the arm");
  assert.ok(typed.width > 240, `an entry that is typed is ${typed.width} pixels wide`);
  await page.getByRole("button", { name: "Map", exact: true }).tap();
  await page.locator(".arm-map-frame").waitFor();
  const [drawing, map] = [await boxOf(page, ".arm-box"), await boxOf(page, ".arm-map-frame")];
  assert.ok(inside(drawing, [390, 844]) && map.y + map.height < 700 && common(drawing, map) === 0);
  await page.getByRole("button", { name: "Fold" }).tap();
  assert.ok((await boxOf(page, ".stage")).height < 80);
  await page.getByRole("button", { name: "Show the arm" }).tap();
  await page.locator(".arm-box").waitFor();
  const pulled = async (by) => {
    const { x, y, height } = await boxOf(page, ".arm-tabs");
    await page.mouse.move(x + 60, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + 66, y + height / 2 + by, { steps: 5 });
    await page.mouse.up();
  };
  await pulled(-90);
  await page.getByRole("button", { name: "Show the arm" }).waitFor();
  assert.ok((await boxOf(page, ".stage")).height < 80, "folded by a pull");
  await pulled(90);
  await page.locator(".arm-box").waitFor();
});

test("pointing at a column of J highlights it in the drawing, and pointing at a link highlights its column", async () => {
  const { page } = await opened(there, JACOBIAN);
  await page.locator(".arm-jacobian tbody td").nth(1).hover();
  await page.locator(".arm-column.arm-j2.arm-lit").waitFor({ state: "attached" });
  const grip = page.locator(".arm-grip.arm-j1");
  await grip.hover({ force: true });
  await page.locator(".arm-jacobian td.arm-j1.arm-lit").first().waitFor();
});

test("the factor of det J that goes to zero is marked", async () => {
  const { page } = await opened(there, JACOBIAN);
  await page.locator(".arm-factors > div").nth(1).waitFor();
  assert.equal(await page.locator(".arm-vanishing").count(), 0);
  const angle = page.locator('.arm-joints input[type="number"]').nth(1);
  await angle.fill("1");
  await angle.press("Tab");
  await page.locator(".arm-vanishing math").waitFor();
  await angle.fill("90");
  await angle.press("Tab");
  await drawn(page);
  assert.equal(await page.locator(".arm-vanishing").count(), 0);
});

test("if the factors would reveal the answer, they are shown after it is right", async () => {
  const { page } = await opened(there, "practice.html?arm=planar-2r&question=determinant&variation=chapter");
  await page.locator(".arm-factors > div").first().waitFor();
  assert.equal(await page.locator(".arm-factors > div").count(), 1);
  await page.getByLabel("Your answer").fill("a1*a2*sin(theta2)");
  await page.getByRole("button", { name: "Check" }).click();
  await page.locator(".verdict").waitFor();
  if ((await page.locator(".verdict h3").innerText()) === "Right")
    await page.locator(".arm-factors > div").nth(1).waitFor();
  else assert.equal(await page.locator(".arm-factors > div").count(), 1);
});

test("the stage begins like the printed figure: in the problem's pose, with the table's symbols", async () => {
  const { page } = await opened(there, JACOBIAN);
  await page.locator(".arm-letter-layer").waitFor({ state: "attached" });
  const said = await page.locator(".arm-letter-layer text").allTextContents();
  const printed = await page.locator(".printed svg text").allTextContents();
  const letters = (texts) => new Set(texts.map((text) => text.replace(/\s/g, "")));
  for (const name of letters(printed)) assert.ok(letters(said).has(name), `${name} is in print only: ${said}`);
});

test("an option that is wider than a phone scrolls separately", async () => {
  const { page } = await opened(there, "practice.html?arm=planar-2r&question=singularity-type", PHONE);
  await page.locator(".option-text").first().waitFor();
  const wider = await page.evaluate(() => {
    for (const text of document.querySelectorAll(".option-text")) {
      const wide = document.createElement("div"); // like the matrices of an arm with seven joints
      wide.style.width = "900px";
      wide.style.height = "1em";
      text.append(wide);
    }
    return document.documentElement.scrollWidth - innerWidth;
  });
  assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
});

test("the columns of a wrong Jacobian are drawn beside the true ones, and move with the arm", async () => {
  const { page, wrong } = await opened(there, JACOBIAN);
  await page.getByRole("button", { name: "Type it as text" }).click();
  await page.getByLabel("Your answer").fill("[[a1*c1, 0], [a1*s1, a2*c12]]");
  await page.getByRole("button", { name: "Check" }).click();
  await page.getByText("The dashed arrows at P are the columns of your J").waitFor();
  const shaft = page.locator(".arm-own .arm-j1 .arm-shaft");
  await shaft.waitFor({ state: "attached" });
  const before = await shaft.getAttribute("points");
  await page.locator('.arm-joints input[type="range"]').first().focus();
  await page.keyboard.press("ArrowRight");
  await drawn(page);
  assert.notEqual(await shaft.getAttribute("points"), before);
  await page.getByLabel("Your answer").fill("[[a1*c1, 0], [a1*s1,"); // another answer has other columns
  await shaft.waitFor({ state: "detached" });
  assert.equal(await page.getByText("The dashed arrows at P").count(), 0);
  assert.deepEqual(wrong, []);
});

test("rows and columns of a matrix have labels beside their entries", async () => {
  for (const options of [{ viewport: { width: 1280, height: 900 } }, PHONE]) {
    const { page, wrong } = await opened(
      there,
      "practice.html?arm=planar-2r&question=geometric-jacobian&variation=chapter",
      options,
    );
    await page.locator(".grid .cell").first().waitFor();
    const [rows, heads, cells] = await Promise.all(
      [".of-row", ".belonging:not(.of-row)", ".cell"].map((part) =>
        page.locator(`.grid ${part}`).evaluateAll((found) =>
          found.map((one) => {
            const { x, y, width, height } = one.getBoundingClientRect();
            return { told: one.textContent, x: x + width / 2, y: y + height / 2 };
          }),
        ),
      ),
    );
    assert.deepEqual(
      rows.map(({ told }) => told),
      ["vx", "vy", "vz", "ωx", "ωy", "ωz"],
    );
    assert.deepEqual(
      heads.map(({ told }) => told),
      ["θ˙1", "θ˙2"],
    );
    cells.forEach(({ x, y }, i) => {
      assert.ok(Math.abs(rows[Math.floor(i / 2)].y - y) < 4 && rows[Math.floor(i / 2)].x < x);
      assert.ok(Math.abs(heads[i % 2].x - x) < 4 && heads[i % 2].y < y);
    });
    assert.deepEqual(wrong, []);
  }
});

/** Maximum sum of layout shifts while a page loads. */
const JUMPS = 0.05;

test("nothing jumps while a page loads: the arm's space is reserved", async () => {
  for (const options of [PHONE, { viewport: { width: 1440, height: 900 } }]) {
    const { page, context } = await emptyTab(there, options);
    await page.addInitScript(() => {
      window.jumped = 0;
      new PerformanceObserver((list) => {
        for (const entry of list.getEntries()) window.jumped += entry.value;
      }).observe({ type: "layout-shift", buffered: true });
    });
    for (const path of ["index.html", "learn.html?lesson=rates", JACOBIAN]) {
      await page.goto(`${there.server.root}/${path}`);
      await page.locator(".arm-point").waitFor();
      await drawn(page);
      const jumped = await page.evaluate(() => window.jumped);
      assert.ok(jumped < JUMPS, `${path}: ${jumped}`);
    }
    await context.close();
  }
});

test("on a German phone, all tabs of the stage are visible, and the page is no wider than the screen", async () => {
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=jacobian", {
    ...PHONE,
    locale: "de-DE",
  });
  const fold = page.locator(".arm-fold");
  await fold.waitFor();
  const { x, width } = await fold.boundingBox();
  assert.ok(x + width <= 390, `the fold ends at ${x + width}`);
  const tabs = await page
    .locator(".arm-tabs button:not(.arm-fold)")
    .evaluateAll((all) => all.map((tab) => tab.getBoundingClientRect().right));
  assert.ok(Math.max(...tabs) <= x, `the last tab ends at ${Math.max(...tabs)}, and the fold begins at ${x}`);
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  await context.close();
});
