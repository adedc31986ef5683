// Typeset formulas as MathML by Temml, a few at a time, so that the page stays responsive.

import { afterPaint, breath } from "./later.js";

/** Milliseconds of typesetting after which the browser may do something else. */
const SLICE = 8;

type Waiting = { readonly latex: string; readonly block: boolean };

const waiting = new Map<HTMLElement, Waiting>();
let running: Promise<void> | null = null;

/** Typeset every formula in an element: LaTeX in elements of class "tex" is replaced. Most are MathML already. */
export function typeset(root: HTMLElement): Promise<void> {
  afterPaint(() => reachable(root));
  for (const element of root.querySelectorAll<HTMLElement>(".tex:not([data-set])")) {
    waiting.set(element, { latex: element.textContent ?? "", block: element.tagName === "DIV" });
  }
  return begun();
}

/** Typeset one formula into an element, in place of what is there or was wanted there before. */
export function typesetInto(element: HTMLElement, latex: string, block: boolean): Promise<void> {
  waiting.set(element, { latex, block });
  return begun();
}

function begun(): Promise<void> {
  if (waiting.size === 0) return running ?? Promise.resolve();
  running ??= worked().finally(() => {
    running = null;
  });
  return running.then(begun); // what came when all else was done
}

async function worked(): Promise<void> {
  const temml = await import("temml").then(
    (loaded) => loaded.default,
    () => null, // there is no connection: what is wanted stays as it was written
  );
  if (!temml) return waiting.clear();
  const done: HTMLElement[] = [];
  let start = performance.now();
  for (const [element, { latex, block }] of waiting) {
    waiting.delete(element);
    if (!element.isConnected) continue;
    temml.render(latex, element, { displayMode: block, throwOnError: false });
    element.dataset["set"] = "";
    done.push(element);
    if (performance.now() - start < SLICE) continue;
    await breath();
    start = performance.now();
  }
  for (const element of done) reachable(element);
}

/** Let wide formulas in an element be scrolled by keyboard: those that don't fit can be tabbed to. */
export function reachable(root: HTMLElement): void {
  const formulas = [...root.querySelectorAll<HTMLElement>('math[display="block"]')];
  if (root.matches("div.tex")) formulas.push(root);
  for (const formula of formulas) {
    if (formula.scrollWidth > formula.clientWidth) formula.tabIndex = 0;
  }
}
