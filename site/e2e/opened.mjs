// Open a page of the site in Chromium, and record its errors; all tests in this folder use it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before } from "node:test";

import { builtSite, CHROMIUM, isPageError, launched, PATIENCE, served } from "../tools/browser.mjs";

const require = createRequire(import.meta.url);
const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
export const WIDE = { viewport: { width: 1280, height: 900 } };
export const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
/** The date that every page sees, whatever the real date is. */
const NOON = Date.parse("2026-11-25T12:00:00Z");
/** Milliseconds between two checks whether a page is still loading something. */
const LOOK = 30;

/** The site, its server and the browser; they start before a file's tests and stop after them. */
export function inChromium() {
  const there = { tabs: new Map() };
  before(async () => {
    assert.ok(CHROMIUM, "no Chromium: apt-get install chromium");
    there.site = builtSite();
    there.server = await served(there.site.folder);
    there.browser = await launched();
  });
  after(async () => {
    await there.browser?.close();
    there.server?.close();
    there.site?.remove();
  });
  return there;
}

/**
 * Open a page, and wait until it is idle. Return it with the errors in its console, including violations of its policy,
 * and its requests to other hosts. A file's tests with the same options share a tab: scripts are cached, and storage is
 * cleared.
 */
export async function opened(there, path, options = WIDE) {
  const name = JSON.stringify({ ...WIDE, ...options });
  const tab = there.tabs.get(name) ?? (await tabIn(await contextFor(there, options), there.server.root));
  if (there.tabs.has(name)) {
    await tab.page.evaluate(() => localStorage.clear());
    await tab.page.setViewportSize({ ...WIDE, ...options }.viewport);
  }
  there.tabs.set(name, tab);
  return tab.at(path);
}

/** Do the same in a browser with empty storage, and return its context, for tests that count or block requests. */
export async function openedAnew(there, path, options = WIDE) {
  const { context, at } = await emptyTab(there, options);
  return { ...(await at(path)), context };
}

/** Return a tab of such a browser, and how to open a page in it, for tests that prepare something first. */
export async function emptyTab(there, options = WIDE) {
  const context = await contextFor(there, options);
  return { context, ...(await tabIn(context, there.server.root)) };
}

/**
 * Open a browser with empty storage. Its language, time zone, date and random numbers are the same on every machine;
 * `noon` sets a different date.
 */
async function contextFor({ browser }, { noon = NOON, ...options }) {
  const here = { locale: "en-GB", timezoneId: "UTC", serviceWorkers: "block" };
  const context = await browser.newContext({ ...here, ...WIDE, ...options });
  context.setDefaultTimeout(PATIENCE);
  await context.addInitScript(fixChance);
  await context.addInitScript(fixDay, noon);
  return context;
}

/** Set the clock of a page, which then continues to run. This runs in the page. */
function fixDay(noon) {
  const ahead = noon - Date.now();
  globalThis.Date = class extends Date {
    constructor(...given) {
      super(...(given.length > 0 ? given : [Date.now()]));
    }
    static now() {
      return super.now() + ahead;
    }
  };
}

/** Make a page use the same random numbers each time it is opened. This runs in the page. */
function fixChance() {
  let last = 2 ** 30;
  Math.random = () => (last = (last * 48271) % (2 ** 31 - 1)) / (2 ** 31 - 1);
  crypto.getRandomValues = (numbers) => numbers.fill(Math.random() * 2 ** 32);
}

/** Return a new tab, and how to open a page in it; errors are reported for each page separately. */
async function tabIn(context, root) {
  const page = await context.newPage();
  let wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("console", (said) => isPageError(said) && wrong.push(said.text()));
  page.on("request", (request) => {
    const { protocol, origin } = new URL(request.url());
    if (protocol.startsWith("http") && origin !== root) wrong.push(`asked for ${request.url()}`);
  });
  await page.addInitScript(() => {
    window.refused = [];
    document.addEventListener("securitypolicyviolation", (event) =>
      window.refused.push(`${event.violatedDirective}: ${event.blockedURI}`),
    );
  });
  const settled = watched(page);
  const at = async (path) => {
    wrong = [];
    await page.goto(`${root}/${path}`);
    await settled();
    return { page, wrong };
  };
  return { page, at };
}

/**
 * Wait until two successive checks find a page idle, without requests. Playwright's "networkidle" takes half a second for
 * this.
 */
function watched(page) {
  const open = new Set();
  let asked = 0;
  page.on("request", (request) => (open.add(request), (asked += 1)));
  page.on("requestfinished", (request) => open.delete(request));
  page.on("requestfailed", (request) => open.delete(request));
  return async () => {
    for (let quiet = 0, before = -1; quiet < 2;) {
      await page.waitForTimeout(LOOK);
      await page.evaluate(() => new Promise((done) => requestIdleCallback(done, { timeout: 200 })));
      quiet = open.size === 0 && asked === before ? quiet + 1 : 0;
      before = asked;
    }
  };
}

/** Wait for a few frames, so that animations have moved. */
export const drawn = (page) =>
  page.evaluate(async () => {
    for (let i = 0; i < 6; i += 1) await new Promise((done) => requestAnimationFrame(done));
  });

/** Load the arm of a page, which loads when it is near the screen, and its map; do nothing if there is no arm. */
export async function armOf(page) {
  const arm = page.locator("#arm, [data-arm], [data-hero], .stage").first();
  if ((await arm.count()) === 0) return;
  await arm.scrollIntoViewIfNeeded();
  await page.mouse.move(1, 1); // the arm of the first page loads after the first interaction
  await page.locator(".arm-box").waitFor();
  if (await page.locator("[data-hero]").count()) await page.locator(".arm-factors").waitFor();
  else {
    const map = page.getByRole("button", { name: /^(Map|Karte)$/ });
    if ((await map.count()) === 0) return; // the first lesson has no map
    if ((await map.getAttribute("aria-expanded")) === "false") await map.evaluate((button) => button.click()); // the focus doesn't change
    // if the map would reveal the answer, it says so
    await page.locator(".arm-zero, .arm-zero-spot, .arm-pane .arm-concealed").first().waitFor({ state: "attached" });
  }
}

/** Assert that the axe checker finds no errors in a page, and that nothing is wider than the screen. */
export async function assertAccessible(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() =>
    window.axe.run({
      runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],
      // axe ignores MathML, so it takes headers with formulas for empty ones
      rules: { "empty-table-header": { enabled: false }, "label-content-name-mismatch": { enabled: true } },
      resultTypes: ["violations"], // without details on passed rules, axe takes half the time
    }),
  );
  assert.deepEqual(
    violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`),
    [],
  );
  const wider = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
}
