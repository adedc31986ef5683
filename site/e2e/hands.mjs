// Operate a page as a student does: with the keyboard alone, in Chromium and in Firefox, or with a finger.
//
// A page has `run(body, value)`, `open(address)`, `keys(...)`, and `tap([x, y])` for a finger. Hands have `press` (a
// button by its name), `slide`, `choose`, `type` and `send`.
import assert from "node:assert/strict";

import { Keys } from "./bidi.mjs";

/** Playwright's names for keys. */
const NAMES = {
  [Keys.right]: "ArrowRight",
  [Keys.up]: "ArrowUp",
  [Keys.down]: "ArrowDown",
  [Keys.home]: "Home",
  [Keys.enter]: "Enter",
  [Keys.tab]: "Tab",
};

/** Return a page of Playwright with the methods that hands need. */
export const chromiumPage = (page) => ({
  run: (body, value) => page.evaluate(body, value),
  open: (address) => page.goto(address),
  keys: async (...keys) => {
    for (const key of keys) await page.keyboard.press(NAMES[key] ?? key);
  },
  tap: ([x, y]) => page.touchscreen.tap(x, y),
});

/** Return a page of Firefox with the methods that hands need. */
export const firefoxPage = (page) => ({ run: page.run, open: page.open, keys: page.keys });

const LOOK = 40;
const LOOKS = 500;

/** Run a function in the page until its result is truthy, and return the result. */
export async function until(page, body, value) {
  for (let looks = 0; looks < LOOKS; looks += 1) {
    const found = await page.run(body, value);
    if (found) return found;
    await new Promise((later) => setTimeout(later, LOOK));
  }
  throw new Error(`not in time: ${body} of ${JSON.stringify(value)}`);
}

/** Return whether a button, the summary of a folded section or the first element of a selector has the focus. */
const hasFocus = ({ name, selector }) => {
  const { activeElement } = document;
  return name === undefined
    ? activeElement === document.querySelector(selector)
    : activeElement?.matches("button, summary") && activeElement.textContent.trim().startsWith(name);
};

/** The keyboard alone: everything is reached by the Tab key. */
export function keyboard(page) {
  const to = async (wanted) => {
    for (let stops = 0; stops < 150; stops += 1) {
      if (await page.run(hasFocus, wanted)) return;
      await page.keys(Keys.tab);
    }
    throw new Error(`no stop of the Tab key is ${JSON.stringify(wanted)}`);
  };
  return {
    async press(name) {
      await to({ name });
      await page.keys(Keys.enter);
    },
    /** Move a slider to three quarters of its range. */
    async slide(selector) {
      await to({ selector });
      await page.keys(Keys.home);
      const isBelow = () => {
        const { value, min, max } = document.activeElement;
        return Number(value) < (Number(min) + 3 * Number(max)) / 4 - 1e-6;
      };
      for (let steps = 0; steps < 100 && (await page.run(isBelow)); steps += 1) await page.keys(Keys.right);
    },
    /** Choose an option by its index. */
    async choose(selector, number) {
      await to({ selector });
      await page.keys(...Array.from({ length: number }, () => Keys.down), Keys.space);
    },
    async type(selector, text) {
      await to({ selector });
      await page.keys(...text.replaceAll("\n", " "));
    },
    /** Submit the answer, from its field or from the chosen option. */
    send: () => page.keys(Keys.enter),
  };
}

/** A finger: it scrolls to an element, waits until it rests, checks that nothing covers it, and taps its centre; a slider, at three quarters. */
export function touch(page) {
  /** Scroll to an element; return its position, and the element on top of its centre. */
  const find = ({ name, selector, number = 0 }) => {
    const all =
      name === undefined
        ? [...document.querySelectorAll(selector)]
        : [...document.querySelectorAll("button, summary")].filter((each) => each.textContent.trim().startsWith(name));
    const element = all[number];
    if (!element) return null;
    element.scrollIntoView({ block: "center", behavior: "instant" });
    const { x, y, width, height } = element.getBoundingClientRect();
    const middle = [x + width * (element.matches('[type="range"]') ? 0.75 : 0.5), y + height / 2];
    const over = document.elementFromPoint(...middle);
    window.isTapped = !element.matches("button, summary"); // a slider takes a tap without a click
    element.addEventListener("click", () => void (window.isTapped = true), { once: true, capture: true });
    return { middle, over: element.contains(over) ? "" : (over?.outerHTML.slice(0, 120) ?? "nothing") };
  };
  /** Return whether a tap hit its element; if the page scrolled the element away, the tap is repeated. */
  const isTapped = async () => {
    for (let looks = 0; looks < 10; looks += 1) {
      if (await page.run(() => window.isTapped)) return true;
      await new Promise((later) => setTimeout(later, LOOK));
    }
    return false;
  };
  const tapped = async (wanted) => {
    let before = null;
    for (let looks = 0; looks < LOOKS; looks += 1) {
      const found = await page.run(find, wanted);
      if (found && before && String(found.middle) === String(before.middle)) {
        assert.equal(found.over, "", `lies over ${JSON.stringify(wanted)}`);
        await page.tap(found.middle);
        if (await isTapped()) return;
      }
      before = found; // don't tap an element that is still moving
      await new Promise((later) => setTimeout(later, LOOK));
    }
    throw new Error(`there is no ${JSON.stringify(wanted)} at rest`);
  };
  return {
    press: (name) => tapped({ name }),
    slide: (selector) => tapped({ selector }),
    choose: (selector, number) => tapped({ selector, number }),
    /** Type as the on-screen keyboard does. */
    async type(selector, text) {
      await tapped({ selector });
      await page.keys(...text.replaceAll("\n", " "));
    },
    send: () => tapped({ selector: 'form button[type="submit"]' }),
  };
}
