// Answers the requests of tests/tools/readers.py on standard input: how the site parses texts and judges answers.
import { dirname, join } from "node:path";
import { text } from "node:stream/consumers";
import { fileURLToPath } from "node:url";

import { runnerImport } from "vite";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const { module } = await runnerImport("./tests/readings.ts", { root, configFile: false, logLevel: "error" });
process.stdout.write(JSON.stringify(module.resultsOf(JSON.parse(await text(process.stdin)))));
