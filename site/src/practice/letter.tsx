// A symbol with simple LaTeX, shown without typesetting: an italic letter, a dot for a rate, an index.

import type { JSX } from "preact";

import { Dotted } from "../arm/letters.js";
import { Tex } from "./math.js";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", alpha: "α", beta: "β", omega: "ω", tau: "τ" };

/** A letter, whether it has the dot of a rate, its star or prime, and its index. */
type Parts = { readonly letter: string; readonly dotted: boolean; readonly mark: string; readonly index: string };

/** What a symbol such as \dot{\theta}_{1} or p^*_{0} is made of; null where it is more than that. */
export function partsOf(latex: string): Parts | null {
  const [, dotted, plain, star = "", index = "", prime = ""] =
    /^(?:\\dot\{([^{}]+)\}|(\\?[A-Za-z]+))(\^\*)?(?:_\{?(\w+)\}?)?('?)$/.exec(latex) ?? [];
  const name = dotted ?? plain;
  const letter = name?.startsWith("\\") ? GREEK[name.slice(1)] : name;
  return letter === undefined ? null : { letter, dotted: dotted !== undefined, mark: star ? "*" : prime && "′", index };
}

/** The name of a symbol's button: as it is seen, for voice control, and as it is typed, which tells rates apart. */
export function called(name: string, latex: string): string {
  const seen = latex
    .replace(/\\dot\{([^}]*)\}/g, "$1")
    .replace(/\\([a-z]+)/g, (_, letter: string) => GREEK[letter] ?? letter)
    .replace(/[_{}]/g, "");
  return seen === name ? name : `${seen}, ${name}`;
}

/** A symbol; what is more than a letter with its index is typeset. */
export function Letter({ latex }: { latex: string }): JSX.Element {
  const found = partsOf(latex);
  if (!found) return <Tex latex={latex} />;
  const { letter, dotted, mark, index } = found;
  return (
    <span class="letter">
      {dotted ? <Dotted letter={letter} /> : <i>{letter}</i>}
      {mark ? <sup>{mark}</sup> : null}
      {index ? <sub>{index}</sub> : null}
    </span>
  );
}
