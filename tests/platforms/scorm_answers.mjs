// Questions of a SCORM package answered in its own frame, wrong or right, as its bank tells them.
import { readFileSync } from "node:fs";
import { join } from "node:path";

const parts = {};

/** What the bank of a package, unpacked in a folder, says of a question, with the answer as it is typed. */
export function about(folder, item) {
  const [family, key, kind] = item.split("/");
  const bank = (ending) => JSON.parse(readFileSync(join(folder, "bank", family, `${key}${ending}`), "utf8"));
  const found = (parts[`${folder} ${family}/${key}`] ??= [bank(".json").parts, bank(".solutions.json").parts]);
  const [part, solved] = found.map((each) => each.find((one) => (one.kind ?? one.name) === kind));
  return { ...part, typed: solved.typed };
}

/** An answer that can be read and is wrong. */
function wrongText({ key }) {
  if (key.type === "configurations") return `${key.joints[0]} = 0.1234`;
  const rows = key.rows ?? key.right.length;
  const columns = key.columns ?? 1;
  const row = (i) => Array.from({ length: columns }, (_, k) => 12345 + 7 * i + k);
  const all = Array.from({ length: rows }, (_, i) => row(i));
  if (columns > 1) return JSON.stringify(all);
  return rows > 1 ? JSON.stringify(all.flat()) : `${all[0][0]}`;
}

/** Give an answer in the frame of a package, and have it checked. */
export async function answer(frame, part, isRight) {
  const { key } = part;
  const other = (index) => (index + 1) % key.options;
  const chosen = key.right?.map((index) => (isRight ? index : other(index)));
  if (key.type === "choice") await frame.locator('form input[type="radio"]').nth(chosen[0]).check();
  else if (key.type === "selection") {
    const boxes = frame.locator('form input[type="checkbox"]');
    const wanted = isRight || key.right.length === key.options ? key.right : [other(key.right.at(-1))];
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
    const asText = frame.getByRole("button", { name: "Type it as text" });
    if (await asText.count()) await asText.click();
    await frame.getByLabel("Your answer").fill(isRight ? part.typed : wrongText(part));
  }
  await frame.getByRole("button", { name: "Check" }).click();
}

/** Go to a place of a round, and return which question is there. */
export async function itemAt(frame, place) {
  await frame.locator(".round-places button").nth(place).click();
  await frame
    .locator('.round-places button[aria-current="true"]')
    .getByText(`${place + 1}`, { exact: true })
    .waitFor();
  await frame.locator(".task[data-item] form .answer").waitFor();
  return frame.locator(".task").getAttribute("data-item");
}
