// A field in which formulas are typed as they look: MathLive, loaded when it is asked for. Its LaTeX is the answer.

import type { MathfieldElement } from "mathlive";
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { inDigits, language, say } from "../text/text.js";

/** The formula in a field, its decimal comma as a point. */
const textOf = (field: MathfieldElement | null): string => (field?.getValue("latex") ?? "").replaceAll("{,}", ".");

/** In Firefox, keys are lost as long as the page's selection is not where MathLive listens (its issue 2300). */
function hearKeys({ currentTarget }: Event): void {
  const listens = (currentTarget as Element).shadowRoot?.querySelector('[part="keyboard-sink"]');
  const selection = getSelection();
  if (!listens || !CSS.supports("-moz-appearance", "none")) return;
  if (!listens.contains(selection?.anchorNode ?? null)) selection?.selectAllChildren(listens);
}

/** Put a formula where the cursor of a field is, and go on there. */
export function putInto(place: Element, latex: string): void {
  const field = place as MathfieldElement;
  const cursor = field.position;
  field.focus();
  field.position = cursor; // a field that is entered selects all that it holds
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
  const [failed, setFailed] = useState("");
  useEffect(() => {
    let field: MathfieldElement | null = null;
    let current = true;
    void import("mathlive").then(
      ({ MathfieldElement: Field }) => {
        if (!current || !place.current) return;
        Field.fontsDirectory = null; // the page's own fonts will do
        Field.soundsDirectory = null;
        Field.locale = language().code;
        Field.decimalSeparator = inDigits(0.5).includes(",") ? "," : ".";
        field = new Field();
        field.value = value.replaceAll(".", Field.decimalSeparator === "," ? "{,}" : ".");
        field.setAttribute("aria-label", label);
        field.mathVirtualKeyboardPolicy = "auto";
        field.addEventListener("input", () => onValue(textOf(field)));
        for (const event of ["focusin", "keydown"]) field.addEventListener(event, hearKeys, { capture: true });
        field.addEventListener("keydown", (event) => {
          if (event.key === "Enter") onEnter();
        });
        place.current.replaceChildren(field);
      },
      (error: unknown) => setFailed(String(error)),
    );
    return () => {
      current = false;
      field?.remove();
    };
  }, []);
  if (failed) return <span role="alert">{say("practice.failed", { why: failed })}</span>;
  return <span ref={place} class="math-place" />;
}
