// Measures how long it takes to drag P of an arm with six joints on the practice page: the processor time of the page's
// main thread for each move, with one move per frame and without throttling. The goal is a quarter of a frame, 4.2 ms,
// because a phone is four times as slow. Other work on the machine adds time, so two builds are compared in turns.
//
//     QDOT=../.venv/bin/qdot node bench/dragging.mjs [SITE [OTHER SITE]]        # folders of built sites with anthropomorphic-6r
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { launched, served } from "../tools/browser.mjs";

const ARM = "anthropomorphic-6r";
const MOVES = 60;
const ROUNDS = Number(process.env.ROUNDS ?? 3);

/** Return the processor time (ms) of the main thread, per move and per frame in which nothing moves. */
async function dragged(browser, root) {
  const context = await browser.newContext({ serviceWorkers: "block", viewport: { width: 1280, height: 900 } });
  const page = await context.newPage();
  await page.goto(`${root}/practice.html?arm=${ARM}&question=link-velocity`);
  await page.locator(".arm-zero").first().waitFor({ state: "attached" });
  const session = await context.newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const spent = async () =>
    1000 * (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "TaskDuration").value;
  const box = await page.locator(".arm-point-ring").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const moved = async (by) => {
    const before = await spent();
    await page.evaluate(
      async ([x, y, by, moves]) => {
        const box = document.querySelector(".arm-box");
        for (let i = 0; i < moves; i += 1) {
          await new Promise((done) => requestAnimationFrame(done));
          const to = { clientX: x + by * Math.sin(i / 8), clientY: y + by * Math.sin(i / 11) };
          box.dispatchEvent(new PointerEvent("pointermove", { bubbles: true, pointerId: 1, buttons: 1, ...to }));
        }
      },
      [x, y, by, MOVES],
    );
    return ((await spent()) - before) / MOVES;
  };
  await page.mouse.move(x, y);
  const still = await moved(30); // nothing is held yet
  await page.mouse.move(x, y);
  await page.mouse.down();
  await moved(30); // what runs for the first time takes longer
  const all = await moved(30);
  await context.close();
  return all - still;
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

function built() {
  const folder = mkdtempSync(join(tmpdir(), "qdot-site-"));
  execFileSync(process.env.QDOT ?? "qdot", [
    ...["site", "build", "--out", folder],
    ...["--families", ARM, "--variants", "1"],
  ]);
  return folder;
}

const given = process.argv.slice(2);
const folders = given.length ? given : [built()];
const servers = await Promise.all(folders.map(served));
const browser = await launched();
const found = folders.map(() => []);
try {
  for (let round = 0; round < ROUNDS; round += 1)
    for (const [i, { root }] of servers.entries()) found[i].push(await dragged(browser, root));
  folders.forEach((folder, i) =>
    console.log(
      `${folder}: a move of P takes ${median(found[i]).toFixed(1)} ms of the main thread, median of ${ROUNDS} ` +
        `(${found[i].map((each) => each.toFixed(1)).join(", ")})`,
    ),
  );
} finally {
  await browser.close();
  for (const server of servers) server.close();
  if (!given.length) rmSync(folders[0], { recursive: true, force: true });
}
