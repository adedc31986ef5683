// The page for the student's own arm: typing and moving it, sharing it as a link and as a file, in German, on a phone, and
// from a wrong link.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

import { assertAccessible, drawn, inChromium, opened, openedAnew, PHONE } from "./opened.mjs";

const there = inChromium();
const TABLE = "own.html#dh=R_q1_0_0.5_0~R_q2_0_0.4_0&at=30_90";

const numbers = (page) => page.locator(".own-figures tbody td").allInnerTexts();
const value = (text) => Number(text.replace("−", "-").replace(",", "."));

/** J of the planar arm with a1 = 0.5, a2 = 0.4, row by row. */
function planar(theta1, theta2) {
  const [t1, t12] = [theta1, theta1 + theta2].map((angle) => (angle * Math.PI) / 180);
  const [x2, y2] = [0.4 * Math.cos(t12), 0.4 * Math.sin(t12)];
  return [-0.5 * Math.sin(t1) - y2, -y2, 0.5 * Math.cos(t1) + x2, x2];
}

const assertNear = (found, due) =>
  found.forEach((text, i) => assert.ok(Math.abs(value(text) - due[i]) < 1e-5, `${found} in place of ${due}`));

test("a link opens its table in its pose, and typing and moving change the address", async () => {
  const { page, wrong, context } = await openedAnew(there, `${TABLE}&angles=degrees`);
  await page.locator(".own-figures").waitFor();
  assertNear(await numbers(page), planar(30, 90));
  assert.equal(await page.getByLabel("a1", { exact: true }).inputValue(), "0.5");
  const angle = page.locator('.arm-joints input[type="number"]').nth(1);
  await angle.selectText();
  await page.keyboard.type("-40"); // a minus alone is not a number, but it stays in the field
  await angle.press("Tab");
  await page.waitForFunction(() => location.hash.includes("at=30_-40"));
  assertNear(await numbers(page), planar(30, -40));
  await page.getByLabel("a2", { exact: true }).fill("2/5 + 0.1");
  await page.waitForFunction(() => location.hash.includes("2%2F5%20%2B%200.1") || location.hash.includes("%2B"));
  await page.reload();
  await page.locator(".own-figures").waitFor();
  assert.equal(await page.getByLabel("a2", { exact: true }).inputValue(), "2/5 + 0.1");
  const [first] = await numbers(page);
  assert.ok(Math.abs(value(first) - (-0.5 * Math.sin(Math.PI / 6) - 0.5 * Math.sin(-Math.PI / 18))) < 1e-5);
  assert.deepEqual(wrong, []);
  await context.close();
});

test("the formulas of J and det J follow the table, or the page says why there are none", async () => {
  const { page, wrong, context } = await openedAnew(there, `${TABLE}&angles=degrees`);
  const formulas = () => page.locator(".own-formulas math").evaluateAll((all) => all.map((each) => each.textContent));
  const until = (text) =>
    page.waitForFunction(
      (text) =>
        document
          .querySelector(".own-formulas")
          ?.textContent.replace(/[\s\u2061\u2062]/g, "")
          .includes(text),
      text,
    );
  await until("detJ=a1a2s2");
  await until("J=[−a1s1−a2s12−a2s12a1c1+a2c12a2c12]");
  const before = await formulas();
  const angle = page.locator('.arm-joints input[type="number"]').first();
  await angle.fill("75");
  await angle.press("Tab");
  await page.waitForFunction(() => location.hash.includes("at=75_"));
  assert.deepEqual(await formulas(), before); // they are the same in every pose
  await page.getByLabel("a2", { exact: true }).fill("0.25");
  await until("a2=0.25m");
  await page.getByLabel("α1", { exact: true }).fill("45");
  await page.getByText("Formulas appear if all α").waitFor();
  assert.deepEqual(await formulas(), []);
  await page.getByLabel("α1", { exact: true }).fill("90");
  await until("J=[");
  for (let joint = 3; joint <= 5; joint += 1) await page.getByRole("button", { name: "Add a revolute joint" }).click();
  await page.getByText("Formulas appear for arms of up to 4 joints").waitFor();
  assert.deepEqual(wrong, []);
  await context.close();
});

test("if radians are chosen, the table is converted, and sliders and map show radians", async () => {
  const { page, wrong, context } = await openedAnew(there, "own.html#robot=scara");
  const angle = page.locator('.arm-joints input[type="number"]').first();
  await angle.fill("90");
  await angle.press("Tab");
  await page.waitForFunction(() => location.hash.includes("at=90_"));
  const before = await numbers(page);
  assert.equal(await page.getByLabel("α2", { exact: true }).inputValue(), "180");
  await page.getByRole("radio", { name: "radians" }).check();
  assert.equal(await page.getByLabel("α2", { exact: true }).inputValue(), "pi");
  assert.equal(await angle.inputValue(), "1.571");
  assert.ok((await page.locator(".arm-map text").allTextContents()).includes("π/2"));
  const spoken = page.locator('.arm > [aria-live="polite"]');
  await spoken.getByText("θ1 1.571 radians").waitFor({ state: "attached" });
  assert.doesNotMatch(await spoken.textContent(), /degrees/);
  assertNear(await numbers(page), before.map(value));
  assert.deepEqual(wrong, []);
  await context.close();
});

test("the pose of a link stays while a number is typed, even if the arm was not moved yet", async () => {
  const { page, context } = await openedAnew(there, TABLE);
  await page.locator(".own-figures").waitFor();
  await page.getByLabel("a2", { exact: true }).press("ControlOrMeta+a");
  await page.keyboard.type("2/5 + 0.1");
  await page.waitForFunction(() => location.hash.includes("0.1"));
  assert.match(await page.evaluate(() => location.hash), /at=30_90$/);
  const [first] = await numbers(page);
  assert.ok(Math.abs(value(first) - (-0.5 * Math.sin(Math.PI / 6) - 0.5 * Math.sin((2 * Math.PI) / 3))) < 1e-5);
  await context.close();
});

test("while a cell is invalid, the arm stays, and the error is shown with its cell", async () => {
  const { page } = await opened(there, `${TABLE}&x=1`);
  await page.locator(".own-figures").waitFor();
  const cell = page.getByLabel("α1", { exact: true });
  await cell.fill("90");
  await page
    .locator("#wrong-rows-0-alpha")
    .getByText(/angles are in radians here/)
    .waitFor();
  assert.equal(await cell.getAttribute("aria-invalid"), "true");
  assertNear(await numbers(page), planar(30, 90));
  await page.getByRole("radio", { name: "degrees" }).check();
  await page.locator(".own-wrong").waitFor({ state: "detached" });
  await page.locator(".own-figures tbody tr").nth(2).waitFor(); // it leaves the plane
});

test("a robot is chosen by keys, a joint added and removed, and qdot solve accepts the file", async () => {
  const { page, wrong } = await opened(there, "own.html");
  const begin = page.getByLabel("Start with");
  await begin.focus();
  await page.keyboard.press("ArrowDown");
  await page.waitForFunction(() => location.hash.startsWith("#robot=scara"));
  await begin.selectOption("panda");
  await page.waitForFunction(() => location.hash.startsWith("#robot=panda"));
  await page.getByText("Numbers from: Franka Emika").waitFor();
  assert.equal(await page.locator(".own-row").count(), 7);
  assert.equal(await page.locator(".own-figures thead th").count(), 8);
  await page.getByRole("button", { name: "Add a prismatic joint" }).focus();
  await page.keyboard.press("Enter");
  await page.locator(".own-row").nth(7).waitFor();
  await page.getByRole("button", { name: "Remove joint 1" }).focus();
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelectorAll(".own-row").length === 7);
  assert.equal(await page.getByLabel("d7", { exact: true }).inputValue(), "q7");
  const [saved] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("button", { name: "Save as arm.toml" }).click(),
  ]);
  const folder = mkdtempSync(join(tmpdir(), "qdot-own-"));
  await saved.saveAs(join(folder, "arm.toml"));
  const text = readFileSync(join(folder, "arm.toml"), "utf8");
  rmSync(folder, { recursive: true });
  assert.match(text, /^name = "Franka Emika Panda"\nconvention = "modified-dh"\n/);
  assert.equal(text.match(/\[\[joint\]\]/g).length, 7);
  assert.deepEqual(wrong, []);
});

for (const [robot, width] of [
  ["ur5", 1440],
  ["panda", 1440],
  ["ur5", 2560],
]) {
  test(`all numbers of ${robot} are completely visible at ${width} pixels`, async () => {
    const joints = robot === "panda" ? 7 : 6;
    const at = Array.from({ length: joints }, () => "-142.7").join("_");
    const { page } = await opened(there, `own.html#robot=${robot}&at=${at}`, { viewport: { width, height: 900 } });
    await page.locator(".own-figures").waitFor();
    await page.locator(".arm-jacobian").waitFor();
    const found = await page.evaluate(() => {
      const wider = (selector) =>
        [...document.querySelectorAll(selector)].map((one) => one.scrollWidth - one.clientWidth);
      // How far the numbers of column 1 are from the bracket on the left of their cells.
      const off = [...document.querySelectorAll(".arm-jacobian td:nth-child(2)")].map((cell) => {
        const text = document.createRange();
        text.selectNodeContents(cell);
        return text.getBoundingClientRect().left - cell.getBoundingClientRect().left;
      });
      return {
        boxes: wider('.arm-joints input[type="number"]'),
        tables: wider(".own-figures table, .arm-jacobian"),
        off: Math.min(...off),
      };
    });
    assert.deepEqual(found.boxes, Array(joints).fill(0));
    assert.deepEqual(found.tables, [0, 0]);
    assert.ok(found.off >= 3, `${found.off} pixels from the bracket`);
  });
}

test("on a phone, keys scroll the J of six joints", async () => {
  const { page } = await opened(there, "own.html#robot=ur5", PHONE);
  const table = page.locator(".own-figures table");
  await table.focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => document.querySelector(".own-figures table").scrollLeft > 0);
  await assertAccessible(page);
});

test("all columns of the J of ten joints are visible; units are accepted, and an unlikely angle is pointed out", async () => {
  const rows = Array.from({ length: 10 }, (_, i) => `R_q${i + 1}_0_0.4_${90 * (i % 2)}`).join("~");
  const { page, wrong } = await opened(
    there,
    `own.html#dh=${rows}&angles=degrees&at=${Array(10).fill(-142.7).join("_")}`,
    { viewport: { width: 1440, height: 900 } },
  );
  const cut = () =>
    page.locator(".arm-jacobian").evaluate((table) => {
      const [last] = [...table.querySelectorAll("tbody td:last-child")];
      return last.getBoundingClientRect().right - table.parentElement.getBoundingClientRect().right;
    });
  await page.locator(".arm-jacobian td").first().waitFor();
  assert.ok((await cut()) <= 1, `${await cut()} pixels of J are cut off`);
  await page.getByLabel("α1", { exact: true }).fill("90°");
  await page.getByLabel("a1", { exact: true }).fill("400mm");
  await page.getByLabel("d1", { exact: true }).fill("0,1 m");
  assert.equal(await page.locator(".own-wrong").count(), 0);
  await page.getByLabel("α2", { exact: true }).fill("1.5708");
  await page.getByText("Is 1.5708 in radians? If so, enter 90.").waitFor();
  assert.deepEqual(wrong, []);
});

test("an invalid link is reported, and so is a link to an unknown robot", async () => {
  for (const [link, said] of [
    ["#dh=R_1", /contains no readable table/],
    ["#dh=R_%E0%A4%A_0_0_0", /contains no readable table/],
    ["#robot=%3Cimg%20src%3Dx%3E", /robot that isn't in the list/],
  ]) {
    const { page, wrong, context } = await openedAnew(there, `own.html${link}`);
    await page.locator(".own-alert").getByText(said).waitFor();
    await page.locator(".arm-box").waitFor();
    assert.deepEqual(wrong, []);
    await context.close();
  }
});

test("the content of a link is only text", async () => {
  const { page, wrong } = await opened(
    there,
    "own.html#dh=R_%3Cscript%3E_0_constructor_0~R_q2_0_%5B1%2C2%5D_0&name=%3Cimg%20src%3Dx%20onerror%3Dx%3E",
  );
  await page.locator(".own-alert").waitFor();
  assert.equal(await page.getByLabel("θ1", { exact: true }).inputValue(), "<script>");
  assert.equal(await page.locator(".own img, .own script").count(), 0);
  assert.deepEqual(wrong, []);
});

test("on a German phone the page is German, accepts decimal commas, and is no wider than the screen", async () => {
  const { page, wrong } = await opened(there, "own.html#robot=ur5e", { ...PHONE, locale: "de-DE" });
  await page.getByRole("heading", { name: "Dein eigener Arm", level: 2 }).waitFor();
  await page.locator(".own-figures").waitFor();
  await page.getByLabel("a2", { exact: true }).fill("-0,5");
  await drawn(page);
  assert.equal(await page.locator(".own-wrong").count(), 0);
  await page.getByText("Punkt, Basis, Aufgabe").click();
  const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
  assert.deepEqual(wrong, []);
});

test("numbers beside the table change in the same frame as the drawing", async () => {
  const { page } = await opened(there, "own.html#robot=ur5");
  await page.locator(".own-figures").waitFor();
  await page.locator(".arm-grip").nth(2).waitFor({ state: "attached" });
  const [before, after, moved] = await page.evaluate(async () => {
    const shown = () => document.querySelector(".own-figures tbody").textContent;
    const line = () => document.querySelectorAll(".arm-grip")[2].getAttribute("points");
    const [first, drawn] = [shown(), line()];
    const key = { key: "ArrowRight", shiftKey: true, bubbles: true, cancelable: true };
    document.querySelector(".arm-box").dispatchEvent(new KeyboardEvent("keydown", key));
    for (let i = 0; i < 20; i += 1) await null; // tasks before the next frame
    return [first, shown(), drawn !== line()];
  });
  assert.ok(moved, "the arm is drawn in its new pose");
  assert.notEqual(after, before);
});

test("an invalid number for a joint, or one in another turn, is replaced by the joint's value", async () => {
  const { page } = await opened(there, "own.html#robot=ur5");
  const field = page.locator('.arm-joints input[type="number"]').nth(1);
  await field.fill("30");
  await field.press("Enter");
  assert.equal(await field.inputValue(), "30");
  for (const typed of ["390", ""]) {
    await field.fill(typed);
    await field.press("Enter");
    await drawn(page);
    assert.equal(await field.inputValue(), "30", `after “${typed}”`);
  }
});
