// Runs the tests in the browser: the site is built once for all of them, and two files are at work at a time.
//
//     QDOT=../.venv/bin/qdot npm run e2e        # or SITE=folder of a built site
import { spawn } from "node:child_process";
import { readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { builtSite } from "./browser.mjs";

/** On two cores a second file runs while the first waits for its page; more only wait for each other. */
const AT_ONCE = 2;

const folder = join(dirname(fileURLToPath(import.meta.url)), "../e2e");
const wanted = process.argv.slice(2);
const files = readdirSync(folder).filter((name) => name.endsWith(".test.mjs"));
const chosen = wanted.length ? files.filter((name) => wanted.some((part) => name.includes(part))) : files;
const site = builtSite();
const tests = spawn(
  process.execPath,
  [
    "--experimental-websocket",
    "--test",
    `--test-concurrency=${AT_ONCE}`,
    ...chosen.map((name) => join(folder, name)),
  ],
  { stdio: "inherit", env: { ...process.env, SITE: site.folder } },
);
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => tests.kill(signal));
tests.on("exit", (code) => {
  site.remove();
  process.exit(code ?? 1);
});
