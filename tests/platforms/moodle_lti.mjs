// Register qdot with Moodle, add it to a course as its teacher, and work with it as three students, in Chromium. After each
// step, Moodle's gradebook must show the score that qdot shows. Reads a request of moodle_lti.py as JSON on standard input,
// and prints the checks: name, whether it passed, details.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { launched } from "../../site/tools/browser.mjs";

const request = JSON.parse(readFileSync(0, "utf8"));
const { root, tool, key, course, people } = request;
const checks = [];
const check = (name, passed, details = "") => checks.push([name, Boolean(passed), String(details)]);

/** Call moodle_lti.php. */
function callMoodle(action, more = {}) {
  const input = JSON.stringify({ config: request.config, action, ...more });
  const script = new URL("moodle_lti.php", import.meta.url).pathname;
  const output = execFileSync("php", ["-d", "max_input_vars=5000", script], { input, encoding: "utf8" });
  return JSON.parse(output.slice(output.indexOf("{")));
}

async function logIn(browser, { username, password }) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 1100 } });
  const page = await context.newPage();
  page.setDefaultTimeout(30000);
  await page.goto(`${root}/login/index.php`);
  await page.locator("#username").fill(username);
  await page.locator("#password").fill(password);
  await page.locator("#loginbtn").click();
  await page.waitForURL((url) => !url.pathname.includes("/login/"));
  return page;
}

const takePicture = (page, name) =>
  request.pictures ? page.screenshot({ path: join(request.pictures, `${name}.png`) }) : undefined;

/** Wait for the frame that shows a page of qdot. */
async function waitForFrame(page, matches) {
  for (let tries = 0; tries < 120; tries += 1) {
    const frame = page.frames().find((other) => other.url().startsWith(tool) && matches(new URL(other.url())));
    if (frame) {
      await frame.waitForLoadState("domcontentloaded");
      return frame;
    }
    await page.waitForTimeout(500);
  }
  throw new Error(`no such page of qdot; frames: ${page.frames().map((frame) => frame.url())}`);
}

/** Call an address of qdot from a page of qdot, as its scripts do. */
const call = (frame, method, path, content) =>
  frame.evaluate(
    async ([method, path, content]) => {
      const token = document.querySelector('meta[name="csrf"]').content;
      const headers = { "Content-Type": "application/json", "X-CSRFToken": token };
      const body = content === null ? undefined : JSON.stringify(content);
      const answer = await fetch(path, { method, headers, body });
      const text = await answer.text();
      return { status: answer.status, ...(text.startsWith("{") ? JSON.parse(text) : {}) };
    },
    [method, path, content ?? null],
  );

/** Wait until Moodle's gradebook shows a mark; return the seconds, or null and what it shows. */
async function waitForMark(activity, student, expected) {
  const start = Date.now();
  let shown;
  while (Date.now() - start < 60000) {
    shown = callMoodle("list marks", { course }).marks[`${activity} ${student}`];
    if (shown !== undefined && Math.abs(Number(shown) - expected) < 1e-4)
      return { seconds: (Date.now() - start) / 1000 };
    await new Promise((done) => setTimeout(done, 300));
  }
  return { seconds: null, shown };
}

async function checkMark(name, activity, student, expected) {
  const { seconds, shown } = await waitForMark(activity, student, expected);
  check(name, seconds !== null, `${activity}, ${student}: ${expected} after ${seconds} s, else ${shown}`);
  return seconds;
}

/** Let Moodle's administrator register qdot from its address. */
async function register(browser) {
  const page = await logIn(browser, request.admin);
  await page.goto(`${root}/admin/search.php`);
  const sesskey = await page.evaluate(() => window.M.cfg.sesskey);
  const query = new URLSearchParams({ url: request.registration, type: "0", sesskey });
  const answer = await page.goto(`${root}/mod/lti/startltiadvregistration.php?${query}`);
  check("registered", answer.status() === 200, `${answer.status()}: ${await page.locator("body").innerText()}`);
  const again = await page.goto(request.registration);
  check("registered", again.status() === 404, `a second time: ${again.status()}`);
  await page.context().close();
  return callMoodle("activate tool").tool;
}

/** Let the teacher choose what an activity opens, in Moodle's editor; return the number of the activity. */
async function addActivity(page, number, choice) {
  await page.goto(`${root}/course/modedit.php?add=lti&type=&course=${course}&section=0&return=0&typeid=${number}`);
  await page.locator("[name=selectcontent]").click();
  const frame = await waitForFrame(page, (url) => url.pathname === "/lti/choose");
  const radio = frame.locator(`input[name=choice][value="${choice}"]`);
  if (choice.includes("/")) await frame.locator("details summary").first().click();
  await radio.check();
  await takePicture(page, `choose-${choice.replace("/", "-")}`);
  await frame.locator("form.choose button[type=submit]").click();
  await page.waitForFunction(() => document.querySelector("#id_name")?.value);
  const title = await page.locator("#id_name").inputValue();
  await takePicture(page, `chosen-${choice.replace("/", "-")}`);
  await page.locator("#id_submitbutton").click();
  await page.waitForURL(/mod\/lti\/view\.php/);
  return { id: new URL(page.url()).searchParams.get("id"), title };
}

const open = async (page, activity, matches) => {
  await page.goto(`${root}/mod/lti/view.php?id=${activity.id}`);
  return waitForFrame(page, matches);
};
const isWork = (url) => url.pathname === `/a/${key}/`;

const browser = await launched();
const number = request.registration ? await register(browser) : request.number;
check("registered", number > 0, number);

const teacher = await logIn(browser, people.grace);
const whole = await addActivity(teacher, number, key);
const one = await addActivity(teacher, number, `${key}/p1.jacobian`);
const highest = callMoodle("list marks", { course }).highest;
check("linked", Number(highest[whole.title]) === 4 && Number(highest[one.title]) === 2, JSON.stringify(highest));
let staff = await open(teacher, whole, (url) => url.pathname === `/a/${key}/class/`);
await staff.locator("table").waitFor();
check("launched", (await staff.locator("h1").innerText()) === "Velocity kinematics", "the teacher");
await teacher.waitForTimeout(3000); // the class list is read
const results = async () => call(staff, "GET", `/a/${key}/class/results`);
const listed = (await results()).students;
check("class list", listed.length === 3, JSON.stringify(listed));
const find = (name) => listed.find((student) => student.name.startsWith(name));
check("class list", find("Ada")?.student_id === "ada" && find("Cy")?.student_id === "cy", JSON.stringify(listed));

const extension = { student: find("Cy").id, due: new Date(Date.now() + 86400000).toISOString() };
check("launched", (await call(staff, "POST", `/a/${key}/class/extensions`, extension)).status === 200, "an extension");
await takePicture(teacher, "class");

// Ada types her answers, first a wrong one; each verdict changes her mark in Moodle. She is late and loses half.
const ada = await logIn(browser, people.ada);
let frame = await open(ada, whole, isWork);
check("launched", isWork(new URL(frame.url())), "ada");
const answer = async (inFrame, part, text) => {
  const reply = await call(inFrame, "POST", `/a/${key}/answers`, { request: crypto.randomUUID(), part, text });
  return { ...reply, outcome: reply.results?.[part]?.outcome };
};
const seconds = [];
await ada.waitForTimeout(1000);
await takePicture(ada, "student");
const wrong = await answer(frame, "p1.position", "[1, 2]");
check("answered", wrong.outcome === "wrong" && wrong.score === 0, JSON.stringify(wrong));
seconds.push(await checkMark("in the gradebook", whole.title, "ada", 0));
let score = 0;
for (const [part, text] of Object.entries(request.answers)) {
  const reply = await answer(frame, part, text);
  check("answered", reply.outcome === "correct" && reply.score > score, `${part}: ${JSON.stringify(reply)}`);
  score = reply.score;
  seconds.push(await checkMark("in the gradebook", whole.title, "ada", score));
}
check("answered", score === 2, `late: ${score} of 4`);
frame = await open(ada, one, isWork);
check("launched", new URL(frame.url()).searchParams.get("part") === "p1.jacobian", frame.url());
await checkMark("in the gradebook", one.title, "ada", 1);

// Bo uploads a notebook.
const bo = await logIn(browser, people.bo);
frame = await open(bo, whole, isWork);
const uploaded = await frame.evaluate(
  async ([key, text]) => {
    const form = new FormData();
    form.set("request", crypto.randomUUID());
    form.set("file", new File([text], "velocity.ipynb"));
    const headers = { "X-CSRFToken": document.querySelector('meta[name="csrf"]').content };
    return (await fetch(`/a/${key}/notebooks`, { method: "POST", headers, body: form })).status;
  },
  [key, request.notebook],
);
check("answered", uploaded === 202, uploaded);
await checkMark("in the gradebook", whole.title, "bo", 2);

// Cy has an extension, so the same work isn't late. Arms differ, so that only the teacher's points are known.
const cy = await logIn(browser, people.cy);
frame = await open(cy, whole, isWork);
const tried = await answer(frame, "p1.position", "[0, 0]");
check("answered", tried.status === 200 && tried.is_late === false, JSON.stringify(tried));
await checkMark("in the gradebook", whole.title, "cy", tried.score);

// The teacher sets points, changes them, and takes them back.
const override = async (student, part, points) => {
  const row = { student: find(student).id, part, points, comment: "" };
  const reply = await call(staff, "POST", `/a/${key}/class/overrides`, row);
  check("overridden", reply.status === 200, JSON.stringify(reply));
};
await override("Cy", "", 3.5);
await checkMark("overridden", whole.title, "cy", 3.5);
await override("Ada", "", 4);
await checkMark("overridden", whole.title, "ada", 4);
await override("Ada", "", 1);
await checkMark("overridden", whole.title, "ada", 1);
await override("Ada", "", null);
await checkMark("overridden", whole.title, "ada", score);

// Another student of the course reads no page of the staff; a student who launches again is the same person.
const refused = await call(frame, "GET", `/a/${key}/class/results`);
check("launched", refused.status === 404, `staff page for a student: ${refused.status}`);
frame = await open(ada, whole, isWork);
const again = await call(frame, "GET", `/a/${key}/work`);
check("launched", again.student.id === "ada" && again.score === score, JSON.stringify(again.student));
await takePicture(ada, "student-again");
await teacher.goto(`${root}/grade/report/grader/index.php?id=${course}`);
await teacher.locator("#user-grades").waitFor();
await takePicture(teacher, "gradebook");
console.error(`seconds until Moodle had the mark: ${seconds.map((value) => value?.toFixed(1)).join(", ")}`);
console.log(JSON.stringify(checks));
await browser.close();
