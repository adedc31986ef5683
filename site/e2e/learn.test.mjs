// The lessons in the browser: goals, a wrong link, reviews on the practice page, and the first page. lessons.test.mjs
// completes lessons up to mastery.
import assert from "node:assert/strict";
import { test } from "node:test";

import { drawn, inChromium, opened, openedAnew, PHONE, WIDE } from "./opened.mjs";
import { bankOf } from "./site.mjs";

const there = inChromium();
/** Return the right answer to a question about the site's only arm, as a student types it. */
const typed = (kind) => {
  const { bank } = bankOf(there.site.folder);
  const [{ problems }] = bank("index").families;
  const { key } = problems.find(({ questions }) => questions.includes(kind));
  return bank(`planar-2r/${key}/${kind}`).solved.typed;
};

test("the first path reaches no goal; a changed one does", async () => {
  const { page } = await opened(there, "learn.html?lesson=path", WIDE);
  await page.locator(".arm-chart").waitFor();
  await drawn(page);
  await page.waitForTimeout(300);
  assert.equal(await page.locator(".goals li.reached").count(), 0);
  await page.getByRole("button", { name: "Set it up" }).click();
  await page.getByLabel("Speed of P").fill("3");
  await page.getByLabel("Speed of P").press("Enter");
  await page.locator(".goals li.reached").first().waitFor();
});

test("a prediction comes back once its goal is reached, then the explanation opens, and guided steps follow", async () => {
  const { page, context } = await openedAnew(there, "learn.html?lesson=links", WIDE);
  await page.getByLabel("Not at all").check();
  await page.getByText("Now try it below.").waitFor();
  assert.equal(await page.locator(".explanation[open]").count(), 0);
  const turn = (joint, rate) => page.getByLabel(`Rate of joint angle ${joint}`).fill(String(rate));
  await turn("θ1", 0.5);
  await turn("θ2", -0.5);
  await page.getByText("You said “Not at all”.").waitFor();
  assert.ok(await page.getByLabel("Not at all").isDisabled());
  await page.reload();
  await page.getByText("You said “Not at all”.").waitFor();
  await turn("θ2", 0.5);
  await page.locator(".goals li.reached").nth(1).waitFor();
  for (const [joint, angle] of [
    ["θ1", 0],
    ["θ2", 0],
  ]) {
    const field = page
      .getByRole("spinbutton", { name: joint })
      .or(page.getByRole("textbox", { name: joint }))
      .first();
    await field.fill(String(angle));
    await field.press("Enter");
  }
  await turn("θ1", 1);
  await turn("θ2", 0.15);
  await page.locator(".goals li.reached").nth(2).waitFor();
  await page.locator(".explanation[open] .sketch svg").waitFor();
  if (process.env.SHOTS) await page.screenshot({ path: `${process.env.SHOTS}/lesson.png`, fullPage: true });
  await page.getByRole("button", { name: "Now practise it" }).click();
  await page.getByText(/^Step 1 of \d$/).waitFor();
  await page.getByRole("button", { name: "Skip these steps" }).click();
  await page.getByText(/0 of \d right in a row, at the first try/).waitFor();
  await context.close();
});

test("the words of a lesson wait neither for the arm nor for the questions", async () => {
  const { page } = await opened(there, "learn.html?lesson=rates", PHONE);
  const source = await page.evaluate(() => fetch("learn.html").then((answer) => answer.text()));
  assert.match(source, /assets\/learn-/);
  assert.doesNotMatch(source, /assets\/(panel|current|question)-/);
  const [place, dials] = [await page.locator(".tool").boundingBox(), await page.locator(".dials").boundingBox()];
  assert.ok(Math.abs(place.height - dials.height) < 40, `${place.height} pixels for ${dials.height}`); // goals don't jump
});

test("the first lesson shows nothing of J, and that on singularities the area of its columns", async () => {
  const { page } = await opened(there, "learn.html?lesson=rates", WIDE);
  await page.locator(".arm-joints").waitFor();
  for (const what of [".arm-jacobian", ".arm-factors", ".arm-tabs button"])
    assert.equal(await page.locator(what).count(), 0, what);
  assert.equal(await page.getByLabel("vectors p*").count(), 0); // another lesson explains them
  assert.equal(await page.locator(".explanation math").count(), 0); // nothing is typeset that is not seen
  await page.locator(".explanation summary").click();
  await page.locator(".sketch .arm-sum").waitFor(); // the arrows of the lesson, not the columns of J
  assert.ok((await page.locator(".explanation .whole", { hasText: /\.$/ }).count()) > 0); // no line begins with a full stop
  await opened(there, "learn.html?lesson=singular", WIDE);
  const area = page.locator(".arm-box polygon.arm-ellipse");
  const size = () =>
    area.evaluate(({ points: [p, first, , second] }) =>
      Math.abs((first.x - p.x) * (second.y - p.y) - (first.y - p.y) * (second.x - p.x)),
    );
  assert.ok((await size()) > 100);
  await page.getByRole("slider", { name: "Joint angle θ2" }).fill("0");
  await page.locator(".goals li.reached").first().waitFor();
  assert.ok((await size()) < 1);
});

test("in a lesson, what was typed is there after a reload, and Back returns to the step and the idea before", async () => {
  const { page, context } = await openedAnew(there, "learn.html?lesson=singular", WIDE);
  const answer = () => page.getByLabel("Your answer");
  await page.getByRole("button", { name: "Go straight to practice" }).click();
  await page.getByText("Step 1 of 3", { exact: true }).waitFor();
  await answer().fill("a1*co");
  await page.reload();
  await page.getByText("Step 1 of 3", { exact: true }).waitFor();
  assert.equal(await answer().inputValue(), "a1*co");
  await page.getByRole("button", { name: "Skip", exact: true }).click();
  await page.getByText("Step 2 of 3", { exact: true }).waitFor();
  await page.getByRole("button", { name: "Skip these steps" }).click();
  await page.getByText(/0 of \d right in a row, at the first try/).waitFor();
  await page.goBack();
  await page.getByText("Step 2 of 3", { exact: true }).waitFor();
  await page.goBack();
  await page.getByText("Step 1 of 3", { exact: true }).waitFor();
  assert.equal(await answer().inputValue(), "a1*co");
  await page.goBack();
  await page.getByRole("button", { name: "Go straight to practice" }).waitFor();
  await context.close();
});

test("the link to the arm's table keeps what was typed, and the feedback", async () => {
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=determinant", WIDE);
  await page.getByLabel("Your answer").fill("a1*a2");
  await page.getByRole("link", { name: "The arm's table" }).click();
  await page.waitForURL(/#given$/);
  await page.getByRole("button", { name: "Check" }).click();
  await page.locator(".verdict.wrong").waitFor();
  assert.equal(await page.getByLabel("Your answer").inputValue(), "a1*a2");
  await context.close();
});

test("a wrong answer after a right one to the same question ends no streak", async () => {
  const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=determinant", WIDE);
  const answer = async (text) => {
    await page.getByLabel("Your answer").fill(text);
    await page.getByRole("button", { name: "Check" }).click();
  };
  const row = () => page.evaluate(() => JSON.parse(localStorage.getItem("qdot-lessons") ?? "{}").singular?.row.length);
  await answer(typed("determinant"));
  await page.locator(".verdict.correct").waitFor();
  assert.equal(await row(), 1);
  await answer("a1*a2");
  await page.locator(".verdict.wrong").waitFor();
  assert.equal(await row(), 1);
  await context.close();
});

for (const [name, options] of Object.entries({ "on a wide page": WIDE, "on a phone": PHONE }))
  test(`det J and its map are hidden until singular angles are right: ${name}`, async () => {
    const { page, context } = await openedAnew(there, "practice.html?arm=planar-2r&question=singular-angles", options);
    const open = async (tab) => {
      const button = page.getByRole("button", { name: tab, exact: true });
      if ((await button.count()) > 0 && (await button.getAttribute("aria-expanded")) === "false") await button.click();
    };
    const shown = page.locator(".arm-map-frame, .arm-factors, .arm-readout");
    const check = async (answer) => {
      await page.getByLabel("Your answer").fill(answer);
      await page.getByRole("button", { name: "Check" }).click();
    };
    for (const answer of [null, "theta2 = pi"]) {
      if (answer) await check(answer);
      if (answer) await page.locator(".verdict.partial, .verdict.wrong").waitFor();
      await open("J");
      assert.equal(await shown.count(), 0);
      await open("Map");
      await page.getByText("They appear once your answer is right.").waitFor();
      assert.equal(await shown.count(), 0);
      assert.doesNotMatch(await page.locator(".arm").innerText(), /det J =|Singular/);
    }
    assert.ok(!(await page.locator(".prompt").textContent()).includes("Eq(")); // the syntax of a notebook
    await check("theta2 = 0, theta2 = pi");
    await page.locator(".arm-map-frame").waitFor();
    await open("J");
    await page.locator(".arm-factors").waitFor();
    await context.close();
  });

test("a link to an unknown lesson is reported", async () => {
  const { page } = await opened(there, "learn.html?lesson=foo");
  await page.getByText("There is no lesson “foo”").waitFor();
  assert.equal(await page.locator(".skill-map .skill").count(), 12);
});

test("due questions come first on the practice page, in their order", async () => {
  const { page, context } = await openedAnew(there, "practice.html", WIDE);
  await page.evaluate(() =>
    localStorage.setItem(
      "qdot-progress",
      JSON.stringify({
        "planar-2r/001/position": { right: false, missed: true, box: 0, due: 2 },
        "planar-2r/001/determinant": { right: false, missed: true, box: 0, due: 1 },
        "planar-2r/001/jacobian": { right: true, missed: true, box: 1, due: 4e12 },
      }),
    ),
  );
  await page.reload();
  await page.getByText("2 to review, about 3 minutes").waitFor();
  await page.getByRole("button", { name: "Answer them now" }).click();
  await page.getByRole("heading", { name: /^Determinant/ }).waitFor();
  await page.getByLabel("Your answer").fill(typed("determinant"));
  await page.getByRole("button", { name: "Check" }).click();
  await page.getByText("1 left to review.").waitFor();
  await page.getByRole("button", { name: "Next problem" }).click();
  await page.getByRole("heading", { name: /^Position/ }).waitFor();
  await context.close();
});

test("errors in a link are reported, and a set has ten problems", async () => {
  for (const [search, text] of [
    ["arm=foo", /asks for the arm “foo”, which doesn't exist here. Choose one of planar-2r/],
    ["question=foo", /asks for the question “foo”/],
    ["variation=foo", /Choose one of chapter/],
    ["difficulty=9", /it must be from 0 to 4/],
  ]) {
    const { page } = await opened(there, `practice.html?${search}`);
    await page.getByText(text).waitFor();
  }
  const none = (await opened(there, "practice.html?question=determinant&difficulty=4")).page;
  const found = await none.getByRole("alert").boundingBox();
  assert.ok(found.x < 500, `beside the room of an arm that is not there: ${found.x}`);
  await none.getByRole("button", { name: "Practise this question" }).click();
  await none.getByRole("heading", { name: "Determinant of the Jacobian" }).waitFor();
  const { page } = await opened(there, "practice.html?set=abc");
  await page.getByText("Problem 1 of 10 of the set").waitFor();
});

test("in a German browser examples, their list, the gallery and the documentation's titles are German", async () => {
  for (const [path, text] of [
    ["examples/6-2.html", /Beispiel 6\.2: inverse Geschwindigkeit/],
    ["examples/index.html", /enthält das gedruckte Kapitel einen Fehler/],
    ["arms.html", /Ebener 2R-Arm/],
    ["docs/index.html", /Wie eine Antwort beurteilt wird/],
  ]) {
    const { page, wrong } = await opened(there, path, { ...WIDE, locale: "de-DE" });
    await page.locator("main").getByText(text).first().waitFor();
    assert.equal(await page.locator("html").getAttribute("lang"), "de");
    if (path.endsWith("6-2.html")) {
      await page.waitForFunction(() => document.title.startsWith("Beispiel 6.2"));
      await page.locator(".live .arm-box").waitFor(); // the arm can be moved there, too
      assert.equal(await page.locator("main").getAttribute("lang"), "de");
    }
    assert.deepEqual(wrong, []);
  }
});

test("the first page shows an arm at once, which keys move to its singularity", async () => {
  const small = (await opened(there, "index.html", { viewport: { width: 360, height: 900 } })).page;
  const { y } = await small.locator(".arm-box").boundingBox();
  assert.ok(y < 600, `the arm begins at ${y}`);
  const { page } = await opened(there, "index.html");
  await page.locator(".arm-box").focus();
  await page.keyboard.press("2");
  for (let i = 0; i < 11; i += 1) await page.keyboard.press("Shift+ArrowLeft");
  for (let i = 0; i < 11 && !(await page.locator(".arm-vanishing").count()); i += 1)
    await page.keyboard.press("ArrowRight");
  await page.locator(".arm-vanishing").waitFor();
});

for (const [width, height] of [
  [390, 844],
  [1440, 900],
])
  test(`the arm of the first page fills its box, where it can be pulled straight out: ${width} x ${height}`, async () => {
    const { page } = await opened(there, "index.html", { viewport: { width, height } });
    const box = await page.locator(".arm-box").boundingBox();
    const middleOf = async (place) => {
      const { x, y, width, height } = await page.locator(place).first().boundingBox();
      return [x + width / 2, y + height / 2];
    };
    await page.locator(".arm-box .arm-point-ring").waitFor();
    const [P, base] = [await middleOf(".arm-point-ring"), await middleOf(".arm-joint-dot")];
    const size = Math.hypot(P[0] - base[0], P[1] - base[1]);
    assert.ok(size > 0.4 * Math.min(box.width, box.height), `from the base to P: ${size} of ${JSON.stringify(box)}`);
    const [across, up] = [(P[0] - base[0]) / size, (P[1] - base[1]) / size];
    await page.mouse.move(...P);
    await page.mouse.down();
    for (let step = 1; step <= 20; step += 1)
      await page.mouse.move(P[0] + 0.04 * step * size * across, P[1] + 0.04 * step * size * up);
    await page.mouse.up();
    await page.locator(":is(.arm-near-pose, .arm-singular-pose) .arm-factors").waitFor();
    const [now, still] = [await middleOf(".arm-point-ring"), await middleOf(".arm-joint-dot")];
    assert.ok(Math.hypot(still[0] - base[0], still[1] - base[1]) < 1, "it is seen from as near as before");
    assert.ok(now[0] < box.x + box.width && now[1] > box.y, "P is in the box");
  });

test("a browser that stores nothing gets a message", async () => {
  const { page, context } = await openedAnew(there, "learn.html");
  await page.evaluate(() => Object.defineProperty(navigator, "serviceWorker", { value: {} }));
  await page.getByText("Save this course for offline use").click();
  await page.getByText(/This browser can't store anything offline here/).waitFor();
  await context.close();
});
