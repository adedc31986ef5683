// A page of the site in Chromium, with all that goes wrong in it, for the tests of every file here.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before } from "node:test";

import { builtSite, CHROMIUM, launched, served } from "../tools/browser.mjs";

const require = createRequire(import.meta.url);
export const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
export const WIDE = { viewport: { width: 1280, height: 900 } };
export const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
/** One page of each kind. */
export const KINDS = [
  "index.html",
  "practice.html?arm=planar-2r&question=jacobian",
  "practice.html?arm=planar-2r&set=a&sheet=2&key=1",
  "accessibility.html",
  "examples/index.html",
  "examples/6-2.html",
  "examples/6-3.html",
  "examples/errata.html",
  "arms.html",
  "docs/index.html",
  "docs/students.html",
  "docs/commands.html",
];
/** Milliseconds between two looks at whether a page still asks for something. */
const LOOK = 60;

if (!CHROMIUM && !process.env.CI) {
  console.error("no Chromium: the site's pages are not tried in a browser (apt-get install chromium)");
  process.exit(0);
}

/** The site, its server and the browser, there before a file's tests and gone after them. */
export function inChromium() {
  const there = {};
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
 * A page that has come to rest, with what its console says of errors, refusals by its policy among them, and what it
 * asks other hosts for. In a `shared` context what an earlier page loaded is there already.
 */
export async function opened({ browser, server }, path, options = WIDE, shared = null) {
  const context = shared ?? (await browser.newContext({ serviceWorkers: "block", ...WIDE, ...options }));
  const page = await context.newPage();
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("console", (said) => said.type() === "error" && wrong.push(said.text()));
  page.on("request", (request) => {
    const { protocol, origin } = new URL(request.url());
    if (protocol.startsWith("http") && origin !== server.root) wrong.push(`asked for ${request.url()}`);
  });
  await page.addInitScript(() => {
    window.refused = [];
    document.addEventListener("securitypolicyviolation", (event) =>
      window.refused.push(`${event.violatedDirective}: ${event.blockedURI}`),
    );
  });
  const settled = watched(page);
  await page.goto(`${server.root}/${path}`);
  await settled();
  return { page, context, wrong, settled };
}

/**
 * Waits until a page asks for nothing any more and has nothing to do, at two looks one after the other: what Playwright's
 * "networkidle" takes half a second for.
 */
function watched(page) {
  let asked = 0;
  let open = 0;
  page.on("request", () => ((asked += 1), (open += 1)));
  page.on("requestfinished", () => (open -= 1));
  page.on("requestfailed", () => (open -= 1));
  return async () => {
    for (let quiet = 0, before = -1; quiet < 2;) {
      await page.waitForTimeout(LOOK);
      await page.evaluate(() => new Promise((done) => requestIdleCallback(done)));
      quiet = open === 0 && asked === before ? quiet + 1 : 0;
      before = asked;
    }
  };
}

/** Brings the arm of a page, which comes when it is near to the screen, with its map; nothing on a page without one. */
export async function armOf(page) {
  const arm = page.locator("#arm, [data-arm], [data-hero]").first();
  if ((await arm.count()) === 0) return;
  await arm.scrollIntoViewIfNeeded();
  await page.mouse.move(1, 1); // that of the first page comes once somebody is there
  await page.locator(".arm-box").waitFor();
  if (await page.locator("[data-hero]").count()) await page.locator(".arm-joints").waitFor();
  else await page.locator(".arm-zero").first().waitFor({ state: "attached" });
}
