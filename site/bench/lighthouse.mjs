// Runs Lighthouse on the first page, a lesson and the practice page, and prints the median of three runs on a simulated
// slow phone and on a desktop.
//
// Lighthouse is not a dependency of the site: npx fetches this version, or LIGHTHOUSE names an installed program.
// Other work on the machine lowers the performance score, so run it on an idle machine.
//
//     make lighthouse        # or: QDOT=../.venv/bin/qdot node bench/lighthouse.mjs; SITE=folder of a built site
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";

import { builtSite, CHROMIUM } from "../tools/browser.mjs";

const VERSION = "12.8.2";
const PAGES = ["index.html", "learn.html?lesson=rates", "practice.html?arm=planar-2r&question=jacobian"];
const TIMES = Number(process.env.TIMES ?? 3);
const GOAL = 95;
const [program, ...first] = process.env.LIGHTHOUSE
  ? [process.env.LIGHTHOUSE]
  : ["npx", "--yes", `lighthouse@${VERSION}`];

/** Return Lighthouse's report on a page, on a phone or a "desktop". */
function report(address, preset, folder) {
  const path = join(folder, "report.json");
  const how = ["--quiet", "--chrome-flags=--headless=new --no-sandbox", "--output=json", `--output-path=${path}`];
  const done = spawnSync(program, [...first, address, ...how, ...(preset === "desktop" ? ["--preset=desktop"] : [])], {
    env: { ...process.env, CHROME_PATH: process.env.CHROME_PATH ?? CHROMIUM },
    encoding: "utf8",
  });
  if (done.status !== 0) throw new Error(`Lighthouse can't be run: ${done.error ?? done.stderr.slice(-800)}`);
  return JSON.parse(readFileSync(path, "utf8"));
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

const site = builtSite();
const folder = mkdtempSync(join(tmpdir(), "qdot-lighthouse-"));
// This process waits for Lighthouse, so the server must be a separate process.
const server = spawn(process.execPath, [new URL("../tools/serve.mjs", import.meta.url).pathname, site.folder]);
const root = await new Promise((found) => server.stdout.once("data", (line) => found(String(line).trim())));
let short = false;
try {
  for (const path of PAGES)
    for (const preset of ["phone", "desktop"]) {
      const reports = Array.from({ length: TIMES }, () => report(`${root}/${path}`, preset, folder));
      const scores = Object.keys(reports[0].categories).map((name) => [
        name,
        median(reports.map(({ categories }) => Math.round(100 * categories[name].score))),
      ]);
      const blocked = median(reports.map(({ audits }) => audits["total-blocking-time"].numericValue));
      const paint = median(reports.map(({ audits }) => audits["largest-contentful-paint"].numericValue));
      short ||= scores.some(([, score]) => score < GOAL);
      console.log(
        `${preset.padEnd(8)} ${path.padEnd(48)} ${scores.map(([name, score]) => `${name} ${score}`).join(", ")}; ` +
          `largest paint ${Math.round(paint)} ms, blocked ${Math.round(blocked)} ms`,
      );
    }
  console.log(`median of ${TIMES}; ${loadavg()[0].toFixed(1)} processes at work at the end`);
} finally {
  server.kill();
  rmSync(folder, { recursive: true, force: true });
  site.remove();
}
process.exitCode = short ? 1 : 0;
