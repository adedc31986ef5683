// Tools for tests and measurements in a browser: serve a built site as GitHub Pages does, and start the system's Chromium.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { gzipSync } from "node:zlib";

const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".json": "application/json",
  ".svg": "image/svg+xml",
  ".webmanifest": "application/manifest+json",
};
export const CHROMIUM = [
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
  "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
].find(existsSync);
/** Chromium without windows, if it is installed: opening a page takes an eighth of the processor time. */
const HEADLESS = ["/usr/bin/chromium-headless-shell", CHROMIUM].find(existsSync);
/** The time limit of a test, in milliseconds: long enough that no test fails because the machine is busy. */
export const PATIENCE = 120_000;
const ARGUMENTS = [
  "--no-sandbox",
  "--disable-gpu",
  "--no-first-run",
  "--disable-background-networking",
  "--enable-unsafe-swiftshader",
];

/** Return a built site, and a function that deletes it: SITE, or a new one with a single arm by `$QDOT site build`. */
export function builtSite() {
  if (process.env.SITE) return { folder: process.env.SITE, remove: () => undefined };
  const folder = mkdtempSync(join(tmpdir(), "qdot-site-"));
  execFileSync(process.env.QDOT ?? "qdot", [
    "site",
    "build",
    "--out",
    folder,
    "--families",
    "planar-2r",
    "--variants",
    "1",
  ]);
  return { folder, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** Serve a folder on this machine; texts are compressed with gzip once. `sent` counts the bytes of bodies by path. */
export async function served(folder) {
  const sent = new Map();
  const bodies = new Map();
  const server = createServer((request, answer) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://x").pathname));
    const file = join(folder, path.endsWith("/") ? `${path}index.html` : path);
    if (!file.startsWith(folder) || !existsSync(file) || statSync(file).isDirectory())
      return void answer
        .writeHead(404, { "content-type": "text/html; charset=utf-8" })
        .end(existsSync(join(folder, "404.html")) ? readFileSync(join(folder, "404.html")) : "");
    const body = bodies.get(file) ?? gzipSync(readFileSync(file));
    bodies.set(file, body);
    sent.set(path, body.length);
    answer
      .writeHead(200, {
        "content-type": `${TYPES[extname(file)] ?? "application/octet-stream"}; charset=utf-8`,
        "content-encoding": "gzip",
        "content-length": body.length,
        "cache-control": "max-age=600",
      })
      .end(body);
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const close = () => {
    server.close();
    server.closeAllConnections();
  };
  return { root: `http://127.0.0.1:${server.address().port}`, sent, close };
}

const AS = { executablePath: HEADLESS, args: ARGUMENTS };

/** Return the browser at the address CHROMIUM_AT, or a new one. */
export async function launched() {
  const { chromium } = await import("playwright-core");
  return process.env.CHROMIUM_AT ? chromium.connect(process.env.CHROMIUM_AT) : chromium.launch(AS);
}

/** Start a browser that other processes can use by its address, `wsEndpoint()`. */
export async function shared() {
  const { chromium } = await import("playwright-core");
  return chromium.launchServer(AS);
}

/** Return whether a message in the console is the page's error: not that a container of another test was started. */
export const isPageError = (said) => said.type() === "error" && !said.text().includes("ERR_NETWORK_CHANGED");
