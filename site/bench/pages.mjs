// Measures the site, without limits: how soon pages appear, how fast answers are graded, and what is loaded.
//
//     QDOT=../.venv/bin/qdot node bench/pages.mjs        # or SITE=folder of a built site
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { builtSite, CHROMIUM, launched, served } from "../tools/browser.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const PAGES = ["index.html", "practice.html", "examples/6-1.html"];
const TIMES = 5;
const KINDS = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"];

/** Return the quantile of some values: the value below which a given share of them is. */
function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

const figure = (value, digits = 0) => value.toFixed(digits);

/** Return the first contentful paint in milliseconds, in a browser without a cache. */
async function firstPaint(browser, address) {
  const context = await browser.newContext({ serviceWorkers: "block" });
  const page = await context.newPage();
  await page.goto(address);
  await page.waitForLoadState("networkidle");
  const found = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? NaN);
  await context.close();
  return found;
}

async function pages(browser, server) {
  for (const path of PAGES) {
    const found = [];
    for (let i = 0; i < TIMES; i += 1) found.push(await firstPaint(browser, `${server.root}/${path}`));
    server.sent.clear();
    await firstPaint(browser, `${server.root}/${path}`);
    const own = [...server.sent].filter(([name]) => !name.startsWith("/bank/"));
    const bank = [...server.sent].filter(([name]) => name.startsWith("/bank/"));
    const kB = (files) => figure(files.reduce((sum, [, size]) => sum + size, 0) / 1000);
    console.log(
      `${path.padEnd(20)} first contentful paint ${figure(quantile(found, 0.5))} ms (median of ${TIMES}); ` +
        `loaded ${kB(own)} kB in ${own.length} files, and ${kB(bank)} kB of the bank (gzip)`,
    );
  }
}

/** Return the times from pressing Check to the verdict, measured by the page, for right and wrong answers. */
async function answers(browser, server, site) {
  const read = (kind) => JSON.parse(readFileSync(join(site.folder, `bank/planar-2r/001/${kind}.json`), "utf8"));
  const typed = Object.fromEntries(KINDS.map((kind) => [kind, read(kind).solved.typed]));
  const took = [];
  for (const kind of KINDS) {
    const context = await browser.newContext({ serviceWorkers: "block" });
    const page = await context.newPage();
    await page.goto(`${server.root}/practice.html?arm=planar-2r&question=${kind}`);
    await page.locator("form .answer").waitFor();
    const asText = page.getByRole("button", { name: "Type it as text" });
    if (await asText.count()) await asText.click();
    await page.locator("#arm").scrollIntoViewIfNeeded(); // the arm loads when it is near the screen
    await page.locator("#arm .arm-box").waitFor();
    for (let i = 0; i < TIMES; i += 1) {
      const answer = i % 2 ? typed[kind].replace("theta2", "theta1") : typed[kind];
      await page.getByLabel("Your answer").fill(answer);
      await page.waitForTimeout(600); // until the answer's preview appears
      took.push(await page.evaluate(check));
    }
    await context.close();
  }
  console.log(
    `answer to verdict    median ${figure(quantile(took, 0.5), 1)} ms, 95 % below ${figure(quantile(took, 0.95), 1)} ms ` +
      `(${took.length} answers on the page, the first sign of it on the page)`,
  );
}

/** Press Check, and wait until the page changes. */
function check() {
  return new Promise((done) => {
    const start = performance.now();
    const watched = new MutationObserver(() => {
      watched.disconnect();
      done(performance.now() - start);
    });
    watched.observe(document.querySelector(".asked"), { childList: true, subtree: true, characterData: true });
    document.querySelector('form button[type="submit"]').click();
  });
}

/** Grade every answer of the corpus in the browser, with the grader of the built site. */
async function corpus(browser, server) {
  const { build } = await import("vite");
  const made = await build({
    configFile: false,
    logLevel: "silent",
    build: { write: false, minify: true, lib: { entry: join(HERE, "grading.ts"), formats: ["iife"], name: "grading" } },
  });
  const [{ output }] = [made].flat();
  const page = await browser.newPage();
  await page.goto(`${server.root}/icon.svg`);
  await page.evaluate(output[0].code + ";window.grading = grading");
  const cases = readFileSync(join(HERE, "../tests/corpus.json"), "utf8");
  const took = await page.evaluate((text) => window.grading.timed(text), cases);
  await page.close();
  console.log(
    `grading alone        median ${figure(quantile(took, 0.5), 2)} ms, 95 % below ${figure(quantile(took, 0.95), 2)} ms, ` +
      `longest ${figure(Math.max(...took), 1)} ms (${took.length} answers of the corpus)`,
  );
}

if (!CHROMIUM) {
  console.error("no Chromium: no figures of the site (apt-get install chromium)");
  process.exit(0);
}
const site = builtSite();
const server = await served(site.folder);
const browser = await launched();
try {
  console.log("the site, in Chromium on this machine, nothing throttled");
  await pages(browser, server);
  await answers(browser, server, site);
  await corpus(browser, server);
  for (const name of ["bank/index.json", "bank/planar-2r/001.json", "bank/planar-2r/001/jacobian.json"]) {
    const bytes = gzipSync(readFileSync(join(site.folder, name))).length;
    console.log(`${name.padEnd(35)} ${figure(bytes / 1000)} kB (gzip)`);
  }
} finally {
  await browser.close();
  server.close();
  site.remove();
}
