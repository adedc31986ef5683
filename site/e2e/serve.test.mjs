// A class online: students answer, lose their connection, submit notebooks; the staff see it and set points.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launched } from "../tools/browser.mjs";
import { assertAccessible, drawn } from "./opened.mjs";
import { openQuestion, RIGHT, signIn, startService, submit } from "./service.mjs";
import { assertReached } from "./walk.mjs";

let browser;
let service;
before(async () => {
  [browser, service] = [await launched(), await startService()];
});
after(async () => {
  await browser?.close();
  await service?.stop();
});

const field = (page) => page.getByLabel("Your answer");
/** Return the content of a file that the page offers for download; the browser may run on another machine. */
const read = async (download) => Buffer.concat(await (await download.createReadStream()).toArray());
const saved = (page) => page.getByText("Everything is saved.").waitFor();

test("a wrong answer gets its cause, a right one its points; both are there after a reload", async () => {
  const student = await signIn(browser, service, "s1");
  const page = await openQuestion(student, "determinant");
  await assertReached(page);
  await submit(page);
  await page.getByRole("alert").getByText("Type an answer first.").waitFor();
  await field(page).fill("a1*a2*cos(theta2)");
  await page.locator(".preview math").waitFor();
  await submit(page);
  await page.locator(".verdict.wrong, .verdict.partial").waitFor();
  await page.getByText("A configuration at which your answer is wrong").waitFor();
  await drawn(page);
  await assertAccessible(page);
  await field(page).fill(RIGHT.determinant);
  await field(page).press("Enter");
  await page.locator(".verdict.correct").waitFor();
  assert.match(await page.locator(".score").innerText(), /^Points: 1 of 7$/);
  await page.reload();
  await page.locator(".verdict.correct").waitFor();
  assert.equal(await field(page).inputValue(), RIGHT.determinant);
  await page.getByRole("button", { name: "Question 1.2: Right" }).waitFor();
  assert.deepEqual(student.wrong, []);
});

test("double clicks, two tabs, the same answer again and Back submit once", async () => {
  const student = await signIn(browser, service, "s2");
  const page = await openQuestion(student, "determinant");
  const other = await openQuestion(student, "determinant", await student.context.newPage());
  await field(page).fill(RIGHT.determinant);
  await field(other).fill(RIGHT.determinant);
  await page.getByRole("button", { name: "Submit", exact: true }).dblclick();
  await page.locator(".verdict.correct").waitFor();
  await other.locator(".verdict.correct").waitFor(); // it receives the result of the other tab
  await submit(other);
  await other.getByText("You have submitted this answer already.").waitFor();
  await page.getByRole("button", { name: "Next question" }).click();
  await page.locator('[data-item="p1.joint-effect"]').waitFor();
  await page.goBack();
  await page.locator('[data-item="p1.determinant"] .verdict.correct').waitFor();
  await page.goto("about:blank");
  await page.goBack();
  await page.locator('[data-item="p1.determinant"] .verdict.correct').waitFor();
  assert.equal((await student.work()).submissions.length, 1);
  assert.deepEqual(student.wrong, []);
});

test("a lost connection loses nothing that was typed or submitted, and the page says so", async () => {
  const student = await signIn(browser, service, "s3");
  const page = await openQuestion(student, "jacobian");
  const entries = page.locator(".grid input");
  await student.context.setOffline(true);
  await entries.nth(0).fill("-a1*sin(theta1)");
  await page.getByText("The server can't be reached. What you type is stored in this browser").waitFor();
  await page.getByRole("button", { name: "Next question" }).click();
  await page.locator('[data-item="p1.determinant"] form').waitFor();
  await field(page).fill(RIGHT.determinant);
  await submit(page);
  await page.getByText("This answer has not reached the server yet.").waitFor();
  await page.close(); // before anything has arrived
  await student.context.setOffline(false);
  const later = await openQuestion(student, "determinant", await student.context.newPage());
  await later.locator(".verdict.correct").waitFor();
  await saved(later);
  const elsewhere = await signIn(browser, service, "s3"); // on another machine
  const again = await openQuestion(elsewhere, "jacobian");
  assert.equal(await again.locator(".grid input").nth(0).inputValue(), "-a1*sin(theta1)");
  const work = await elsewhere.work();
  assert.deepEqual([work.submissions.length, work.results["p1.determinant"].outcome], [1, "correct"]);
});

test("a notebook is taken away, submitted, and graded; a file of another kind is refused in a sentence", async () => {
  const student = await signIn(browser, service, "s4");
  const page = await openQuestion(student, "jacobian");
  await page.getByText("Work in a notebook").click();
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("link", { name: "Download your notebook" }).click(),
  ]);
  const notebook = JSON.parse(await read(download));
  const cell = notebook.cells.find(({ id }) => id === "p1-determinant");
  cell.source = `p1_determinant = ${JSON.stringify(RIGHT.determinant)}`;
  const choose = (name, text) =>
    page.locator('input[type="file"]').setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
  await choose("essay.pdf", "%PDF-1.7");
  await page.locator(".notebook-work [role=alert]").waitFor();
  await choose("week-3.ipynb", JSON.stringify(notebook));
  await page.locator(".submissions").getByText("week-3.ipynb").waitFor();
  await page.locator(".submissions").getByText("Points: 1 of 7").waitFor({ timeout: 120_000 });
  await page.locator(".score").getByText("Points: 1 of 7", { exact: true }).waitFor(); // loaded after the list
  await page.getByRole("link", { name: "Feedback on all of your work" }).click();
  await page.getByRole("heading", { name: "Week 3: arms" }).waitFor();
});

test("an upload asks before it replaces answers, and the old answer can be submitted again after it", async () => {
  const student = await signIn(browser, service, "s4");
  const page = await openQuestion(student, "determinant");
  assert.equal(await field(page).inputValue(), RIGHT.determinant); // from the notebook
  await page.getByText("Work in a notebook").click();
  const upload = async (name, content) => {
    await page
      .locator('input[type="file"]')
      .setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(content) });
    await page.getByText("it replaces all your submitted answers").waitFor();
    await page.getByRole("button", { name: "Submit anyway" }).click();
  };
  await upload("broken.ipynb", '{"cells": [');
  await page.getByText("broken.ipynb is not a Jupyter notebook").waitFor();
  await page.locator(".verdict.correct").waitFor();
  const take = async () => {
    const link = page.getByRole("link", { name: "Download your notebook" });
    const [download] = await Promise.all([page.waitForEvent("download"), link.click()]);
    return JSON.parse(await read(download));
  };
  const notebook = await take();
  const cell = notebook.cells.find(({ id }) => id === "p1-determinant");
  assert.equal(cell.source, `p1_determinant = '${RIGHT.determinant}'`);
  cell.source = "p1_determinant = 'a1'";
  await upload("later.ipynb", JSON.stringify(notebook));
  await page.locator(".verdict.wrong, .verdict.partial").waitFor({ timeout: 120_000 });
  assert.equal(await field(page).inputValue(), "a1");
  await assertAccessible(page);
  await field(page).fill(RIGHT.determinant);
  await submit(page);
  await page.locator(".verdict.correct").waitFor();
  await field(page).fill("a1 + 1");
  await saved(page);
  await page.getByRole("button", { name: "Next question" }).click();
  await page.locator('[data-item="p1.joint-effect"]').waitFor();
  await page.goBack();
  await page.locator('[data-item="p1.determinant"] form').waitFor();
  assert.equal(await field(page).inputValue(), "a1 + 1"); // what was typed, though it is stored on the server only
});

test("the staff see the class, set points with a comment, mark a text by a key, and give more time", async () => {
  const student = await signIn(browser, service, "s1");
  const page = await openQuestion(student, "why");
  await field(page).fill("<b>Both</b> links are in line.");
  await submit(page);
  await page.getByText("Not graded yet").waitFor();
  const staff = await signIn(browser, service, "staff:Grace Hopper");
  const table = await staff.open("class/");
  await table.getByRole("rowheader", { name: "Ada Lovelace" }).waitFor();
  await assertReached(table);
  await assertAccessible(table);

  await table.getByRole("button", { name: /^To mark/ }).click();
  await table.getByText("<b>Both</b> links are in line.").waitFor();
  await assertAccessible(table);
  await table.keyboard.press("2");
  await table.getByText("Points: 2 of 3").waitFor();

  await table.getByRole("button", { name: "Students", exact: true }).click();
  await table.getByRole("button", { name: "Ada Lovelace" }).click();
  const determinant = table.locator(".answered", { has: table.getByRole("heading", { name: /Determinant/ }) });
  await determinant.getByLabel("Points (of 1)").fill("0,5");
  await determinant.getByLabel("Comment").fill("Show your work <i>next time</i>.");
  await determinant.getByRole("button", { name: "Save" }).click();
  await determinant.getByText("Points: 0.5 of 1").waitFor();
  await assertAccessible(table);
  await table.getByLabel("Due date of this student").fill("2020-01-01T12:00");
  await table.getByRole("button", { name: "Save" }).first().click();
  await table.getByRole("button", { name: "Remove the extension" }).waitFor();
  await table.getByRole("button", { name: "Changes by the staff" }).click();
  assert.equal(await table.locator(".record li").count(), 3);
  assert.deepEqual(staff.wrong, []);

  await openQuestion(student, "determinant");
  await page.getByText("Show your work <i>next time</i>.").waitFor();
  await page.getByText("Your work is late.").waitFor();
  assert.deepEqual(student.wrong, []);
});

test("the staff take the results away, and see what grading again would change", async () => {
  const staff = await signIn(browser, service, "staff:Grace Hopper");
  const page = await staff.open("class/");
  const [download] = await Promise.all([
    page.waitForEvent("download"),
    page.getByRole("link", { name: "Download all results" }).click(),
  ]);
  assert.equal((await read(download)).subarray(0, 2).toString(), "PK");
  await page.getByRole("button", { name: "Grade again" }).click();
  await page.getByText("Marks that would change: 0").waitFor();
  await page.getByLabel("Search").fill("noether");
  await page.getByText("1 of 4 students").waitFor();
  assert.deepEqual(staff.wrong, []);
});

test("in the frame of a platform, a page asks for room, and its arm and fields fit", async () => {
  const student = await signIn(browser, service, "s2");
  const { page } = student;
  const frame = `<!DOCTYPE html><title>Course</title><script>
    window.asked = [];
    addEventListener("message", ({ data }) => window.asked.push(data));
  </script><iframe style="width: 800px; height: 700px" src="/a/week-3/?part=p1.determinant"></iframe>`;
  await page.route(`${service.root}/course`, (route) => route.fulfill({ contentType: "text/html", body: frame }));
  await page.goto(`${service.root}/course`);
  const inside = page.frameLocator("iframe");
  await inside.locator(".arm-box").waitFor();
  await inside.getByRole("button", { name: "Submit", exact: true }).waitFor();
  const asked = await page.evaluate(() => window.asked);
  assert.equal(asked.length, 1);
  assert.deepEqual(Object.keys(asked[0]).sort(), ["height", "subject"]);
  assert.ok(asked[0].subject === "lti.frameResize" && asked[0].height > 400, JSON.stringify(asked));
  const wider = await inside.locator("html").evaluate((html) => html.scrollWidth - html.clientWidth);
  assert.ok(wider <= 0, `${wider} pixels wider than the frame`);
});

test("the pages are accessible on a phone, in the dark, in German", async () => {
  const options = { viewport: { width: 390, height: 844 }, colorScheme: "dark", locale: "de-DE" };
  const student = await signIn(browser, service, "s2", options);
  const page = await openQuestion(student, "joint-effect");
  await page.getByRole("button", { name: "Abgeben", exact: true }).waitFor();
  await drawn(page);
  await assertAccessible(page);
  const staff = await signIn(browser, service, "staff:Grace Hopper", options);
  const table = await staff.open("class/");
  await table.getByRole("rowheader", { name: "Ada Lovelace" }).waitFor();
  await assertAccessible(table);
  await table.getByRole("button", { name: "Gleiche falsche Antworten" }).click();
  await assertAccessible(table);
  await page.goto(`${service.root}/a/week-4/`);
  await page.getByRole("heading", { name: "Das kann nicht gezeigt werden" }).waitFor();
  await assertAccessible(page);
  assert.deepEqual(staff.wrong, []);
});
