// Symbols as they are typeset: an italic letter, a lowered index, a raised star as in p*.

import { Fragment, type JSX } from "preact";
import { memo } from "../pace.js";

const GREEK: Readonly<Record<string, string>> = { theta: "θ", sigma: "σ" };

/** Return the letter, star and index of a name such as "theta1", "d3", "z0", "p*1" or "P". */
export function splitName(name: string): readonly [letter: string, star: string, index: string] {
  const [, letter = name, star = "", wordIndex, index = ""] =
    /^([A-Za-zθω\u0307]+?)(\*?)(?:_(min|[wxyz])|_?(\d*))$/.exec(name) ?? [];
  return [GREEK[letter] ?? letter, star, wordIndex ?? index];
}

/** Return a name as plain text, for screen readers: "theta1" is "θ1", and "P=O2" is "P = O2". */
export function plainLetters(name: string): string {
  return name
    .split("=")
    .map((part) => splitName(part).join(""))
    .join(" = ");
}

/** Return the CSS class that gives joint `joint` (from 0) its colour. */
export const jointClass = (joint: number): string => `arm-j${(joint % 7) + 1}`;

/** A letter with the dot of a rate. CSS draws the dot: many fonts lack it or let it touch a θ. */
export const Dotted = ({ letter }: { letter: string }): JSX.Element => (
  <i class="dotted">
    {letter}
    <span class="dot-said">˙</span>
  </i>
);

export const Letters = memo(({ name, hasDot = false }: { name: string; hasDot?: boolean }): JSX.Element => {
  const [letter, star, index] = splitName(name);
  return (
    <span class="arm-letters">
      {hasDot ? <Dotted letter={letter} /> : <i>{letter}</i>}
      {star && <sup>{star}</sup>}
      {index && <sub>{index}</sub>}
    </span>
  );
});

/** The same inside an SVG text element; equal points have "=" between their names. */
export const DrawnLetters = memo(({ name }: { name: string }): JSX.Element => {
  const names = name.split("=").map(splitName);
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

/** The unit after a number, as a regular expression. */
export const UNIT = "(?:m²|m/s|rad/s|rad|N m|N|m)(?![\\w/²])";
/** Spaces at which no line ends: before a unit, in N m, and on both sides of = before a number. */
const FIXED_SPACES = new RegExp(`(?<=[\\d)]) (?=${UNIT})|(?<=N) (?=m\\b)| (?== [−\\d])|(?<= =) (?=[−\\d])`, "g");

/** A text in which the point P and the Jacobian J stand as in formulas. */
export const Words = memo(({ text }: { text: string }): JSX.Element => (
  <span>
    {text
      .replace(FIXED_SPACES, "\u00a0")
      .split(/\b(JJ?|P)\b/)
      .map((piece, i) =>
        i % 2 === 1 ? (
          <i key={i} class="letter">
            {piece}
          </i>
        ) : (
          piece
        ),
      )}
  </span>
));
