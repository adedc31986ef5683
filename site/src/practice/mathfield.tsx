// A field in which formulas are typed as they look: MathLive, loaded when it is asked for. Its LaTeX is the answer.

import type { MathfieldElement } from "mathlive";
import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { message, said } from "../text/text.js";

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
        field = new Field();
        field.value = /[\\_^]/.test(value) ? value : "";
        field.setAttribute("aria-label", label);
        field.mathVirtualKeyboardPolicy = "auto";
        field.addEventListener("input", () => onValue(field?.getValue("latex") ?? ""));
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
  if (failed) return <span role="alert">{said(message("practice.failed", { why: failed }))}</span>;
  return <span ref={place} class="math-place" />;
}
