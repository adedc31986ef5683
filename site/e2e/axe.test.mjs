// A page of each kind, wide and light, and on a phone in the dark: the axe checker, and nothing wider than the screen.
import assert from "node:assert/strict";
import { test } from "node:test";

import { armOf, AXE, inChromium, KINDS, opened, PHONE, WIDE } from "./opened.mjs";

const there = inChromium();

for (const path of KINDS) {
  for (const [name, options] of [
    ["wide and light", { ...WIDE, colorScheme: "light" }],
    ["on a phone in the dark", { ...PHONE, colorScheme: "dark" }],
  ]) {
    test(`${path} is accessible ${name}`, async () => {
      const { page, context, wrong } = await opened(there, path, options);
      await armOf(page);
      await page.evaluate(AXE);
      const { violations } = await page.evaluate(() =>
        window.axe.run({
          runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],
          // axe takes MathML for nothing: headers that hold a formula seem empty to it
          rules: {
            "empty-table-header": { enabled: false },
            "label-content-name-mismatch": { enabled: true },
          },
        }),
      );
      assert.deepEqual(
        violations.map(
          ({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 120)).join(" | ")}`,
        ),
        [],
      );
      const wider = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
      assert.ok(wider <= 0, `${wider} pixels wider than the screen`);
      assert.deepEqual(wrong, []);
      await context.close();
    });
  }
}
