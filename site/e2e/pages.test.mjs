// Every page of the built site follows its policy, sends no requests to other hosts, has working links, and is small.
import assert from "node:assert/strict";
import { existsSync, readdirSync, readFileSync, statSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";

import { assertAccessible, drawn, inChromium, opened, openedAnew, WIDE } from "./opened.mjs";

/** Maximum number of bytes, with gzip, that a page may load before the bank. */
const MOST = 300_000;

const there = inChromium();

/** Return the paths of all pages in the site. */
function pages() {
  const found = readdirSync(there.site.folder, { recursive: true, encoding: "utf8" });
  return found
    .filter((name) => name.endsWith(".html"))
    .map((name) => name.replaceAll("\\", "/"))
    .sort();
}

/** The results for every page, by its path; each page is opened once. */
const seen = new Map();

/** Open a page, and record what the tests of all pages need. */
async function visit(path) {
  const { page, wrong } = await opened(there, path);
  const told = await page.evaluate(() => ({
    policy: document.querySelector('meta[http-equiv="Content-Security-Policy"]').getAttribute("content"),
    refused: window.refused,
    headings: document.querySelectorAll("h1").length,
    anchors: [...document.querySelectorAll("[id]")].map(({ id }) => id),
    links: [...document.querySelectorAll("a[href]")].map((link) => link.getAttribute("href")),
  }));
  seen.set(path, { ...told, wrong });
}

async function visited() {
  for (const path of pages()) if (!seen.has(path)) await visit(path);
  return seen;
}

test("every page has a strict content policy, which it keeps, and loads nothing from other hosts", async () => {
  const all = await visited();
  assert.ok(all.size > 20, `${all.size} pages`);
  for (const [path, { policy, refused, headings, wrong }] of all) {
    assert.match(policy, /default-src 'none'; script-src 'self';/, path);
    assert.match(policy, /style-src-elem 'self';/, path);
    assert.doesNotMatch(policy, /unsafe-eval|script-src[^;]*unsafe|https?:|\*/, path);
    assert.deepEqual([...wrong, ...refused], [], path);
    assert.equal(headings, 1, path);
  }
});

test("every link of the site leads to a page, and to a place in it", async () => {
  const known = await visited();
  const lost = [];
  for (const [path, { links }] of known) {
    for (const link of links) {
      const address = new URL(link, `http://site/${path}`);
      if (address.hostname !== "site") continue;
      const target = decodeURIComponent(address.pathname.slice(1)) || "index.html";
      const anchor = decodeURIComponent(address.hash.slice(1));
      if (!existsSync(join(there.site.folder, target))) lost.push(`${path}: ${link}`);
      else if (anchor && !known.get(target)?.anchors.includes(anchor)) lost.push(`${path}: ${link} (no such place)`);
    }
  }
  assert.deepEqual(lost, []);
});

test("a missing address shows the site's own page at any depth, with a way back", async () => {
  for (const path of ["nothing.html", "examples/nothing.html", "a/b/c/nothing"]) {
    const { page, context } = await openedAnew(there, path, { ...WIDE, locale: "de-DE" });
    await page.getByRole("heading", { name: "Seite nicht gefunden" }).waitFor();
    assert.notEqual(await page.evaluate(() => getComputedStyle(document.querySelector(".top")).display), "block");
    await page.locator("main a").first().click();
    await page.waitForURL(`${there.server.root}/index.html`);
    await page.goto(`${there.server.root}/${path}`);
    await page.locator("header nav a").first().click();
    await page.locator(".way").waitFor();
    await context.close();
  }
});

test("screenshots are dark on a dark page", async () => {
  const { page } = await opened(there, "docs/moodle.html", { colorScheme: "dark" });
  const filters = await page
    .locator('main img[src$=".png"]')
    .evaluateAll((images) => images.map((image) => getComputedStyle(image).filter));
  assert.ok(filters.length > 5 && filters.every((filter) => filter.startsWith("invert")), `${filters}`);
});

test("every page can be reached from the first one", () => {
  const seen = new Set(["index.html"]);
  for (const path of seen) {
    const text = readFileSync(join(there.site.folder, path), "utf8");
    for (const [, link] of text.matchAll(/<a [^>]*href="([^"#?:]+\.html)/g)) {
      seen.add(join(dirname(path), link).replaceAll("\\", "/"));
    }
  }
  assert.deepEqual(
    pages().filter((path) => !seen.has(path) && path !== "404.html"),
    [],
  );
});

test("all files that pages refer to exist", () => {
  const missing = new Set();
  for (const path of pages()) {
    const text = readFileSync(join(there.site.folder, path), "utf8");
    if (path === "404.html") continue; // it looks for its files in the folders above
    for (const [, link] of text.matchAll(/<(?:link|script|img|source)\b[^>]*? (?:href|src)="([^"#?:]+)/g)) {
      const file = join(there.site.folder, dirname(path), link);
      if (!existsSync(file)) {
        missing.add(`${path}: ${link}`);
      }
    }
  }
  assert.deepEqual([...missing], []);
});

test("the practice page opens with less than 300 kB before the bank", async () => {
  for (const path of ["index.html", "practice.html", "examples/6-1.html"]) {
    there.server.sent.clear();
    const { context } = await openedAnew(there, path);
    const before = [...there.server.sent].filter(([name]) => !name.startsWith("/bank/"));
    const bytes = before.reduce((sum, [, size]) => sum + size, 0);
    assert.ok(before.length >= 3, `${path}: ${before.length} files`);
    assert.ok(bytes < MOST, `${path}: ${bytes} bytes: ${before.map(([name, size]) => `${name} ${size}`).join(", ")}`);
    await context.close();
  }
});

test("practice with a planar arm loads less than 0.6 MB, with the arm that moves and all that the page unpacks", async () => {
  there.server.sent.clear();
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=jacobian", WIDE);
  await page.locator("#arm .arm-box").waitFor();
  await page.waitForLoadState("networkidle");
  const loaded = [...there.server.sent].map(([path]) => [path, statSync(join(there.site.folder, path)).size]);
  const bytes = loaded.reduce((sum, [, size]) => sum + size, 0);
  assert.ok(loaded.some(([path]) => path.startsWith("/bank/planar-2r/")));
  assert.ok(bytes < 600_000, `${bytes} bytes: ${loaded.map((file) => file.join(" ")).join(", ")}`);
  await context.close();
});

test("pages that were read work offline, with the arm beside an example", async () => {
  const { page, context } = await openedAnew(there, "index.html", { ...WIDE, serviceWorkers: "allow" });
  await page.evaluate(() => navigator.serviceWorker.ready);
  await context.setOffline(true);
  for (const path of ["examples/6-1.html", "docs/students.html", "arms.html"]) {
    await page.goto(`${there.server.root}/${path}`);
    await page.locator("h1").waitFor();
  }
  await page.waitForFunction(() => document.querySelector(".card img").naturalWidth > 0); // of the gallery
  await page.goto(`${there.server.root}/examples/6-3.html`);
  await page.locator('.live input[type="range"]').first().waitFor();
  await context.close();
});

/** A pinned value of a term follows the arm, and disappears with Escape. */
async function followsAndGoes(page, number) {
  const before = await number.innerText();
  await page.locator('.live input[type="range"]').nth(1).focus();
  await page.keyboard.press("Shift+ArrowRight");
  await page.waitForFunction((old) => document.querySelector(".arm-term").innerText !== old, before);
  await page.keyboard.press("Escape");
  await number.waitFor({ state: "detached" });
}

test("pointing at a term shows its value and highlights its link; pointing at a link highlights its symbols", async () => {
  const { page, wrong } = await opened(there, "examples/6-1.html");
  await page.locator(".live .arm-box").waitFor();
  const line = page.locator("main math", { hasText: /^\W*x\s*y\W*=\W*a1c1\+a2c12/ }).first();
  const number = page.locator(".arm-term");
  const told = async (index) => {
    await line.locator("msub").nth(index).hover();
    await page.locator(".term-on").first().waitFor();
    return Number((await number.innerText()).replace("here: ", "").replace("−", "-"));
  };
  const first = await told(0);
  await page.locator(".arm-grip.arm-j1.arm-lit").waitFor({ state: "attached" });
  const second = await told(2);
  await page.locator(".arm-grip.arm-j2.arm-lit").waitFor({ state: "attached" });
  const [, x] = /P = \((−?[\d.]+)/.exec(await page.locator(".live .arm-figures").innerText());
  assert.ok(Math.abs(first + second - Number(x.replace("−", "-"))) < 2e-3, `${first} + ${second} = ${x}`);
  await line.locator("msub").nth(2).click();
  await page.mouse.move(5, 5);
  await followsAndGoes(page, number);
  await page.evaluate(() => scrollTo(0, 0));
  await page.locator(".live .arm-box .arm-grip").nth(1).hover();
  await line.locator(".term-lit").first().waitFor({ state: "attached" });
  assert.deepEqual(await line.locator(".term-lit").evaluateAll((all) => all.map((one) => one.textContent)), [
    "a2",
    "c12",
    "a2",
    "s12",
  ]);
  assert.deepEqual(wrong, []);
});

test("keys reach the terms of formulas: one tab stop per formula, arrows between terms, each announced with its number", async () => {
  const { page, wrong } = await opened(there, "examples/6-1.html");
  await page.locator(".live .arm-box").waitFor();
  const line = page.locator("main math", { hasText: /^\W*x\s*y\W*=\W*a1c1\+a2c12/ }).first();
  await page.waitForFunction(() => document.querySelectorAll("main math[tabindex]").length > 5);
  assert.equal(await line.locator("[tabindex]").count(), 0, "one stop a formula");
  await line.evaluate((math) => math.focus());
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press("Tab");
  assert.ok(await line.evaluate((math) => math === document.activeElement));
  assert.ok(await line.evaluate((math) => parseFloat(getComputedStyle(math).outlineWidth) >= 2), "a ring");
  const said = page.locator('.live [role="status"]').last();
  const lit = () => page.locator(".term-on").evaluateAll((all) => all.map((one) => one.textContent).join(""));
  const press = async (key) => {
    await page.keyboard.press(key);
    await drawn(page); // the highlight appears in the next frame
  };
  await drawn(page);
  for (let i = 0; i < 10 && (await lit()) !== "a1c1"; i += 1) await press("ArrowRight");
  assert.equal(await lit(), "a1c1");
  await page.locator(".arm-grip.arm-j1.arm-lit").waitFor({ state: "attached" });
  assert.match(await said.textContent(), /^a1 c1, here: −?\d/);
  await press("ArrowRight");
  assert.equal(await lit(), "a2c12");
  await page.locator(".arm-grip.arm-j2.arm-lit").waitFor({ state: "attached" });
  assert.match(await said.textContent(), /^a2 c12, here: −?\d/);
  await press("ArrowDown");
  assert.match(await said.textContent(), /^a2, here: \d/);
  await press("ArrowUp");
  await press("Enter");
  const number = page.locator(".arm-term");
  await followsAndGoes(page, number);
  assert.equal(await said.textContent(), "");
  await assertAccessible(page);
  assert.deepEqual(wrong, []);
});

test("a term with a rate has a value if a lesson's sliders set the rates", async () => {
  const { page } = await opened(there, "learn.html?lesson=rates");
  await page.locator(".arm-box").waitFor();
  await page.getByLabel("Rate of joint angle θ1").fill("0.5");
  await page.evaluate(() => {
    const put = document.createElement("p");
    put.innerHTML =
      "<math><msub><mi>a</mi><mn>1</mn></msub><msub><mover><mi>θ</mi><mo>˙</mo></mover><mn>1</mn></msub></math>";
    document.querySelector(".lesson").append(put);
  });
  const formula = page.locator(".lesson math").last();
  await formula.locator("mover").hover();
  assert.match(await page.locator(".arm-term").innerText(), /^here: −?0\.\d+$/);
});

test("the gallery leads to practice with the chosen arm", async () => {
  const { page } = await opened(there, "arms.html");
  await page.locator("#planar-2r .do a").click();
  const chosen = page.locator(".settings select").first();
  await chosen.waitFor({ state: "attached" });
  assert.equal(await chosen.inputValue(), "planar-2r");
});
