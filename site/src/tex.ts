// Typeset formulas as MathML by Temml, a few at a time, so that the page stays responsive.

import { afterPaint, yieldToBrowser } from "./scheduling.js";

/** Milliseconds of typesetting after which the browser may handle other work. */
const SLICE_TIME = 8;

type WaitingFormula = { readonly latex: string; readonly isBlock: boolean };

const waitingFormulas = new Map<HTMLElement, WaitingFormula>();
let runningQueue: Promise<void> | null = null;

/** Typeset the LaTeX in elements of class "tex" inside an element. Most formulas are MathML already. */
export function typeset(root: HTMLElement): Promise<void> {
  afterPaint(() => makeReachable(root));
  for (const element of root.querySelectorAll<HTMLElement>(".tex:not([data-set])")) {
    waitingFormulas.set(element, { latex: element.textContent ?? "", isBlock: element.tagName === "DIV" });
  }
  return runQueue();
}

/** Typeset a formula into an element; earlier content, also waiting one, is replaced. */
export function typesetInto(element: HTMLElement, latex: string, isBlock: boolean): Promise<void> {
  waitingFormulas.set(element, { latex, isBlock });
  return runQueue();
}

function runQueue(): Promise<void> {
  if (waitingFormulas.size === 0) return runningQueue ?? Promise.resolve();
  runningQueue ??= typesetWaiting().finally(() => {
    runningQueue = null;
  });
  return runningQueue.then(runQueue); // formulas may have been added meanwhile
}

async function typesetWaiting(): Promise<void> {
  const temml = await import("temml").then(
    (loaded) => loaded.default,
    () => null, // without a connection, the LaTeX stays visible
  );
  if (!temml) return waitingFormulas.clear();
  const typesetElements: HTMLElement[] = [];
  let start = performance.now();
  for (const [element, { latex, isBlock }] of waitingFormulas) {
    waitingFormulas.delete(element);
    if (!element.isConnected) continue;
    temml.render(latex, element, { displayMode: isBlock, throwOnError: false });
    for (const accented of element.querySelectorAll("mover")) accented.setAttribute("accent", "true"); // close to its letter
    element.dataset["set"] = "";
    typesetElements.push(element);
    if (performance.now() - start < SLICE_TIME) continue;
    await yieldToBrowser();
    start = performance.now();
  }
  for (const element of typesetElements) makeReachable(element);
}

/** Make formulas that are too wide scrollable by the keyboard: they become Tab stops. */
function makeReachable(root: HTMLElement): void {
  const formulas = [...root.querySelectorAll<HTMLElement>('math[display="block"]')];
  if (root.matches("div.tex")) formulas.push(root);
  for (const formula of formulas) {
    if (formula.scrollWidth > formula.clientWidth) formula.tabIndex = 0;
  }
}
