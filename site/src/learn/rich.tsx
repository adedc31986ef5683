// A text of the catalogue with formulas in it, as LaTeX between dollar signs. In these, braces hold a space, as in
// c_{1 2}: {12} would be filled in as a value.

import type { JSX } from "preact";

import { Tex } from "../practice/math.js";

export function Rich({ text }: { text: string }): JSX.Element {
  return (
    <>
      {text.split("$").map((piece, i) => (i % 2 === 1 ? <Tex key={i} latex={piece} /> : <span key={i}>{piece}</span>))}
    </>
  );
}
