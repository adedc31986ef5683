// Answer each question of SCORM packages wrong and then right, in Chromium with a SCORM run-time; print what it recorded.
//
//     node scorm_page.mjs SCORM-AGAIN FOLDER        # FOLDER has the unpacked packages scorm12 and scorm2004
import { cpSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { launched, served } from "../../site/tools/browser.mjs";
import { answer, goToQuestion, loadQuestion } from "./scorm_answers.mjs";

const [runtime, folder] = process.argv.slice(2);
const VERSIONS = {
  scorm12: { api: "API", Class: "Scorm12API", learner: { core: { student_id: "ada" } } },
  scorm2004: { api: "API_1484_11", Class: "Scorm2004API", learner: { learner_id: "ada" } },
};

/** Answer all questions of a package; return what the run-time recorded. */
async function runPackage(browser, root, name, { api, Class, learner }) {
  cpSync(join(runtime, "dist", `${name}.min.js`), join(folder, `${name}.js`));
  writeFileSync(
    join(folder, `${name}.html`),
    `<!DOCTYPE html><title>Platform</title><link rel="icon" href="data:,"><script src="${name}.js"></script><script>
    const api = (window.api = window.${api} = new ${Class}({ autocommit: false, logLevel: 5 }));
    api.loadFromJSON(${JSON.stringify(learner)}, "cmi");</script>
    <iframe src="${name}/index.html" width="1200" height="860" title="package"></iframe>`,
  );
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
  let errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(`${root}/${name}.html`);
  const frame = page.frameLocator("iframe");
  await frame.locator("form .answer").waitFor();
  const readCmi = () => page.evaluate(() => JSON.parse(JSON.stringify(window.api.cmi)));
  const readInteractions = () =>
    page.evaluate(() => {
      const interactions = window.api.cmi.interactions.childArray;
      return [interactions.length, interactions.at(-1)?.toJSON().result ?? ""];
    });
  const questions = [];
  const places = frame.locator(".round-places button");
  for (let place = 0; place < (await places.count()); place += 1) {
    errors = [];
    const item = await goToQuestion(frame, place);
    const part = loadQuestion(join(folder, name), item);
    const hasPrompt = (await frame.locator(".task").innerText()).length > part.title.length + 20;
    const results = [];
    for (const isRight of [false, true]) {
      const [before] = await readInteractions();
      await answer(frame, part, isRight);
      await page
        .waitForFunction((before) => window.api.cmi.interactions.childArray.length > before, before, { timeout: 8000 })
        .catch(() => undefined);
      const [count, result] = await readInteractions();
      results.push(count > before ? result : `nothing: ${await frame.locator(".verdict").allInnerTexts()}`);
    }
    questions.push({ item, shown: hasPrompt && errors.length === 0, errors, wrong: results[0], right: results[1] });
  }
  const cmi = await readCmi();
  await page.close();
  return {
    version: name,
    questions,
    score: cmi.core?.score ?? cmi.score,
    status: cmi.core?.lesson_status ?? cmi.completion_status,
  };
}

const server = await served(folder);
const browser = await launched();
const results = [];
for (const [name, version] of Object.entries(VERSIONS))
  results.push(await runPackage(browser, server.root, name, version));
console.log(JSON.stringify(results));
await browser.close();
server.close();
