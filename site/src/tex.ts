// Typeset formulas as MathML by Temml, a few at a time, so that the page stays responsive.

import { afterPaint, yieldToBrowser } from "./scheduling.js";

/** Milliseconds of typesetting after which the browser may handle other work. */
const SLICE = 8;

type Waiting = { readonly latex: string; readonly block: boolean };

const waiting = new Map<HTMLElement, Waiting>();
let running: Promise<void> | null = null;

/** Typeset the LaTeX in elements of class "tex" inside an element. Most formulas are MathML already. */
export function typeset(root: HTMLElement): Promise<void> {
  afterPaint(() => makeReachable(root));
  for (const element of root.querySelectorAll<HTMLElement>(".tex:not([data-set])")) {
    waiting.set(element, { latex: element.textContent ?? "", block: element.tagName === "DIV" });
  }
  return runQueue();
}

/** Typeset a formula into an element; earlier content, also waiting one, is replaced. */
export function typesetInto(element: HTMLElement, latex: string, block: boolean): Promise<void> {
  waiting.set(element, { latex, block });
  return runQueue();
}

function runQueue(): Promise<void> {
  if (waiting.size === 0) return running ?? Promise.resolve();
  running ??= typesetWaiting().finally(() => {
    running = null;
  });
  return running.then(runQueue); // formulas may have been added meanwhile
}

async function typesetWaiting(): Promise<void> {
  const temml = await import("temml").then(
    (loaded) => loaded.default,
    () => null, // without a connection, the LaTeX stays visible
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
    await yieldToBrowser();
    start = performance.now();
  }
  for (const element of done) makeReachable(element);
}

/** Make formulas that are too wide scrollable by the keyboard: they become Tab stops. */
export function makeReachable(root: HTMLElement): void {
  const formulas = [...root.querySelectorAll<HTMLElement>('math[display="block"]')];
  if (root.matches("div.tex")) formulas.push(root);
  for (const formula of formulas) {
    if (formula.scrollWidth > formula.clientWidth) formula.tabIndex = 0;
  }
}
