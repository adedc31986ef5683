// Answers what tests/tools/site_slips.py asks on standard input: what the site says of slips in right answers.
import { dirname, join } from "node:path";
import { text } from "node:stream/consumers";
import { fileURLToPath } from "node:url";

import { runnerImport } from "vite";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const { module } = await runnerImport("./tests/slips.ts", { root, configFile: false, logLevel: "error" });
process.stdout.write(JSON.stringify(module.allTold(JSON.parse(await text(process.stdin)))));
