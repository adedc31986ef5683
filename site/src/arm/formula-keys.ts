// Reach the terms of formulas by the keyboard: Tab stops at each formula, left and right move between terms, down and
// up between a term and its letters, Enter pins a term, Escape leaves it.

import { useEffect } from "preact/hooks";

import type { Arm } from "./model.js";
import { isSameTerm, jointOf, SYMBOL, symbolsIn, termsOf } from "./terms.js";

/** Return the formulas of the page, outside the arm's panel, that contain letters of the arm. */
function formulasOf(arm: Arm): Element[] {
  return [...document.querySelectorAll("main math")].filter(
    (math) =>
      !math.closest(".arm") && [...math.querySelectorAll(SYMBOL)].some((symbol) => jointOf(symbol, arm) !== null),
  );
}

/** Make each formula with letters of the arm a Tab stop while the arm is shown, also formulas that are added later. */
export function useFormulaStops(arm: Arm, describedBy: string): void {
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const stops = new Set<Element>();
    const addStops = (): void => {
      for (const math of formulasOf(arm)) {
        if (math.hasAttribute("tabindex")) continue;
        math.setAttribute("tabindex", "0");
        math.setAttribute("aria-describedby", describedBy);
        stops.add(math);
      }
    };
    addStops();
    const main = document.querySelector("main");
    const observer = new MutationObserver((changes) => {
      if (changes.every(({ target }) => (target as Element).closest?.(".arm"))) return;
      clearTimeout(timer);
      timer = setTimeout(addStops, STOP_DELAY);
    });
    if (main) observer.observe(main, { childList: true, subtree: true });
    return () => {
      observer.disconnect();
      clearTimeout(timer);
      for (const math of stops) for (const name of ["tabindex", "aria-describedby"]) math.removeAttribute(name);
    };
  }, [arm, describedBy]);
}

/** Delay (ms) before added formulas become Tab stops, because a page is written in many steps. */
const STOP_DELAY = 100;

/** Return the term to which a key leads from the highlighted parts (or from none); null for any other key. */
export function termAfterKey(
  math: Element,
  highlighted: readonly Element[] | null,
  key: string,
): readonly Element[] | null {
  const terms = termsOf(math);
  const enclosingTerms = terms.filter((term) =>
    highlighted?.every((part) => term.some((termPart) => termPart.contains(part))),
  );
  const term = terms.find((candidate) => highlighted && isSameTerm(candidate, highlighted)) ?? enclosingTerms.at(-1);
  const index = term ? terms.indexOf(term) : -1;
  if (key === "ArrowRight") return terms[Math.min(index + 1, terms.length - 1)] ?? null;
  if (key === "ArrowLeft") return terms[Math.max(index - 1, 0)] ?? null;
  if (key === "End") return terms.at(-1) ?? null;
  if (!["Home", "ArrowDown", "ArrowUp"].includes(key)) return null;
  if (key === "Home" || !term || !highlighted) return terms[0] ?? null;
  return letterFrom(term, highlighted, key === "ArrowDown" ? 1 : -1);
}

/** Return the letter of a term after or before the highlighted one; before the first letter comes the term itself. */
function letterFrom(term: readonly Element[], highlighted: readonly Element[], step: 1 | -1): readonly Element[] {
  const letters = symbolsIn(term);
  if (letters.length < 2) return term;
  const next = letters.findIndex((letter) => isSameTerm([letter], highlighted)) + step;
  return next < 0 ? term : [letters[Math.min(next, letters.length - 1)]!];
}
