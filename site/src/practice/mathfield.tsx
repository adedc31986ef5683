// A field in which formulas are typed as they look: MathLive, loaded when needed. The answer is the field's LaTeX.

import type { MathfieldElement } from "mathlive";
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { describeLoadError } from "../scheduling.js";
import { decimalSign, getLanguage } from "../text/text.js";

/** Return the LaTeX in a field, with decimal points instead of decimal commas. */
const readFormula = (field: MathfieldElement | null): string => (field?.getValue("latex") ?? "").replaceAll("{,}", ".");

/** In Firefox, MathLive loses keys unless the page's selection is inside its hidden input (MathLive issue 2300). */
function fixFirefoxKeys({ currentTarget }: Event): void {
  const input = (currentTarget as Element).shadowRoot?.querySelector('[part="keyboard-sink"]');
  const selection = getSelection();
  if (!input || !CSS.supports("-moz-appearance", "none")) return;
  if (!input.contains(selection?.anchorNode ?? null)) selection?.selectAllChildren(input);
}

/** Insert a formula at the cursor of a field, and put the focus there. */
export function insertFormula(element: Element, latex: string): void {
  const field = element as MathfieldElement;
  const cursor = field.position;
  field.focus();
  field.position = cursor; // a field that gets the focus selects its whole content
  field.insert(latex, { format: "latex" });
}

interface MathFieldProps {
  readonly label: string;
  readonly value: string;
  readonly onValue: (latex: string) => void;
  readonly onEnter: () => void;
}

export function MathField({ label, value, onValue, onEnter }: MathFieldProps): JSX.Element {
  const place = useRef<HTMLSpanElement>(null);
  const [loadError, setLoadError] = useState("");
  useEffect(() => {
    let field: MathfieldElement | null = null;
    let isMounted = true;
    void import("mathlive").then(
      ({ MathfieldElement: Field }) => {
        if (!isMounted || !place.current) return;
        Field.fontsDirectory = null; // the page's own fonts are sufficient
        Field.soundsDirectory = null;
        Field.locale = getLanguage().code;
        Field.decimalSeparator = decimalSign() === "," ? "," : ".";
        field = new Field();
        field.value = value.replaceAll(".", Field.decimalSeparator === "," ? "{,}" : ".");
        field.setAttribute("aria-label", label);
        field.mathVirtualKeyboardPolicy = "auto";
        field.addEventListener("input", () => onValue(readFormula(field)));
        for (const event of ["focusin", "keydown"]) field.addEventListener(event, fixFirefoxKeys, { capture: true });
        field.addEventListener("keydown", (event) => {
          if (event.key === "Enter") onEnter();
        });
        place.current.replaceChildren(field);
      },
      (error: unknown) => setLoadError(describeLoadError(error)),
    );
    return () => {
      isMounted = false;
      field?.remove();
    };
  }, []);
  if (loadError) return <span role="alert">{loadError}</span>;
  return <span ref={place} class="math-place" />;
}
