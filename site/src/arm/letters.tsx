// Symbols as they are set: an italic letter, its index lowered, the star of p* raised.

import type { JSX } from "preact";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", sigma: "σ" };

/** The letter, star and index of a name such as "theta1", "d3", "z0", "p*1" or "P". */
export function partsOf(name: string): readonly [letter: string, star: string, index: string] {
  const [, letter = name, star = "", index = ""] = /^([A-Za-zθ\u0307]+?)(\*?)_?(\d*|min)$/.exec(name) ?? [];
  return [GREEK[letter] ?? letter, star, index];
}

/** A name as plain text, for labels that are read aloud: "theta1" is "θ1". */
export function plainLetters(name: string): string {
  return partsOf(name).join("");
}

export function Letters({ name, dot = false }: { name: string; dot?: boolean }): JSX.Element {
  const [letter, star, index] = partsOf(name);
  return (
    <span class="arm-letters">
      <i>{dot ? `${letter}\u0307` : letter}</i>
      {star && <sup>{star}</sup>}
      {index && <sub>{index}</sub>}
    </span>
  );
}

/** The same inside a drawing, as pieces of a text element. */
export function DrawnLetters({ name }: { name: string }): JSX.Element {
  const [letter, star, index] = partsOf(name);
  return (
    <>
      <tspan class="arm-italic">{letter}</tspan>
      {star && (
        <tspan class="arm-small" dy="-5">
          {star}
        </tspan>
      )}
      {index && (
        <tspan class="arm-small" dy={star ? 9 : 4}>
          {index}
        </tspan>
      )}
    </>
  );
}
