// A running `qdot serve` with a small class, for tests in a browser.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { isPageError, PATIENCE } from "../tools/browser.mjs";

const QDOT = process.env.QDOT ?? "qdot";

/** The arm of the chapter, so that everybody has the same right answers; a text that a person marks; hints. */
const ASSIGNMENT = `title = "Week 3: arms"
key = "week-3"
due = 2100-01-15T12:00:00+00:00
late = {per_day = 0.1}
hints = true
variation = "chapter"
[[problem]]
family = "planar-2r"
questions = ["jacobian", "determinant", "joint-effect", "why"]
points = [2, 1, 1, 3]
[question.why]
title = "Why?"
prompt = "Say in a few words why the arm is singular."
answer = "text"
`;
export const RIGHT = { determinant: "a1*a2*sin(theta2)" };
const NAMES = ["Ada Lovelace", "Emmy Noether", "Sofia Kovalevskaya", "Grace Chisholm Young"];

function findFreePort() {
  return new Promise((done) => {
    const server = createServer();
    server.listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => done(port));
    });
  });
}

/** Start a service; return its address, the personal link of a student (s1, s2, …) or of the staff, and how to end it. */
export async function startService() {
  const folder = mkdtempSync(join(tmpdir(), "qdot-serve-"));
  const homework = join(folder, "hw");
  execFileSync(QDOT, ["init", homework], { stdio: "ignore" });
  writeFileSync(join(homework, "assignment.toml"), ASSIGNMENT);
  const rows = NAMES.map((name, i) => `s${i + 1},${name},s${i + 1}@example.edu`);
  writeFileSync(join(homework, "roster.csv"), ["student,name,email", ...rows, ""].join("\n"));
  const port = await findFreePort();
  const root = `http://127.0.0.1:${port}`;
  const table = join(folder, "links.csv");
  execFileSync(QDOT, ["serve", "links", homework, "--staff", "Grace Hopper", "--url", root, "--out", table], {
    stdio: "ignore",
  });
  const service = spawn(QDOT, ["serve", homework, "--port", port, "--url", root, "--jobs", "1"], { stdio: "pipe" });
  let text = "";
  await new Promise((done, fail) => {
    for (const stream of [service.stdout, service.stderr])
      stream.on("data", (data) => (text += data).includes("qdot is at") && done());
    service.on("exit", (code) => fail(new Error(`qdot serve ended with ${code}: ${text}`)));
  });
  const links = readFileSync(table, "utf8").trim().split("\n").slice(1);
  return {
    root,
    link: (who) => /http\S+/.exec(links.find((line) => line.startsWith(`${who},`)))[0],
    async stop() {
      service.removeAllListeners("exit");
      const end = new Promise((done) => service.once("exit", done));
      service.kill("SIGINT");
      await end;
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** Open a browser, sign in with a personal link, and record the errors on its pages. */
export async function signIn(browser, service, who, options = {}) {
  const context = await browser.newContext({
    ...{ locale: "en-GB", timezoneId: "Europe/Berlin", viewport: { width: 1280, height: 900 } },
    ...options,
  });
  context.setDefaultTimeout(PATIENCE);
  const wrong = [];
  context.on("weberror", (error) => wrong.push(String(error.error())));
  context.on("console", (said) => isPageError(said) && wrong.push(said.text()));
  const page = await context.newPage();
  await page.goto(service.link(who));
  assert.match(new URL(page.url()).pathname, /^\/(a\/week-3\/.*)?$/);
  const open = async (path, tab = page) => {
    await tab.goto(`${service.root}/a/week-3/${path}`);
    return tab;
  };
  const work = () => page.evaluate(() => fetch("/a/week-3/work").then((response) => response.json()));
  return { context, page, wrong, open, work };
}

/** Open a question, and wait until its arm and its fields are there. */
export async function openQuestion({ open }, part, tab) {
  const page = await open(`?part=p1.${part}`, tab);
  await page.locator(`[data-item="p1.${part}"] form`).waitFor();
  await page.locator(".arm-box").waitFor();
  return page;
}

export const submit = (page) => page.getByRole("button", { name: "Submit", exact: true }).click();
