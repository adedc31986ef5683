// A symbol as it is set, its LaTeX being simple: an italic letter, a dot for a rate, an index. Nothing is typeset for it.

import type { JSX } from "preact";

import { Tex } from "./math.js";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", alpha: "α", beta: "β", omega: "ω", tau: "τ" };

/** Letter and index of a symbol such as \dot{\theta}_{1}; null where it is more than that. */
export function lettersOf(latex: string): readonly [letter: string, index: string] | null {
  const [, dotted, plain, index = ""] =
    /^(?:\\dot\{([^{}]+)\}|(\\?[A-Za-z]+))(?:_\{?(\w+)\}?)?$/.exec(latex) ?? [];
  const name = dotted ?? plain;
  const letter = name?.startsWith("\\") ? GREEK[name.slice(1)] : name;
  return letter === undefined ? null : [dotted === undefined ? letter : `${letter}\u0307`, index];
}

/** What a symbol's button is called: as it is seen, which who steers by voice says, and as it is typed. */
export function called(name: string, latex: string): string {
  const seen = latex
    .replace(/\\dot\{([^}]*)\}/g, "$1˙")
    .replace(/\\([a-z]+)/g, (_, letter: string) => GREEK[letter] ?? letter)
    .replace(/[_{}]/g, "");
  return seen === name ? name : `${seen}, ${name}`;
}

/** A symbol; what is more than a letter with its index is typeset. */
export function Letter({ latex }: { latex: string }): JSX.Element {
  const found = lettersOf(latex);
  if (!found) return <Tex latex={latex} />;
  const [letter, index] = found;
  return (
    <span class="letter">
      <i>{letter}</i>
      {index ? <sub>{index}</sub> : null}
    </span>
  );
}
