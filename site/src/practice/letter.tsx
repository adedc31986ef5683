// Show a symbol with simple LaTeX without typesetting: an italic letter, a dot for a rate, an index.

import type { JSX } from "preact";

import { Dotted } from "../arm/letters.js";
import { Tex } from "./math.js";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", alpha: "α", beta: "β", omega: "ω", tau: "τ" };

/** A letter; whether it has the dot of a rate; its star or prime ("*", "′" or ""); and its index, or "". */
type LetterParts = { readonly letter: string; readonly hasDot: boolean; readonly mark: string; readonly index: string };

/** Return the parts of a symbol such as \dot{\theta}_{1} or p^*_{0}; null for other LaTeX. */
export function parseSymbol(latex: string): LetterParts | null {
  const [, dottedLetter, plainLetter, star = "", index = "", prime = ""] =
    /^(?:\\dot\{([^{}]+)\}|(\\?[A-Za-z]+))(\^\*)?(?:_\{?(\w+)\}?)?('?)$/.exec(latex) ?? [];
  const name = dottedLetter ?? plainLetter;
  const letter = name?.startsWith("\\") ? GREEK[name.slice(1)] : name;
  return letter === undefined
    ? null
    : { letter, hasDot: dottedLetter !== undefined, mark: star ? "*" : prime && "′", index };
}

/** Return the accessible name of a symbol's button: as it is displayed, for voice control, and as it is typed. */
export function nameButton(name: string, latex: string): string {
  const shownName = latex
    .replace(/\\dot\{([^}]*)\}/g, "$1")
    .replace(/\\([a-z]+)/g, (_, letter: string) => GREEK[letter] ?? letter)
    .replace(/[_{}]/g, "");
  return shownName === name ? name : `${shownName}, ${name}`;
}

/** A symbol; anything more than a letter with its index is typeset. */
export function Letter({ latex }: { latex: string }): JSX.Element {
  const parts = parseSymbol(latex);
  if (!parts) return <Tex latex={latex} />;
  const { letter, hasDot, mark, index } = parts;
  return (
    <span class="letter">
      {hasDot ? <Dotted letter={letter} /> : <i>{letter}</i>}
      {mark ? <sup>{mark}</sup> : null}
      {index ? <sub>{index}</sub> : null}
    </span>
  );
}
