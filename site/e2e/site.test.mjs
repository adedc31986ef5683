// The practice page: verdicts, hints, stored progress, languages, the mathematics keyboard, and files that don't load.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, emptyTab, inChromium, opened, openedAnew } from "./opened.mjs";
import { bankOf } from "./site.mjs";

const there = inChromium();
const open = (path, options) => opened(there, path, options);
const ask = (question) => open(`practice.html?arm=planar-2r&question=${question}`);
const question = (kind) => bankOf(there.site.folder).bank(`planar-2r/001/${kind}`);
const typed = (kind) => bankOf(there.site.folder).typed(kind);

/** Type an answer as text, check it, and return the verdict's heading and text. */
async function answered(page, text) {
  const asText = page.getByRole("button", { name: "Type it as text" });
  await page.locator("form .answer").waitFor();
  if (await asText.count()) await asText.click();
  await page.getByLabel("Your answer").fill(text);
  await page.getByRole("button", { name: "Check" }).click();
  const verdict = page.locator(".verdict");
  await verdict.waitFor();
  return { heading: await verdict.locator("h3").innerText(), text: await verdict.innerText() };
}

test("hints are shown one by one, then the solution; progress is stored over a reload", async () => {
  const { page } = await ask("determinant");
  await answered(page, "0");
  for (const number of [1, 2, 3]) await page.getByRole("button", { name: `Show hint ${number}` }).click();
  assert.equal(await page.locator(".hint").count(), 3);
  await page.getByRole("button", { name: "Show the solution" }).click();
  await page.locator(".solution math").first().waitFor();
  await page.reload();
  await page.getByText("Your progress", { exact: true }).click();
  await page.getByText("0 of 1 right").waitFor();
});

test("a file of the progress restores problems and lessons", async () => {
  const { page, context } = await openedAnew(there, "practice.html");
  const stored = () =>
    page.evaluate(() => ["qdot-progress", "qdot-lessons"].map((name) => JSON.parse(localStorage.getItem(name))));
  await page.evaluate(() => {
    const item = document.querySelector(".task").dataset.item;
    localStorage.setItem("qdot-progress", JSON.stringify({ [item]: { right: true, box: 1, due: 4e12 } }));
    localStorage.setItem("qdot-lessons", JSON.stringify({ columns: { goals: [0], row: ["planar-2r/001"] } }));
  });
  await page.reload();
  const before = await stored();
  await page.getByText("Your progress", { exact: true }).click();
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save as a file" }).click();
  const buffer = Buffer.concat(await (await (await saved).createReadStream()).toArray());
  page.on("dialog", (dialog) => dialog.accept());
  await page.getByRole("button", { name: "Delete all progress" }).click();
  await page.getByText("0 of 0 right").waitFor();
  assert.deepEqual(await stored(), [{}, {}]);
  await page.getByLabel("Load a file").setInputFiles({ name: "kept.json", mimeType: "application/json", buffer });
  await page.getByText("1 of 1 right").waitFor();
  assert.deepEqual(await stored(), before);
  await context.close();
});

test("an answer that can't be parsed has no pose at which it differs, also after one that had", async () => {
  const { page } = await opened(there, "practice.html?arm=planar-2r&question=determinant");
  for (const [text, poses] of [
    ["a1*a2", 1],
    ["banana + a1", 0],
  ]) {
    await page.getByLabel("Your answer").fill(text);
    await page.getByRole("button", { name: "Check", exact: true }).click();
    await page.locator(".verdict", { hasText: poses ? "Wrong" : "couldn't parse this" }).waitFor();
    assert.equal(await page.locator(".verdict").getByText("shows a pose in which").count(), poses, text);
  }
});

test("the arm moves to the pose at which a wrong answer differs, after the verdict is shown", async () => {
  const { page, wrong } = await ask("position");
  await answered(page, "[a1*cos(theta1), a1*sin(theta1)]");
  await page.locator(".verdict a[href='#arm']").click();
  const told = await page.locator(".verdict").innerText();
  const due = /θ1\s=\s(-?[\d.]+)°/.exec(told)[1];
  const field = page.locator('.arm-joints input[type="number"]').first();
  await field.waitFor();
  const turned = Number(await field.inputValue()) - due;
  assert.ok(Math.abs(turned - 360 * Math.round(turned / 360)) < 0.1, `${turned} degrees off`);
  assert.deepEqual(wrong, []);
});

test("if the arm or typesetting can't be loaded, the page says so or shows LaTeX, and still grades", async () => {
  const { page, context } = await emptyTab(there);
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  await page.route(/(panel|temml)[^/]*\.js$/, (route) => route.abort());
  await page.goto(`${there.server.root}/practice.html?arm=planar-2r&question=determinant`);
  await page.locator("#arm").scrollIntoViewIfNeeded();
  await page.getByText("The arm could not be loaded").waitFor();
  await answered(page, typed("determinant"));
  assert.match(await page.locator(".verdict").innerText(), /^Right/);
  await page.getByRole("button", { name: "Show the solution" }).click();
  await page.locator(".tex").first().waitFor();
  assert.match(await page.locator(".tex").first().innerText(), /\\|_|=/);
  assert.deepEqual(errors, []);
  await context.close();
});

test("the mistake behind a wrong option is reported, also in another language", async () => {
  const { page, wrong } = await ask("singularity-type");
  const { key } = question("singularity-type");
  const other = page.locator('input[type="radio"]').nth(key.right[0] === 0 ? 1 : 0);
  const told = async (button) => {
    await other.check();
    await page.getByRole("button", { name: button }).click();
    return page.locator(".verdict.wrong .mistake").innerText();
  };
  assert.match(await told("Check"), /See (the text below )?\(6/);
  await page.getByLabel("Language").selectOption("de");
  await page.getByRole("link", { name: "Üben" }).waitFor();
  assert.match(await told("Prüfen"), /Siehe .*\(6/);
  assert.deepEqual(wrong, []);
});

test("a chosen language stays, and its decimal comma is accepted and written", async () => {
  const { page, wrong } = await ask("determinant");
  await page.getByLabel("Language").selectOption("de");
  await page.getByLabel("Den Arm bewegen").waitFor();
  await page.getByRole("link", { name: "Üben" }).waitFor();
  await page.getByLabel("Deine Antwort").fill("a1*(0,06*s2 - 0,3)");
  await page.locator(".preview math").waitFor();
  await page.getByRole("button", { name: "Prüfen" }).click();
  assert.match(await page.locator(".verdict").innerText(), /der richtige Wert ist -?\d+,\d/);
  assert.deepEqual(wrong, []);
});

test("an answer is typed as mathematics", async () => {
  const { page, wrong } = await ask("determinant");
  await page.getByRole("button", { name: "Mathematics keyboard" }).click();
  const field = page.locator("math-field");
  await field.waitFor();
  await field.evaluate((element) => {
    element.setValue("\\frac{a_1}{2}\\sin\\theta_2");
    element.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.locator(".preview math").waitFor();
  await page.getByRole("button", { name: "Check" }).click();
  await page.locator(".verdict").waitFor();
  assert.doesNotMatch(await page.locator(".verdict").innerText(), /couldn't( be)? parse/i);
  assert.deepEqual(wrong, []);
});

test("symbols are inserted at the cursor, in text and in mathematics, and the text stays in the other field", async () => {
  const { page, wrong } = await ask("determinant");
  const field = page.getByLabel("Your answer");
  await field.fill("2*+1");
  await field.evaluate((input) => input.setSelectionRange(2, 2));
  await page.getByRole("button", { name: "θ2, theta2", exact: true }).click();
  assert.equal(await field.inputValue(), "2*theta2+1");
  await page.getByRole("button", { name: "Mathematics keyboard" }).click();
  const math = page.locator("math-field");
  await math.waitFor();
  await math.evaluate((element) => (element.position = element.lastOffset));
  await page.getByRole("button", { name: "pi", exact: true }).click();
  await page.waitForFunction(() => document.querySelector("math-field").value.endsWith("\\pi"));
  assert.match(await math.evaluate((element) => element.value), /2.*theta_.?2.*1.*pi/);
  await page.getByRole("button", { name: "Plain text" }).click();
  assert.match(await page.getByLabel("Your answer").inputValue(), /theta_.?2/);
  assert.deepEqual(wrong, []);
});

test("a matrix is typed row by row: Enter begins a line until all rows are typed, and pasting fills the grid", async () => {
  const { page, wrong } = await ask("jacobian");
  const entries = [
    ["-a1*sin(theta1) - a2*sin(theta1 + theta2)", "-a2*sin(theta1 + theta2)"],
    ["a1*cos(theta1) + a2*cos(theta1 + theta2)", "a2*cos(theta1 + theta2)"],
  ];
  const rows = entries.map((row) => row.join(", "));
  await page.getByRole("button", { name: "Type it as text" }).click();
  const field = page.getByLabel("Your answer");
  await field.fill(rows[0]);
  await field.press("Enter");
  assert.equal(await field.inputValue(), `${rows[0]}\n`);
  assert.equal(await page.locator(".verdict").count(), 0);
  await field.fill(rows.join("\n"));
  await page.locator(".preview mtable").waitFor();
  await field.press("Enter");
  await page.locator(".verdict.correct").waitFor();
  await page.getByRole("button", { name: "Type it entry by entry" }).click();
  const fields = page.locator(".grid .formula-field");
  await fields.nth(3).fill("0");
  await fields.first().evaluate(
    (entry, text) => {
      const clipboardData = new DataTransfer();
      clipboardData.setData("text", text);
      entry.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
    },
    `[${rows.join("; ")}]`,
  );
  assert.deepEqual(await fields.evaluateAll((all) => all.map(({ value }) => value)), entries.flat());
  assert.deepEqual(wrong, []);
});

test("a matrix typed as text appears in its entries, and is right as mathematics", async () => {
  const { page, wrong } = await ask("jacobian");
  await page.getByRole("button", { name: "Type it as text" }).click();
  await page.getByLabel("Your answer").fill(typed("jacobian"));
  await page.getByRole("button", { name: "Type it entry by entry" }).click();
  assert.notEqual(await page.getByLabel("Row 2, column 2").inputValue(), "");
  await page.getByRole("button", { name: "Mathematics keyboard" }).click();
  await page.locator("math-field").nth(3).waitFor();
  await page.getByRole("button", { name: "Check" }).click();
  assert.equal(await page.locator(".verdict h3").innerText(), "Right");
  assert.deepEqual(wrong, []);
});

test("a problem is in German: its texts, a hint, the mistake behind an answer, and parse errors", async () => {
  const { page, wrong } = await ask("determinant");
  await page.getByLabel("Language").selectOption("de");
  await page.getByRole("heading", { name: "Üben" }).waitFor();
  await page.getByText("Beschreibungen der Zeichnungen sind auf Englisch.").waitFor();
  assert.match(await page.locator(".prompt").innerText(), /^Bestimme die Determinante der 2 × 2-Jacobi-Matrix/);
  assert.match(await page.locator(".statement").innerText(), /Der Arm hat zwei Gelenke: Beide sind Drehgelenke\./);
  assert.match(await page.getByLabel("Frage").first().textContent(), /Determinante der Jacobi-Matrix/);
  await page.getByRole("button", { name: "Hinweis 1 zeigen" }).click();
  assert.match(await page.locator(".hint").innerText(), /Die Determinante zeigt, in welchen Konfigurationen/);
  await page.getByLabel("Deine Antwort").fill(`-(${typed("determinant")})`);
  await page.getByRole("button", { name: "Prüfen" }).click();
  assert.match(await page.locator(".mistake").innerText(), /Determinante mit falschem Vorzeichen/);
  for (const place of [".prompt", ".statement", ".task h2", ".hint div", ".mistake span"])
    assert.equal(await page.locator(place).first().getAttribute("lang"), "de", place);
  await page.getByRole("button", { name: "Lösung zeigen" }).click();
  assert.equal(await page.locator(".solution div").first().getAttribute("lang"), "de");
  assert.match(await page.locator(".solution").innerText(), /Die Determinante hängt nicht von|keine Inverse/);
  await page.getByLabel("Deine Antwort").fill("2*(theta1");
  await page.getByRole("button", { name: "Prüfen" }).click();
  await page
    .locator(".verdict")
    .getByText(/am Ende fehlt „\)“/)
    .waitFor();
  assert.deepEqual(wrong, []);
});

test("without a translation, a problem is in English, and marked as English", async () => {
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=determinant");
  await context.route(/\/bank\/.*\.de\.json$/, (route) => route.fulfill({ status: 404 }));
  await page.getByLabel("Language").selectOption("de");
  await page.getByText("Die Texte dieser Aufgabe sind auf Englisch.").waitFor();
  assert.match(await page.locator(".prompt").innerText(), /^Find the determinant/);
  for (const place of [".prompt", ".statement", ".task h2"])
    assert.equal(await page.locator(place).first().getAttribute("lang"), "en", place);
  await context.close();
});

test("the next problem is shown from its beginning, also for keyboards", async () => {
  const { page } = await open("practice.html?arm=planar-2r&set=a");
  await page.getByText(/^Problem 1 of \d+ of the set “.+”$/).waitFor();
  await page.getByRole("button", { name: "Skip" }).click();
  await page.getByText(/^Problem 2 of \d+ of the set “.+”$/).waitFor();
  await page.waitForFunction(() => document.activeElement?.matches("article.task"));
});

test("Back returns to the question that was skipped, and what was typed is there after a reload and after Back", async () => {
  const { page, wrong } = await open("practice.html?arm=planar-2r&set=a");
  const item = () => page.locator(".task[data-item]").getAttribute("data-item");
  const shown = (other) =>
    page.waitForFunction(
      (other) => (document.querySelector(".task[data-item]")?.dataset.item ?? other) !== other,
      other,
    );
  const fields = page.locator("form .answer .formula-field");
  for (
    let last = "";
    (await shown(last), await fields.count()) === 0;
    await page.getByRole("button", { name: "Skip" }).click()
  )
    last = await item(); // its answer is a letter
  const first = await item();
  await fields.first().fill("a1*co");
  await page.reload();
  await shown("");
  assert.equal(await item(), first);
  assert.equal(await fields.first().inputValue(), "a1*co");
  await page.getByRole("button", { name: "Skip" }).click();
  await shown(first);
  const second = await item();
  await page.goBack();
  await shown(second);
  assert.equal(await item(), first);
  assert.equal(await fields.first().inputValue(), "a1*co");
  await page.goForward();
  await shown(first);
  assert.equal(await item(), second);
  assert.deepEqual(wrong, []);
});

test("without a connection, the page says so in words, and tries again", async () => {
  const { page, context, at } = await emptyTab(there);
  await context.route("**/bank/planar-2r/**", (route) => route.abort());
  await at("practice.html?arm=planar-2r&question=position");
  const alert = page.getByRole("alert");
  await alert.getByText("You seem to be offline").waitFor();
  assert.doesNotMatch(await alert.innerText(), /TypeError|fetch/);
  await context.unroute("**/bank/planar-2r/**");
  await alert.getByRole("button").click();
  await page.locator("form .answer").waitFor();
  await context.close();
});

test("a sheet is printed without the page's controls, with a key on its last page", async () => {
  const { page, wrong } = await open("practice.html?arm=planar-2r&set=a&sheet=3&key=1", { colorScheme: "dark" });
  await page.locator(".sheet-key li").nth(2).waitFor();
  assert.equal(await page.locator(".sheet-question").count(), 3);
  await page.emulateMedia({ media: "print" });
  for (const hidden of [".top", ".bottom", ".sheet-settings"])
    assert.equal(await page.locator(hidden).isVisible(), false, hidden);
  assert.ok(await page.locator(".sheet table").first().isVisible());
  assert.ok((await page.locator(".sheet-room, .sheet-lines").count()) >= 3);
  const begins = await page.locator(".sheet-key").evaluate((key) => getComputedStyle(key).breakBefore);
  assert.equal(begins, "page");
  const pdf = (await page.pdf({ format: "A4" })).toString("latin1");
  assert.ok(pdf.match(/\/Type \/Page\b/g).length >= 2);
  await page.emulateMedia({ media: null });
  await page.getByLabel("with an answer key on a separate page").uncheck();
  await page.locator(".sheet-key").waitFor({ state: "detached" });
  assert.deepEqual(wrong, []);
});

test("it works offline after the first visit", async () => {
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=position", {
    serviceWorkers: "allow",
  });
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.locator("form .answer").waitFor();
  await page.waitForFunction(() => navigator.serviceWorker.controller !== null);
  await page.reload();
  await page.locator("form .answer").waitFor();
  await context.setOffline(true);
  await page.reload();
  const { heading } = await answered(page, typed("position"));
  assert.equal(heading, "Right");
  await page.goto(`${there.server.root}/`);
  await page.getByRole("heading", { level: 1 }).waitFor();
  await context.close();
});

test("two tabs keep the progress of each other", async () => {
  const { context, at, page: first } = await emptyTab(there);
  await at("practice.html?arm=planar-2r&question=determinant");
  const second = await context.newPage();
  await second.goto(`${there.server.root}/practice.html?arm=planar-2r&question=position`);
  await second.locator("form .answer").waitFor();
  await answered(first, typed("determinant"));
  await answered(second, typed("position"));
  const stored = await first.evaluate(() => Object.keys(JSON.parse(localStorage.getItem("qdot-progress"))));
  assert.deepEqual(stored.sort(), ["planar-2r/001/determinant", "planar-2r/001/position"]);
  await context.close();
});

test("the chapter is named once a question, a hint or a solution with the number of an equation is shown", async () => {
  const numbers = () => page.locator("main").evaluate((main) => /\(6\.\d+\)(?! refer)/.test(main.innerText));
  const notes = () => page.getByText("equations in Chapter 6").count();
  let page;
  let found = 0;
  for (const question of ["jacobian", "determinant", "rank", "singular-angles", "inverse-velocity", "position"]) {
    ({ page } = await ask(question));
    const more = page.getByRole("button", { name: /^Show (hint|the solution)/ });
    for (;;) {
      const isNumbered = await numbers();
      assert.equal((await notes()) > 0, isNumbered, question);
      found += isNumbered;
      if ((await more.count()) === 0) break;
      await more.first().click();
      await drawn(page);
    }
  }
  assert.ok(found > 0);
});
