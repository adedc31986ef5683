// Formulas typeset as MathML: LaTeX in elements of class "tex" is replaced, once Temml is loaded.

/** Typeset every formula in an element. */
export async function typeset(root: HTMLElement): Promise<void> {
  const waiting = [...root.querySelectorAll<HTMLElement>(".tex:not([data-set])")];
  if (waiting.length === 0) return;
  const { default: temml } = await import("temml");
  for (const element of waiting) {
    temml.render(element.textContent ?? "", element, {
      displayMode: element.tagName === "DIV",
      throwOnError: false,
    });
    element.dataset["set"] = "";
  }
  reachable(root);
}

/** Let wide formulas in an element be scrolled by keyboard: those that don't fit can be tabbed to. */
export function reachable(root: HTMLElement): void {
  for (const formula of root.querySelectorAll<HTMLElement>('math[display="block"], div.tex')) {
    if (formula.scrollWidth > formula.clientWidth) formula.tabIndex = 0;
  }
}
