// The built site in a real browser: problems solved rightly and wrongly, the arm moved, everything reachable by keyboard.
//
// The site is built by `$QDOT site build` (default: qdot) unless SITE names a folder that has one. Chromium is the system's.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { after, before, test } from "node:test";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const require = createRequire(import.meta.url);
const AXE = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".json": "application/json",
  ".svg": "image/svg+xml",
};
const CHROMIUM = [
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
  "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
].find(existsSync);
if (!CHROMIUM && !process.env.CI) {
  console.error("no Chromium: the site is not tried in a browser (apt-get install chromium)");
  process.exit(0);
}
const ARGUMENTS = [
  "--no-sandbox",
  "--disable-gpu",
  "--no-first-run",
  "--disable-background-networking",
  "--enable-unsafe-swiftshader",
];

let made, folder, server, root, browser;

before(async () => {
  assert.ok(CHROMIUM, "no Chromium: apt-get install chromium");
  made = process.env.SITE ? null : mkdtempSync(join(tmpdir(), "qdot-site-"));
  folder = process.env.SITE ?? made;
  if (made) {
    execFileSync(process.env.QDOT ?? "qdot", [
      "site",
      "build",
      "--out",
      made,
      "--families",
      "planar-2r",
      "--variants",
      "1",
    ]);
  }
  server = createServer((request, answer) => {
    const path = join(folder, normalize(decodeURIComponent(new URL(request.url, "http://x").pathname)));
    if (!path.startsWith(folder) || !existsSync(path)) return void answer.writeHead(404).end();
    answer
      .writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" })
      .end(readFileSync(path));
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  root = `http://127.0.0.1:${server.address().port}`;
  browser = await chromium.launch({ executablePath: CHROMIUM, args: ARGUMENTS });
});

after(async () => {
  await browser?.close();
  server?.close();
  if (made) rmSync(made, { recursive: true, force: true });
});

/** A page with nothing kept, that fails the test on any error in its script. */
async function page(path, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 900 },
    serviceWorkers: "block",
    ...options,
  });
  const opened = await context.newPage();
  const errors = [];
  opened.on("pageerror", (error) => errors.push(String(error)));
  opened.on("console", (said) => said.type() === "error" && errors.push(said.text()));
  await opened.goto(`${root}/${path}`);
  return { opened, context, errors };
}

const ask = (question) => page(`practice.html?arm=planar-2r&question=${question}`);
const problem = () => JSON.parse(readFileSync(join(folder, "bank/planar-2r/001.json"), "utf8"));
const solutions = () => JSON.parse(readFileSync(join(folder, "bank/planar-2r/001.solutions.json"), "utf8"));
const typed = (kind) => solutions().parts.find(({ name }) => name === kind).typed;

/** Answers as text, checks, and returns the verdict's heading and text. */
async function answered(opened, text) {
  const asText = opened.getByRole("button", { name: "Type it as text" });
  await opened.locator("form .answer").waitFor();
  if (await asText.count()) await asText.click();
  await opened.getByLabel("Your answer").fill(text);
  await opened.getByRole("button", { name: "Check" }).click();
  const verdict = opened.locator(".verdict");
  await verdict.waitFor();
  return { heading: await verdict.locator("h3").innerText(), text: await verdict.innerText() };
}

/** What `Matrix([...])` holds, with the first sine or cosine written as an equivalent. */
const forms = {
  "as it is in the solution": (text) => text,
  "as a product with one": (text) => text.replace(/\[\[/, "[[1*"),
  "with sines of half the angle": (text) => text.replace(/sin\((theta1)\)/g, "(2*sin($1/2)*cos($1/2))"),
};

for (const [name, form] of Object.entries(forms)) {
  test(`a right Jacobian is right ${name}`, async () => {
    const { opened, context, errors } = await ask("jacobian");
    const { heading } = await answered(opened, form(typed("jacobian")));
    assert.equal(heading, "Right");
    assert.deepEqual(errors, []);
    await context.close();
  });
}

test("three mistakes are named", async () => {
  const { parts, said } = problem();
  const { key } = parts.find(({ name }) => name === "jacobian");
  assert.ok(key.mistakes.length >= 3 && said.length >= 3);
  const wrong = { "rows swapped": /row/i, "sign of all": /sign|order/i, transposed: /row|column|transpos/i };
  const text = typed("jacobian").replace(/\s+/g, " ");
  const [top, bottom] = rowsOf(text);
  const answers = {
    "rows swapped": `[[${bottom}], [${top}]]`,
    transposed: `[[${pieces(top)[0]}, ${pieces(bottom)[0]}], [${pieces(top)[1]}, ${pieces(bottom)[1]}]]`,
  };
  answers["sign of all"] = `[[${negated(top)}], [${negated(bottom)}]]`;
  for (const [name, shown] of Object.entries(wrong)) {
    const { opened, context } = await ask("jacobian");
    const { heading, text: told } = await answered(opened, answers[name]);
    assert.notEqual(heading, "Right", name);
    assert.match(told, /It looks like this/, `${name}: ${told}`);
    assert.match(told, shown, name);
    await context.close();
  }
});

/** The texts between the commas that stand in no brackets. */
function pieces(text) {
  let depth = 0;
  const found = [""];
  for (const sign of text) {
    depth += "([".includes(sign) - ")]".includes(sign);
    if (sign === "," && depth === 0) found.push("");
    else found[found.length - 1] += sign;
  }
  return found.map((piece) => piece.trim()).filter(Boolean);
}

/** The rows of Matrix([[…], […]]), without their brackets. */
function rowsOf(text) {
  const inner = text.slice(text.indexOf("[") + 1, text.lastIndexOf("]"));
  return pieces(inner).map((row) => pieces(row.slice(1, -1)).join(", "));
}

const negated = (row) =>
  pieces(row)
    .map((cell) => `-(${cell})`)
    .join(", ");

test("singular configurations are judged by the arm itself", async () => {
  const { opened, context } = await ask("singular-angles");
  const { heading } = await answered(opened, typed("singular-angles"));
  assert.equal(heading, "Right");
  await context.close();
  const other = await ask("singular-angles");
  const { heading: wrong, text } = await answered(other.opened, "theta1 = 0");
  assert.equal(wrong, "Not right");
  assert.match(text, /theta1 = 0/);
  await other.context.close();
});

test("hints come one by one, then the solution; progress is kept over a reload", async () => {
  const { opened, context } = await ask("determinant");
  await answered(opened, "0");
  for (const number of [1, 2, 3]) await opened.getByRole("button", { name: `Show hint ${number}` }).click();
  assert.equal(await opened.locator(".hint").count(), 3);
  await opened.getByRole("button", { name: "Show the solution" }).click();
  await opened.locator(".solution math").first().waitFor();
  await opened.reload();
  await opened.getByText("Your progress").click();
  await opened.getByText("0 right of 1 tried").waitFor();
  await context.close();
});

test("the arm moves by keyboard, and its numbers follow", async () => {
  const { opened, context, errors } = await ask("position");
  const slider = opened.locator('input[type="range"]').first();
  await slider.waitFor();
  const before = await opened.locator("#arm").innerText();
  await slider.focus();
  for (let i = 0; i < 5; i += 1) await opened.keyboard.press("ArrowRight");
  await opened.waitForFunction((old) => document.querySelector("#arm")?.innerText !== old, before);
  assert.deepEqual(errors, []);
  await context.close();
});

test("a choice is made and checked by keyboard alone", async () => {
  const { opened, context } = await ask("singularity-type");
  await opened.locator('input[type="radio"]').first().waitFor();
  for (let i = 0; i < 60; i += 1) {
    await opened.keyboard.press("Tab");
    if (await opened.evaluate(() => document.activeElement?.getAttribute("type") === "radio")) break;
  }
  await opened.keyboard.press("Space");
  await opened.keyboard.press("Enter");
  await opened.locator(".verdict").waitFor();
  await context.close();
});

test("another language is chosen and stays, with its decimal comma", async () => {
  const { opened, context, errors } = await ask("jacobian");
  await opened.getByLabel("Language").selectOption("de");
  await opened.getByText("Den Arm bewegen").waitFor();
  await opened.getByRole("link", { name: "Üben" }).waitFor();
  await opened.getByRole("button", { name: "Als Text eingeben" }).click();
  await opened.getByLabel("Deine Antwort").fill("[[1, 2], [3, 4]]");
  await opened.getByRole("button", { name: "Prüfen" }).click();
  assert.match(await opened.locator(".verdict").innerText(), /richtig wäre -?\d+,\d/);
  assert.deepEqual(errors, []);
  await context.close();
});

test("an answer is typed as mathematics", async () => {
  const { opened, context, errors } = await ask("determinant");
  await opened.getByRole("button", { name: "Mathematics keyboard" }).click();
  const field = opened.locator("math-field");
  await field.waitFor();
  await field.evaluate((element) => {
    element.setValue("\\frac{a_1}{2}\\sin\\theta_2");
    element.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await opened.locator(".preview math").waitFor();
  await opened.getByRole("button", { name: "Check" }).click();
  await opened.locator(".verdict").waitFor();
  assert.doesNotMatch(await opened.locator(".verdict").innerText(), /can't be read/);
  assert.deepEqual(errors, []);
  await context.close();
});

test("it works offline after the first visit", async () => {
  const { opened, context } = await page("practice.html?arm=planar-2r&question=position", {
    serviceWorkers: "allow",
  });
  await opened.evaluate(() => navigator.serviceWorker.ready);
  await opened.locator("form .answer").waitFor();
  await opened.waitForFunction(() => navigator.serviceWorker.controller !== null);
  await opened.reload();
  await opened.locator("form .answer").waitFor();
  await context.setOffline(true);
  await opened.reload();
  const { heading } = await answered(opened, typed("position"));
  assert.equal(heading, "Right");
  await context.close();
});

for (const path of [
  "index.html",
  "practice.html?arm=planar-2r&question=jacobian",
  "accessibility.html",
  "docs/index.html",
]) {
  for (const [name, options] of [
    ["wide and light", { colorScheme: "light" }],
    ["on a phone in the dark", { colorScheme: "dark", viewport: { width: 390, height: 844 } }],
  ]) {
    test(`${path} is accessible ${name}`, async (t) => {
      if (path.startsWith("docs") && !existsSync(join(folder, path))) return t.skip("this build has no docs");
      const { opened, context, errors } = await page(path, options);
      await opened.waitForLoadState("networkidle");
      await opened.evaluate(AXE);
      const { violations } = await opened.evaluate(() =>
        window.axe.run({ runOnly: ["wcag2a", "wcag2aa", "wcag21aa", "wcag22aa"] }),
      );
      assert.deepEqual(
        violations.map(
          ({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`,
        ),
        [],
      );
      const wider = await opened.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
      assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
      assert.deepEqual(errors, []);
      await context.close();
    });
  }
}

test("no page loads anything from elsewhere", async () => {
  const { opened, context } = await page("index.html");
  const elsewhere = [];
  opened.on("request", (request) => new URL(request.url()).origin !== root && elsewhere.push(request.url()));
  for (const path of ["practice.html", "docs/examples.html"]) {
    await opened.goto(`${root}/${path}`);
    await opened.waitForLoadState("networkidle");
  }
  assert.deepEqual(
    elsewhere.filter((address) => !address.startsWith("data:") && !address.startsWith("blob:")),
    [],
  );
  await context.close();
});
