// In a course: rounds in a frame that send messages to the surrounding page, wrong links, packages in a SCORM run-time
// (scorm-again) and on platforms that fail, and the page that makes links.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { served } from "../tools/browser.mjs";
import { assertAccessible, drawn, inChromium, opened, openedAnew, PHONE } from "./opened.mjs";

const there = inChromium();
const require = createRequire(import.meta.url);
const QDOT = process.env.QDOT ?? "qdot";
const VERSIONS = { 1.2: "scorm12", 2004: "scorm2004" };
const ASSIGNMENT = `title = "Week 3: <arms>"
key = "week-3"
feedback = "solutions"
hints = true
[[problem]]
family = "planar-2r"
questions = ["determinant", "joint-effect"]
points = [3, 1]
`;

/** Another server, because the pages of a platform or a course are not on the site's server. */
let course;

before(() => {
  const folder = mkdtempSync(join(tmpdir(), "qdot-course-"));
  const homework = join(folder, "hw");
  execFileSync(QDOT, ["init", homework], { stdio: "ignore" });
  writeFileSync(join(homework, "assignment.toml"), ASSIGNMENT);
  const asked = ["export", homework, "--to", "scorm", "--variants", "3", "--pass", "70", "--jobs", "1"];
  execFileSync(QDOT, asked, { stdio: "ignore" });
  for (const [version, name] of Object.entries(VERSIONS)) {
    const archive = join(homework, "exports", "scorm", `week-3-${name}.zip`);
    execFileSync("python3", ["-m", "zipfile", "-e", archive, join(folder, name)]);
    cpSync(require.resolve(`scorm-again/${name}/min`), join(folder, `${name}.js`));
    writeFileSync(join(folder, `${name}-lms.html`), platformPage(version, name));
  }
  writeFileSync(
    join(folder, "page.html"),
    "<!DOCTYPE html><title>A course</title><link rel='icon' href='data:,'><body></body>",
  );
  course = { folder };
});
before(async () => Object.assign(course, await served(course.folder)));
after(() => {
  course?.close?.();
  if (course) rmSync(course.folder, { recursive: true, force: true });
});

/** A platform's page: its run-time, then the package in a frame. It sends stored data to its address. */
function platformPage(version, name) {
  const [api, Class] = version === "1.2" ? ["API", "Scorm12API"] : ["API_1484_11", "Scorm2004API"];
  return `<!DOCTYPE html><title>Platform</title><link rel="icon" href="data:,"><script src="${name}.js"></script><script>
    const kept = JSON.parse(decodeURIComponent(location.hash.slice(1)) || "{}");
    const api = (window.${api} = new ${Class}({ autocommit: false, logLevel: 5 }));
    api.loadFromJSON(kept, "cmi");
    window.ended = 0;
    api.on("${version === "1.2" ? "LMSFinish" : "Terminate"}", () => (window.ended += 1));
  </script><iframe src="${name}/index.html" width="1200" height="860" title="package"></iframe>`;
}

/** Open a package of a SCORM version in its platform's page, with the data stored before. */
async function launched(version, kept) {
  const path = `${VERSIONS[version]}-lms.html#${encodeURIComponent(JSON.stringify(kept))}`;
  const { page, wrong, context } = await openedAnew({ ...there, server: course }, path);
  const frame = page.frameLocator("iframe");
  await frame.locator("form .answer").waitFor();
  return { page, frame, wrong, context };
}

const inner = (page) => page.frames()[1];
const valueOf = (page, version, name) =>
  page.evaluate(
    ([is12, name]) => (is12 ? window.API.LMSGetValue(name) : window.API_1484_11.GetValue(name)),
    [version === "1.2", name],
  );

/** Return the record in the package's bank of the arm that the page shows. */
async function solutionsOf(page, version) {
  const key = await inner(page).evaluate(
    () =>
      performance
        .getEntriesByType("resource")
        .map(({ name }) => /bank\/(p1\/p1-\d+)\.json/.exec(name)?.[1])
        .filter(Boolean)[0],
  );
  const bank = join(course.folder, VERSIONS[version], "bank");
  const load = (kind) => JSON.parse(readFileSync(join(bank, key, `${kind}.json`), "utf8"));
  return { key, typed: load("determinant").solved.typed, right: load("joint-effect").key.right[0] };
}

async function answered(frame, text) {
  await frame.getByLabel("Your answer").fill(text);
  await frame.getByRole("button", { name: "Check" }).click();
  await frame.locator(".verdict").waitFor();
}

for (const version of Object.keys(VERSIONS)) {
  const is12 = version === "1.2";
  const learner = is12 ? { core: { student_id: "ada" } } : { learner_id: "ada" };

  test(`SCORM ${version}: the platform gets scores, status, answers and time, and a round continues where it was`, async () => {
    const { page, frame, wrong, context } = await launched(version, learner);
    const { key, typed, right } = await solutionsOf(page, version);
    await frame.getByText("0 of 2 answered").waitFor();
    await frame.getByText("Your score is sent to your learning platform").waitFor();
    assert.equal(await frame.locator(".round-head strong").innerText(), "Week 3: <arms>");
    await answered(frame, "a1*");
    assert.match(await frame.locator(".round-tries").innerText(), /^3 of 3 tries/); // an answer that can't be parsed costs no try
    await answered(frame, `(${typed}) + a1`);
    await frame.locator(".round-tries", { hasText: /^2 of 3 tries/ }).waitFor();
    const said = await frame.locator(".verdict").innerText();
    assert.ok(/your value is/.test(said) && !/the right one/.test(said), `what is right, with tries left: ${said}`);
    await answered(frame, typed);
    await frame.getByText("3 of 4 points").waitFor();
    assert.equal(await valueOf(page, version, is12 ? "cmi.core.score.raw" : "cmi.score.scaled"), is12 ? "75" : "0.75");
    const status = is12 ? "cmi.core.lesson_status" : "cmi.completion_status";
    assert.equal(await valueOf(page, version, status), "incomplete");
    assert.equal(Number(await valueOf(page, version, "cmi.interactions._count")), 2);
    if (!is12) assert.match(await valueOf(page, version, "cmi.interactions.1.timestamp"), /^20.*Z$/);
    const kept = await valueOf(page, version, "cmi.suspend_data");
    await inner(page).goto("about:blank"); // leave the package
    await page.waitForFunction(() => window.ended === 1);
    assert.deepEqual(wrong, []);
    assert.deepEqual(await page.evaluate(() => window.refused), []);
    await context.close();

    const again = await launched(version, { ...learner, suspend_data: kept });
    assert.equal((await solutionsOf(again.page, version)).key, key);
    await again.frame.getByText("1 of 2 answered").waitFor();
    await again.frame.getByText("3 of 4 points").waitFor();
    await again.frame.locator('input[type="radio"]').nth(right).check();
    await again.frame.getByRole("button", { name: "Check" }).click();
    await again.frame.getByText("All questions are answered, and you passed (70 % needed).").waitFor();
    assert.equal(await valueOf(again.page, version, is12 ? status : "cmi.success_status"), "passed");
    const raw = await valueOf(again.page, version, is12 ? "cmi.core.score.raw" : "cmi.score.raw");
    assert.equal(raw, "100");
    if (!is12) assert.equal(await valueOf(again.page, version, status), "completed");
    assert.deepEqual(again.wrong, []);
    assert.deepEqual(await inner(again.page).evaluate(() => window.refused), []);
    await again.context.close();
  });
}

test("each student has other arms; after the last try the solution can be shown, and nothing more is earned", async () => {
  const keys = new Set();
  for (const id of ["ada", "ben", "eve", "ida", "max"]) {
    if (keys.size > 1) break;
    const { page, context } = await launched("2004", { learner_id: id });
    keys.add((await solutionsOf(page, "2004")).key);
    await context.close();
  }
  assert.ok(keys.size > 1, [...keys].join());
  const { page, frame, context } = await launched("1.2", { core: { student_id: "ada" } });
  for (const text of ["1", "2", "3"]) await answered(frame, text);
  await frame.getByText("0 of 3 tries left").waitFor();
  await frame.getByRole("button", { name: "Show the solution" }).click();
  await frame.locator(".solution").waitFor();
  await frame.getByLabel("Your answer").fill((await solutionsOf(page, "1.2")).typed);
  await frame.getByRole("button", { name: "Check" }).click({ force: true });
  await frame.getByText("0 of 4 points").waitFor();
  assert.equal(await valueOf(page, "1.2", "cmi.core.score.raw"), "0");
  await context.close();
});

test("practice works if the platform accepts nothing, or fails at the end", async () => {
  const { page, wrong, context } = await openedAnew({ ...there, server: course }, "page.html");
  await page.evaluate(() => {
    const refuse = () => "false";
    const fail = () => {
      throw new Error("down");
    };
    window.API = { LMSInitialize: () => "true", LMSGetValue: () => "", LMSSetValue: refuse, LMSCommit: refuse };
    window.API.LMSFinish = fail;
    document.body.innerHTML = '<iframe src="scorm12/index.html" width="1000" height="800"></iframe>';
  });
  const frame = page.frameLocator("iframe");
  await frame.getByText("Your platform didn't accept the score.").waitFor();
  await frame.locator("form .answer").waitFor();
  await answered(frame, "1");
  await page.evaluate(() => {
    window.told = {};
    window.API.LMSSetValue = (name, value) => ((window.told[name] = value), "true");
    window.API.LMSCommit = () => "true";
  });
  await frame.getByRole("button", { name: "Send it now" }).click();
  await frame.getByText("Your score is sent to your learning platform").waitFor();
  assert.equal(await page.evaluate(() => window.told["cmi.core.lesson_status"]), "incomplete");
  await inner(page).goto("about:blank");
  assert.deepEqual(wrong, []);
  await context.close();
});

test("a package without a platform says so, works, and is stored in the browser", async () => {
  const { page, context } = await openedAnew({ ...there, server: course }, "scorm2004/index.html");
  await page.getByText("This page is not running inside a learning platform").waitFor();
  await page.locator("form .answer").waitFor();
  await answered(page, "1");
  await page.getByText("1 of 2 answered").waitFor();
  await page.reload();
  await page.getByText("1 of 2 answered").waitFor();
  await page.locator("form .answer").waitFor();
  await assertAccessible(page);
  await context.close();
});

/** Open a course's page at another address, with a round in a frame; `told` has the messages that it receives. */
async function withFraming(search) {
  const { page, context } = await openedAnew({ ...there, server: course }, "page.html");
  await page.evaluate((address) => {
    window.told = [];
    window.addEventListener("message", ({ data, origin }) => window.told.push({ ...data, origin }));
    document.body.innerHTML = `<iframe src="${address}" width="1000" height="800"></iframe>`;
  }, `${there.server.root}/practice.html?${search}`);
  return { page, frame: page.frameLocator("iframe"), context };
}

test("a round in a frame has no header, and sends results to the origin in its link", async () => {
  const origin = encodeURIComponent(course.root);
  const search = `embed=1&arm=planar-2r&question=determinant&n=1&seed=a&name=Week+3&origin=${origin}`;
  const { page, frame, context } = await withFraming(search);
  await frame.getByText(`Your score is sent to ${course.root}`).waitFor();
  assert.equal(await frame.locator("header.top").isVisible(), false);
  await frame.locator("form .answer").waitFor();
  await answered(frame, "1");
  await page.waitForFunction(() => window.told.length === 2);
  const [first, second] = await page.evaluate(() => window.told);
  assert.deepEqual([first.event, first.name, first.seed, first.answer], ["opened", "Week 3", "a", null]);
  assert.equal(second.event, "completed");
  assert.equal(second.origin, there.server.root);
  assert.deepEqual(second.score, { points: 0, max: 1, scaled: 0, answered: 1, count: 1 });
  assert.equal(second.answer.typed, "1");
  await page.reload();
  await context.close();
});

for (const [width, height] of [
  [900, 900],
  [800, 900],
  [640, 900],
  [600, 900],
  [480, 800],
  [390, 700],
]) {
  test(`in a frame of ${width} × ${height} pixels, the arm and the answer field are visible`, async () => {
    const { page } = await opened(there, "practice.html?embed=1&arm=planar-2r&question=determinant&seed=a&n=1", {
      viewport: { width, height },
    });
    await page.locator(".arm-box").waitFor();
    await drawn(page);
    const [box, answer] = await page.evaluate(() =>
      [".arm-box", ".answer"].map((selector) => {
        const place = document.querySelector(selector);
        const { left, right, top, bottom } = (
          place.matches(".answer") ? place.querySelector("input") : place
        ).getBoundingClientRect();
        return { left, right, top, bottom };
      }),
    );
    for (const { top, bottom } of [box, answer]) assert.ok(top >= 0 && bottom <= height, JSON.stringify([box, answer]));
    assert.ok(box.bottom < answer.top || box.right < answer.left, "one lies over the other");
    assert.ok(box.bottom - box.top > 130 && box.right - box.left > 250, JSON.stringify(box));
  });
}

test("a page of another origin receives nothing", async () => {
  for (const search of ["embed=1&n=1&seed=a", "embed=1&n=1&seed=a&origin=https%3A%2F%2Felsewhere.example"]) {
    const { page, frame, context } = await withFraming(search);
    await frame.locator("form .answer").waitFor();
    await drawn(page);
    assert.deepEqual(await page.evaluate(() => window.told), []);
    await context.close();
  }
});

test("the same seed asks the same questions, in German if the link says so; errors in a link are reported", async () => {
  const titles = [];
  for (const seed of ["a", "a", "b"]) {
    const { page } = await opened(there, `practice.html?seed=${seed}&n=9&name=R`);
    await page.locator("form .answer").waitFor();
    titles.push(await page.locator(".task h2").innerText());
    assert.equal(await page.locator("header.top").isVisible(), true);
  }
  assert.equal(titles[0], titles[1]);
  const { page: german } = await opened(there, "practice.html?embed=1&seed=a&n=2&lang=de");
  await german.getByText("0 von 2 beantwortet").waitFor();
  for (const [search, said] of [
    ["embed=1&lession=rates", /The link contains an unknown setting, “lession”. The known settings are embed, lesson/],
    ["seed=a&n=0", /The link contains n=0; n must be a whole number from 1 to 100/],
    ["seed=a&n=99", /The link asks for 99 questions, but only \d+ match/],
    ["seed=a&lesson=foo", /The link asks for the lesson “foo”, which doesn't exist. Choose one of rates, columns/],
    ["seed=a&arm=foo", /asks for the arm “foo”, which doesn't exist here/],
  ]) {
    const { page } = await opened(there, `practice.html?${search}`);
    await page.getByText(said).waitFor();
    await page.getByRole("heading", { name: "Something is wrong with this link" }).waitFor();
  }
});

test("links are made by menus, with a preview that shows what is sent", async () => {
  for (const options of [undefined, PHONE]) {
    const { page, wrong } = await opened(there, "course.html", options);
    await page.getByRole("combobox", { name: "Question", exact: true }).selectOption("determinant");
    await page.getByLabel("Title for students").fill('Ada\'s "week"');
    await page.getByLabel("How many questions").fill("99");
    await page.getByLabel("How many questions").blur();
    await page
      .getByLabel("Address of the site that embeds this page, such as https://moodle.example.org")
      .fill("moodle");
    await page.getByText("“moodle” is not the address of a site").waitFor();
    await page
      .getByLabel("Address of the site that embeds this page, such as https://moodle.example.org")
      .fill("https://moodle.example.org");
    const link = await page.getByLabel("A link", { exact: true }).inputValue();
    const code = await page.getByLabel("HTML to embed in a page of your course").inputValue();
    assert.match(link, /^http:\/\/127.0.0.1:\d+\/practice\.html\?question=determinant&n=1&seed=\w+&name=Ada/);
    const frame = page.frameLocator(".maker-preview");
    await frame.locator(".round-head strong", { hasText: 'Ada\'s "week"' }).waitFor();
    await frame.locator("form .answer").waitFor();
    await page.getByText("What the surrounding page receives").click();
    await page.getByText('"event": "opened"').waitFor();
    await assertAccessible(page);
    await page.setContent(code);
    const made = await page.locator("iframe").getAttribute("src");
    assert.equal(new URL(made).searchParams.get("name"), 'Ada\'s "week"');
    assert.equal(new URL(made).searchParams.get("origin"), "https://moodle.example.org");
    assert.deepEqual(wrong, []);
    await page.goto(link);
    await page.locator("form .answer").waitFor();
  }
});

test("a round is accessible on a phone, and each question can be opened", async () => {
  const { page, wrong, context } = await openedAnew(there, "practice.html?embed=1&seed=a&n=5", PHONE);
  await page.locator("form .answer").waitFor();
  await page.getByRole("button", { name: "Question 3: not answered yet" }).tap();
  assert.equal(await page.locator('.round-places [aria-current="true"]').innerText(), "3");
  await assertAccessible(page);
  assert.deepEqual(wrong, []);
  await context.close();
});
