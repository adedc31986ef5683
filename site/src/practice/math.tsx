// Formulas and texts of the bank as components: HTML that Python wrote, typeset once it is on the page.

import type { JSX } from "preact";
import { useEffect, useRef } from "preact/hooks";

import { UNIT, Words } from "../arm/letters.js";
import { typeset, typesetInto } from "../tex.js";

type HtmlProps = { html: string; class?: string; lang?: string | undefined };

/** HTML of the bank, by default in English. It comes from the site's own files, so it is safe to insert. */
export function Html({ html, class: name = "", lang = "en" }: HtmlProps) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (place.current) void typeset(place.current);
  }, [html]);
  return <div ref={place} key={html} class={name} lang={lang} dangerouslySetInnerHTML={{ __html: html }} />;
}

/** One formula. */
export function Tex({ latex, block = false }: { latex: string; block?: boolean }) {
  const place = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    if (place.current) void typesetInto(place.current, latex, block);
  }, [latex, block]);
  return <span ref={place} class="formula" />;
}

/** Separates words, LaTeX, and what begins no line after it: a unit and signs. */
const AROUND_LATEX = new RegExp(`\\$(.*?)\\$((?: ${UNIT})?[.,;:)]*)`);

/** A text with LaTeX between dollar signs. Braces contain a space, as in c_{1 2}: {12} would be a placeholder. */
export function Rich({ text }: { text: string }): JSX.Element {
  const pieces = text.split(AROUND_LATEX);
  return (
    <>
      {pieces.map((piece, i) => {
        if (i % 3 === 0) return <Words key={i} text={piece} />;
        if (i % 3 === 2) return null;
        return (
          <span key={i} class="whole">
            <Tex latex={piece} />
            {pieces[i + 1]}
          </span>
        );
      })}
    </>
  );
}
