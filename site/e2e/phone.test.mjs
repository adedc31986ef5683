// A page of each kind on a phone in the dark: the axe checker, and nothing wider than the screen.
import assert from "node:assert/strict";
import { test } from "node:test";

import { ON_PHONE } from "./kinds.mjs";
import { armOf, assertAccessible, inChromium, opened, PHONE } from "./opened.mjs";

const there = inChromium();

for (const path of ON_PHONE) {
  test(`${path} is accessible on a phone in the dark`, async () => {
    const { page, wrong } = await opened(there, path, { ...PHONE, colorScheme: "dark" });
    await armOf(page);
    await assertAccessible(page);
    assert.deepEqual(wrong, []);
  });
}
