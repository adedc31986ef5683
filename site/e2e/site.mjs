// The built site on a server of its own, for the tests in a browser.
//
// The site is built by `$QDOT site build` (default: qdot) unless SITE names a folder that has one.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";

const TYPES = {
  ".html": "text/html",
  ".js": "text/javascript",
  ".css": "text/css",
  ".json": "application/json",
  ".svg": "image/svg+xml",
};

/** The folder of the site, its address, how to read of its bank, and how to end it all. */
export async function served() {
  const made = process.env.SITE ? null : mkdtempSync(join(tmpdir(), "qdot-site-"));
  const folder = process.env.SITE ?? made;
  if (made) {
    const order = ["site", "build", "--out", made, "--families", "planar-2r", "--variants", "1"];
    execFileSync(process.env.QDOT ?? "qdot", order);
  }
  const server = createServer((request, answer) => {
    const asked = decodeURIComponent(new URL(request.url, "http://x").pathname);
    const path = join(folder, normalize(asked.endsWith("/") ? `${asked}index.html` : asked));
    if (!path.startsWith(folder) || !existsSync(path)) return void answer.writeHead(404).end();
    answer
      .writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream" })
      .end(readFileSync(path));
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const bank = (name) => JSON.parse(readFileSync(join(folder, `bank/${name}.json`), "utf8"));
  return {
    folder,
    root: `http://127.0.0.1:${server.address().port}`,
    bank,
    /** The right answer to a question about the planar arm, as it is typed. */
    typed: (kind) => bank("planar-2r/001.solutions").parts.find(({ name }) => name === kind).typed,
    close() {
      server.close();
      server.closeAllConnections();
      if (made) rmSync(made, { recursive: true, force: true });
    },
  };
}
