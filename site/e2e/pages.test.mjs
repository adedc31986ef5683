// Every page of the built site: it keeps to its policy, its links lead somewhere, it is small, reachable by keyboard and
// accessible. What is done on the practice page is tried in site.test.mjs.
import assert from "node:assert/strict";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";

import { builtSite, CHROMIUM, launched, served } from "../tools/browser.mjs";

const require = createRequire(import.meta.url);
const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
if (!CHROMIUM && !process.env.CI) {
  console.error("no Chromium: the site's pages are not tried in a browser (apt-get install chromium)");
  process.exit(0);
}
const WIDE = { viewport: { width: 1280, height: 900 } };
const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
/** What may be sent before the bank, gzip bodies, in bytes. */
const MOST = 300_000;
/** One page of each kind. */
const KINDS = [
  "index.html",
  "practice.html?arm=planar-2r&question=jacobian",
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

let site, server, browser;

before(async () => {
  assert.ok(CHROMIUM, "no Chromium: apt-get install chromium");
  site = builtSite();
  server = await served(site.folder);
  browser = await launched();
});

after(async () => {
  await browser?.close();
  server?.close();
  site?.remove();
});

/** All pages there are, as paths in the site. */
function pages() {
  const found = readdirSync(site.folder, { recursive: true, encoding: "utf8" });
  return found
    .filter((name) => name.endsWith(".html"))
    .map((name) => name.replaceAll("\\", "/"))
    .sort();
}

/** A page with what its console says of errors, refusals by its policy among them, and what it asks other hosts for. */
async function opened(path, options = WIDE) {
  const context = await browser.newContext({ serviceWorkers: "block", ...options });
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
  await page.goto(`${server.root}/${path}`);
  await page.waitForLoadState("networkidle");
  return { page, context, wrong };
}

test("every page has a strict policy, and nothing in it is refused", async () => {
  const all = pages();
  assert.ok(all.length > 20, `${all.length} pages`);
  for (const path of all) {
    const { page, context, wrong } = await opened(path);
    const policy = await page.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute("content");
    assert.match(policy, /default-src 'none'; script-src 'self';/, path);
    assert.doesNotMatch(policy, /unsafe-eval|script-src[^;]*unsafe|https?:|\*/, path);
    assert.deepEqual([...wrong, ...(await page.evaluate(() => window.refused))], [], path);
    assert.equal(await page.locator("h1").count(), 1, path);
    await context.close();
  }
});

test("every link of the site leads to a page, and to a place in it", async () => {
  const { page, context } = await opened("index.html");
  const known = new Map();
  for (const path of pages()) {
    await page.goto(`${server.root}/${path}`);
    known.set(
      path,
      await page.evaluate(() => ({
        anchors: [...document.querySelectorAll("[id]")].map(({ id }) => id),
        links: [...document.querySelectorAll("a[href]")].map((link) => link.getAttribute("href")),
      })),
    );
  }
  await context.close();
  const lost = [];
  for (const [path, { links }] of known) {
    for (const link of links) {
      const address = new URL(link, `http://site/${path}`);
      if (address.hostname !== "site") continue;
      const target = decodeURIComponent(address.pathname.slice(1)) || "index.html";
      const anchor = decodeURIComponent(address.hash.slice(1));
      if (!existsSync(join(site.folder, target))) lost.push(`${path}: ${link}`);
      else if (anchor && !known.get(target)?.anchors.includes(anchor))
        lost.push(`${path}: ${link} (no such place)`);
    }
  }
  assert.deepEqual(lost, []);
});

test("every page can be reached from the first one", () => {
  const seen = new Set(["index.html"]);
  for (const path of seen) {
    const text = readFileSync(join(site.folder, path), "utf8");
    for (const [, link] of text.matchAll(/<a [^>]*href="([^"#?:]+\.html)/g)) {
      seen.add(join(dirname(path), link).replaceAll("\\", "/"));
    }
  }
  assert.deepEqual(
    pages().filter((path) => !seen.has(path)),
    [],
  );
});

test("the practice page opens with less than 300 kB before the bank", async () => {
  for (const path of ["index.html", "practice.html", "examples/6-1.html"]) {
    server.sent.clear();
    const { context } = await opened(path);
    const before = [...server.sent].filter(([name]) => !name.startsWith("/bank/"));
    const bytes = before.reduce((sum, [, size]) => sum + size, 0);
    assert.ok(before.length >= 3, `${path}: ${before.length} files`);
    assert.ok(
      bytes < MOST,
      `${path}: ${bytes} bytes: ${before.map(([name, size]) => `${name} ${size}`).join(", ")}`,
    );
    await context.close();
  }
});

for (const path of KINDS) {
  for (const [name, options] of [
    ["wide and light", { ...WIDE, colorScheme: "light" }],
    ["on a phone in the dark", { ...PHONE, colorScheme: "dark" }],
  ]) {
    test(`${path} is accessible ${name}`, async () => {
      const { page, context, wrong } = await opened(path, options);
      const arm = page.locator("#arm, [data-arm], [data-hero]").first();
      if (await arm.count()) {
        await arm.scrollIntoViewIfNeeded(); // it comes when it is near to the screen
        await page.locator(".arm-box").waitFor();
      }
      await page.evaluate(AXE);
      const { violations } = await page.evaluate(() =>
        window.axe.run({
          runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],
          // axe takes MathML for nothing: headers that hold a formula seem empty to it
          rules: {
            "empty-table-header": { enabled: false },
            "label-content-name-mismatch": { enabled: true },
          },
        }),
      );
      assert.deepEqual(
        violations.map(
          ({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`,
        ),
        [],
      );
      const wider = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
      assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
      assert.deepEqual(wrong, []);
      await context.close();
    });
  }
}

for (const path of KINDS) {
  test(`${path} is walked through by keyboard, and every stop is seen`, async () => {
    const { page, context } = await opened(path);
    await page.keyboard.press("Tab");
    assert.equal(
      await page.evaluate(() => document.activeElement.className),
      "skip",
      "the way to the content",
    );
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.id), "main");
    await page.evaluate(() => document.activeElement.blur());
    const expected = await page.evaluate(stops);
    const met = [];
    for (let i = 0; i < expected + 50; i += 1) {
      await page.keyboard.press("Tab");
      const stop = await page.evaluate(here);
      if (stop === null) break;
      met.push(stop);
      if (stop.last) break;
    }
    assert.deepEqual(
      met.filter(({ seen }) => !seen).map(({ html }) => html),
      [],
      "stops that show no focus",
    );
    assert.ok(met.at(-1)?.last, `the walk ends before the end of the page: ${met.at(-1)?.html}`);
    await context.close();
  });
}

/** How many things on the page can be focused. */
function stops() {
  return document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex]").length;
}

/** Where the focus is: whether it shows, whether it is at the page's last link; null outside of the page. */
function here() {
  const element = document.activeElement;
  if (!element || element === document.body) return null;
  const style = getComputedStyle(element);
  const box = element.getBoundingClientRect();
  const ringed = style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
  const inside = box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth;
  const all = document.querySelectorAll("footer a[href]");
  return {
    html: element.outerHTML.slice(0, 160),
    seen: (ringed || getComputedStyle(element, ":focus").boxShadow !== "none") && inside,
    last: element === all[all.length - 1],
  };
}

test("what was read works offline, the arm beside an example, too", async () => {
  const { page, context } = await opened("index.html", { ...WIDE, serviceWorkers: "allow" });
  await page.evaluate(() => navigator.serviceWorker.ready);
  await context.setOffline(true);
  for (const path of ["examples/6-1.html", "docs/students.html", "arms.html"]) {
    await page.goto(`${server.root}/${path}`);
    await page.locator("h1").waitFor();
  }
  await page.goto(`${server.root}/examples/6-3.html`);
  await page.locator('.live input[type="range"]').first().waitFor();
  await context.close();
});

test("the arm beside an example moves by keyboard", async () => {
  const { page, context, wrong } = await opened("examples/6-1.html");
  const slider = page.locator('.live input[type="range"]').first();
  await slider.waitFor();
  const numbers = page.locator(".live .arm-figures").first();
  const before = await numbers.innerText();
  await slider.focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(
    (old) => document.querySelector(".live .arm-figures")?.innerText !== old,
    before,
  );
  assert.deepEqual(wrong, []);
  await context.close();
});

test("the gallery leads to practice with the arm chosen", async () => {
  const { page, context } = await opened("arms.html");
  await page.locator("#planar-2r .do a").click();
  const chosen = page.locator(".settings select").first();
  await chosen.waitFor();
  assert.equal(await chosen.inputValue(), "planar-2r");
  await context.close();
});
