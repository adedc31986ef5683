// A text with LaTeX between dollar signs. Its braces contain a space, c_{1 2}, because {12} would be a placeholder.

import type { JSX } from "preact";

import { Tex } from "../practice/math.js";

export function Rich({ text }: { text: string }): JSX.Element {
  return (
    <>
      {text.split("$").map((piece, i) => (i % 2 === 1 ? <Tex key={i} latex={piece} /> : <span key={i}>{piece}</span>))}
    </>
  );
}
