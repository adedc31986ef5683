// Write formulas in the textbook's notation: a_1 s_{12} c_3, halves as fractions.

import { formatNumber } from "../text/text.js";
import type { Formulas, Product, Variable } from "./formulas.js";
import type { RealTerm } from "./trig-polynomial.js";

type Names = Pick<Formulas, "angles" | "lengths">;

/** Return an absolute number, or "" for 1; fractions of powers of two are written as fractions. */
function writeNumber(value: number): string {
  const size = Math.abs(value);
  if (Math.abs(size - 1) < 1e-12) return "";
  const denominator = [2, 4, 8, 16].find((candidate) => size < 10 && Number.isInteger(size * candidate));
  if (denominator && !Number.isInteger(size)) return `\\tfrac{${size * denominator}}{${denominator}}`;
  return formatNumber(size).replace(",", "{,}");
}

const writePower = (latex: string, power: number): string =>
  power === 0 ? "" : power === 1 ? latex : `${latex}^{${power}}`;

const writeLengths = (powers: readonly number[], lengths: readonly Variable[]): string[] =>
  powers.map((power, i) => writePower(lengths[i]!.latex, power));

/** Return s_{12}, or sin(2 theta_1 - theta_2) if the multiples of the angles are not 1. */
function writeWave({ kind, multiples }: RealTerm["waves"][number], angles: readonly Variable[], power = 1): string {
  const used = multiples.flatMap((multiple, i) => (multiple === 0 ? [] : [[multiple, angles[i]!.latex] as const]));
  if (used.every(([multiple]) => multiple === 1))
    return writePower(`${kind}_{${used.map(([, latex]) => /\d+/.exec(latex)![0]).join("")}}`, power);
  const sum = used.map(([multiple, latex], i) => {
    const sign = multiple < 0 ? " - " : i > 0 ? " + " : "";
    return `${sign}${Math.abs(multiple) === 1 ? "" : Math.abs(multiple)}${latex}`;
  });
  return `${writePower(kind === "s" ? "\\sin" : "\\cos", power)}(${sum.join("")})`;
}

const join = (parts: readonly string[]): string => parts.filter(Boolean).join(" ") || "1";

function writeSum(terms: readonly RealTerm[], { angles, lengths }: Names): string {
  const parts = terms.map(({ coefficient, waves, powers }, i) => {
    const sign = coefficient < 0 ? (i > 0 ? " - " : "-") : i > 0 ? " + " : "";
    const factors = [...writeLengths(powers, lengths), ...waves.map((wave) => writeWave(wave, angles))];
    return `${sign}${join([writeNumber(coefficient), ...factors])}`;
  });
  return parts.join("");
}

/** Return the LaTeX of a product. */
export function writeProduct({ number, powers, factors }: Product, names: Names): string {
  if (number === 0) return "0";
  const [onlyFactor] = factors;
  const isSum = factors.length === 1 && onlyFactor!.power === 1 && onlyFactor!.terms.length > 1;
  if (isSum && Math.abs(number) === 1 && powers.every((power) => power === 0))
    return writeSum(
      onlyFactor!.terms.map((term) => ({ ...term, coefficient: number * term.coefficient })),
      names,
    );
  const written = factors.map(({ terms, power }) => {
    const [first] = terms;
    return terms.length > 1
      ? writePower(`(${writeSum(terms, names)})`, power)
      : join([...first!.waves.map((wave) => writeWave(wave, names.angles, power))]);
  });
  return `${number < 0 ? "-" : ""}${join([writeNumber(number), ...writeLengths(powers, names.lengths), ...written])}`;
}

/** Return the LaTeX of a matrix. */
export const writeMatrix = (rows: readonly (readonly Product[])[], names: Names): string =>
  `\\begin{bmatrix} ${rows.map((row) => row.map((entry) => writeProduct(entry, names)).join(" & ")).join(" \\\\ ")} \\end{bmatrix}`;
