// Answer the questions of a SCORM package in its own frame, rightly or wrongly. The package's bank has the answers.
import { readFileSync } from "node:fs";
import { join } from "node:path";

/** Return a question from the bank of an unpacked package, with the text of its answer (`typed`). */
export function loadQuestion(folder, item) {
  const part = JSON.parse(readFileSync(join(folder, "bank", `${item}.json`), "utf8"));
  return { ...part, typed: part.solved.typed };
}

/** Return a wrong answer that qdot can parse. */
function makeWrongText({ key }) {
  if (key.type === "configurations") return `${key.joints[0]} = 0.1234`;
  const rows = key.rows ?? key.right.length;
  const columns = key.columns ?? 1;
  const row = (i) => Array.from({ length: columns }, (_, k) => 12345 + 7 * i + k);
  const matrix = Array.from({ length: rows }, (_, i) => row(i));
  if (columns > 1) return JSON.stringify(matrix);
  return rows > 1 ? JSON.stringify(matrix.flat()) : `${matrix[0][0]}`;
}

/** Enter a right or a wrong answer in the frame of a package, and click "Check". */
export async function answer(frame, part, isRight) {
  const { key } = part;
  const nextOption = (index) => (index + 1) % key.options;
  const chosen = key.right?.map((index) => (isRight ? index : nextOption(index)));
  if (key.type === "choice") await frame.locator('form input[type="radio"]').nth(chosen[0]).check();
  else if (key.type === "selection") {
    const boxes = frame.locator('form input[type="checkbox"]');
    const wanted = isRight || key.right.length === key.options ? key.right : [nextOption(key.right.at(-1))];
    for (let i = 0; i < key.options; i += 1)
      await boxes.nth(i).setChecked(isRight ? wanted.includes(i) : wanted.includes(i) && i > 0);
    if (!isRight && !(await frame.locator("form input:checked").count())) await boxes.nth(wanted[0]).check();
  } else if (key.type === "matching") {
    const options = await frame.locator("form select").first().locator("option").count();
    for (let i = 0; i < key.items; i += 1)
      await frame
        .locator("form select")
        .nth(i)
        .selectOption({ index: chosen[i] + options - key.options });
  } else {
    const textButton = frame.getByRole("button", { name: "Type it as text" });
    if (await textButton.count()) await textButton.click();
    await frame.getByLabel("Your answer").fill(isRight ? part.typed : makeWrongText(part));
  }
  await frame.getByRole("button", { name: "Check" }).click();
}

/** Go to the question at a place of a round, and return its id. */
export async function goToQuestion(frame, place) {
  await frame.locator(".round-places button").nth(place).click();
  await frame
    .locator('.round-places button[aria-current="true"]')
    .getByText(`${place + 1}`, { exact: true })
    .waitFor();
  await frame.locator(".task[data-item] form .answer").waitFor();
  return frame.locator(".task").getAttribute("data-item");
}
