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

for (const locale of ["en-GB", "de-DE"])
  test(`the menu is one row on a narrow phone: ${locale}`, async () => {
    const narrow = { ...PHONE, viewport: { width: 360, height: 740 }, locale };
    const { page } = await opened(there, "accessibility.html", narrow);
    await page.locator("header.top .language select:enabled").waitFor(); // in its language by then
    const links = await page.locator("header.top nav a").evaluateAll((all) =>
      all.map((link) => {
        const { top, left, right } = link.getBoundingClientRect();
        return { top, left, right };
      }),
    );
    assert.ok(links.length >= 4);
    assert.deepEqual([...new Set(links.map(({ top }) => top))], [links[0].top]);
    links.slice(1).forEach(({ left }, i) => assert.ok(left >= links[i].right + 3, JSON.stringify(links)));
    assert.ok(links.at(-1).right <= 360 - 8, JSON.stringify(links.at(-1)));
  });
