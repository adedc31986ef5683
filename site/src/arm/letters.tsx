// Symbols as they are set: an italic letter, its index lowered, the star of p* raised.

import { Fragment, type JSX } from "preact";
import { memo } from "../memo.js";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", sigma: "σ" };

/** The letter, star and index of a name such as "theta1", "d3", "z0", "p*1" or "P". */
export function partsOf(name: string): readonly [letter: string, star: string, index: string] {
  const [, letter = name, star = "", word, index = ""] =
    /^([A-Za-zθω\u0307]+?)(\*?)(?:_(min|[wxyz])|_?(\d*))$/.exec(name) ?? [];
  return [GREEK[letter] ?? letter, star, word ?? index];
}

/** A name as plain text, for labels that are read aloud: "theta1" is "θ1", and "P=O2" is "P = O2". */
export function plainLetters(name: string): string {
  return name
    .split("=")
    .map((one) => partsOf(one).join(""))
    .join(" = ");
}

/** The class that gives a joint (from 0) its colour. */
export const jointClass = (joint: number): string => `arm-j${(joint % 7) + 1}`;

/** A letter with the dot of a rate, which is drawn: many fonts have none, or let it sink into a θ. */
export const Dotted = ({ letter }: { letter: string }): JSX.Element => (
  <i class="dotted">
    {letter}
    <span class="dot-said">˙</span>
  </i>
);

export const Letters = memo(({ name, dot = false }: { name: string; dot?: boolean }): JSX.Element => {
  const [letter, star, index] = partsOf(name);
  return (
    <span class="arm-letters">
      {dot ? <Dotted letter={letter} /> : <i>{letter}</i>}
      {star && <sup>{star}</sup>}
      {index && <sub>{index}</sub>}
    </span>
  );
});

/** The same inside a drawing, as pieces of a text element; names of one thing have "=" between them. */
export const DrawnLetters = memo(({ name }: { name: string }): JSX.Element => {
  const names = name.split("=").map(partsOf);
  return (
    <>
      {names.map(([letter, star, index], k) => (
        <Fragment key={k}>
          {k > 0 && <tspan dy={names[k - 1]![2] ? -4 : 0}> = </tspan>}
          <tspan class={/^[\d.,−]+$/.test(letter) ? "arm-upright" : "arm-italic"}>{letter}</tspan>
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
        </Fragment>
      ))}
    </>
  );
});
