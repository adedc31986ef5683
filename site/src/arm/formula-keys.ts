// Reach the terms of formulas by keys: Tab stops at each formula, left and right move between terms, down and up to and
// from a term's letters, Enter pins a term, Escape leaves it.

import { useEffect } from "preact/hooks";

import type { Arm } from "./model.js";
import { isSame, jointOf, SYMBOL, symbolsIn, termsOf } from "./terms.js";

/** Formulas of a page that are no part of an arm, and have letters of it. */
function formulasOf(arm: Arm): Element[] {
  return [...document.querySelectorAll("main math")].filter(
    (math) =>
      !math.closest(".arm") && [...math.querySelectorAll(SYMBOL)].some((symbol) => jointOf(symbol, arm) !== null),
  );
}

/** Makes each of them a stop of Tab, those that come later, too, as long as the arm is there. */
export function useFormulaStops(arm: Arm, describedBy: string): void {
  useEffect(() => {
    let wait: ReturnType<typeof setTimeout> | undefined;
    const stops = new Set<Element>();
    const mark = (): void => {
      for (const math of formulasOf(arm)) {
        if (math.hasAttribute("tabindex")) continue;
        math.setAttribute("tabindex", "0");
        math.setAttribute("aria-describedby", describedBy);
        stops.add(math);
      }
    };
    mark();
    const main = document.querySelector("main");
    const watch = new MutationObserver((changes) => {
      if (changes.every(({ target }) => (target as Element).closest?.(".arm"))) return;
      clearTimeout(wait);
      wait = setTimeout(mark, SOON);
    });
    if (main) watch.observe(main, { childList: true, subtree: true });
    return () => {
      watch.disconnect();
      clearTimeout(wait);
      for (const math of stops) for (const name of ["tabindex", "aria-describedby"]) math.removeAttribute(name);
    };
  }, [arm, describedBy]);
}

/** Milliseconds until formulas that have come are stops, too: a page is written in many steps. */
const SOON = 100;

/** The term to which a key leads in a formula from what is pointed at there, or from none; null for any other key. */
export function stepped(math: Element, from: readonly Element[] | null, key: string): readonly Element[] | null {
  const terms = termsOf(math);
  const around = terms.filter((term) => from?.every((part) => term.some((one) => one.contains(part))));
  const term = terms.find((one) => from && isSame(one, from)) ?? around.at(-1);
  const at = term ? terms.indexOf(term) : -1;
  if (key === "ArrowRight") return terms[Math.min(at + 1, terms.length - 1)] ?? null;
  if (key === "ArrowLeft") return terms[Math.max(at - 1, 0)] ?? null;
  if (key === "End") return terms.at(-1) ?? null;
  if (!["Home", "ArrowDown", "ArrowUp"].includes(key)) return null;
  if (key === "Home" || !term || !from) return terms[0] ?? null;
  return letterFrom(term, from, key === "ArrowDown" ? 1 : -1);
}

/** The letter of a term below or above the one that is pointed at; above the first is the term. */
function letterFrom(term: readonly Element[], from: readonly Element[], way: 1 | -1): readonly Element[] {
  const letters = symbolsIn(term);
  if (letters.length < 2) return term;
  const next = letters.findIndex((letter) => isSame([letter], from)) + way;
  return next < 0 ? term : [letters[Math.min(next, letters.length - 1)]!];
}
