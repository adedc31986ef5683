// Packages under SCORM's run-time in Chromium, each question answered wrong and then right: what the run-time has of it.
//
//     node scorm_page.mjs SCORM-AGAIN FOLDER        # FOLDER has the packages, unpacked, as scorm12 and scorm2004
import { cpSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { launched, served } from "../../site/tools/browser.mjs";
import { about, answer, itemAt } from "./scorm_answers.mjs";

const [runtime, folder] = process.argv.slice(2);
const VERSIONS = {
  scorm12: {
    api: "API",
    Class: "Scorm12API",
    learner: { core: { student_id: "ada" } },
  },
  scorm2004: {
    api: "API_1484_11",
    Class: "Scorm2004API",
    learner: { learner_id: "ada" },
  },
};
async function ran(browser, root, name, { api, Class, learner }) {
  cpSync(join(runtime, "dist", `${name}.min.js`), join(folder, `${name}.js`));
  writeFileSync(
    join(folder, `${name}.html`),
    `<!DOCTYPE html><title>Platform</title><link rel="icon" href="data:,"><script src="${name}.js"></script><script>
    const api = (window.api = window.${api} = new ${Class}({ autocommit: false, logLevel: 5 }));
    api.loadFromJSON(${JSON.stringify(learner)}, "cmi");</script>
    <iframe src="${name}/index.html" width="1200" height="860" title="package"></iframe>`,
  );
  const page = await browser.newPage({
    viewport: { width: 1280, height: 900 },
  });
  let errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (said) => said.type() === "error" && errors.push(said.text()));
  await page.goto(`${root}/${name}.html`);
  const frame = page.frameLocator("iframe");
  await frame.locator("form .answer").waitFor();
  const cmi = () => page.evaluate(() => JSON.parse(JSON.stringify(window.api.cmi)));
  const last = () =>
    page.evaluate(() => {
      const all = window.api.cmi.interactions.childArray;
      return [all.length, all.at(-1)?.toJSON().result ?? ""];
    });
  const questions = [];
  const places = frame.locator(".round-places button");
  for (let place = 0; place < (await places.count()); place += 1) {
    errors = [];
    const item = await itemAt(frame, place);
    const part = about(join(folder, name), item);
    const prompt = (await frame.locator(".task").innerText()).length > part.title.length + 20;
    const results = [];
    for (const isRight of [false, true]) {
      const [before] = await last();
      await answer(frame, part, isRight);
      await page
        .waitForFunction((before) => window.api.cmi.interactions.childArray.length > before, before, { timeout: 8000 })
        .catch(() => undefined);
      const [count, result] = await last();
      results.push(count > before ? result : `nothing: ${await frame.locator(".verdict").allInnerTexts()}`);
    }
    questions.push({
      item,
      shown: prompt && errors.length === 0,
      errors,
      wrong: results[0],
      right: results[1],
    });
  }
  const now = await cmi();
  await page.close();
  return {
    version: name,
    questions,
    score: now.core?.score ?? now.score,
    status: now.core?.lesson_status ?? now.completion_status,
  };
}

const server = await served(folder);
const browser = await launched();
const told = [];
for (const [name, version] of Object.entries(VERSIONS)) told.push(await ran(browser, server.root, name, version));
console.log(JSON.stringify(told));
await browser.close();
server.close();
