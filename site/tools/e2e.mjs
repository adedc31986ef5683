// Runs the tests in the browser. They share one built site and one Chromium, and two files run at a time.
// QDOT_SUITE=whole runs all files; otherwise, only the smoke tests or the files that are named run.
//
//     QDOT=../.venv/bin/qdot npm run e2e        # or SITE=folder of a built site
import { spawn } from "node:child_process";
import { readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { builtSite, CHROMIUM, shared } from "./browser.mjs";

/** On two cores, a second file runs while the first one waits for its page. More files would only wait for each other. */
const AT_ONCE = 2;

if (!CHROMIUM) {
  console.error("no Chromium: the site's pages are not tried in a browser (apt-get install chromium)");
  process.exit(process.env.CI ? 1 : 0);
}
const folder = join(dirname(fileURLToPath(import.meta.url)), "../e2e");
const named = process.argv.slice(2);
const wanted = named.length > 0 ? named : process.env.QDOT_SUITE === "whole" ? [""] : ["smoke"];
const chosen = readdirSync(folder).filter(
  (name) => name.endsWith(".test.mjs") && wanted.some((part) => name.includes(part)),
);
const site = builtSite();
const browser = await shared();
const tests = spawn(
  process.execPath,
  [
    "--experimental-websocket",
    "--test",
    "--test-reporter=spec",
    `--test-concurrency=${AT_ONCE}`,
    ...chosen.map((name) => join(folder, name)),
  ],
  { stdio: "inherit", env: { ...process.env, SITE: site.folder, CHROMIUM_AT: browser.wsEndpoint() } },
);
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => tests.kill(signal));
tests.on("exit", async (code) => {
  await browser.close();
  site.remove();
  process.exit(code ?? 1);
});
