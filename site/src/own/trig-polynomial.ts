// Polynomials in lengths, and in sines and cosines of joint angles, with exact sums, products and quotients.
//
// A sine or cosine is a sum of powers of z = exp(i theta), so a polynomial is a sum of terms (complex number) z^m l^k.
// Its real form is unique: per term a number, lengths, and for each group of parallel joints at most one sine or cosine
// of a sum of joint angles.

/** A term: its complex coefficient, and the exponent of each variable; those of angles may be negative. */
type Term = { readonly re: number; readonly im: number; readonly exponents: readonly number[] };
export type Polynomial = ReadonlyMap<string, Term>;

/** Smaller coefficients are rounding errors. */
const TOLERANCE = 1e-12;

export const ZERO: Polynomial = new Map();

function collect(terms: Iterable<Term>): Polynomial {
  const sums = new Map<string, Term>();
  for (const { re, im, exponents } of terms) {
    const key = exponents.join();
    const sum = sums.get(key);
    sums.set(key, { re: re + (sum?.re ?? 0), im: im + (sum?.im ?? 0), exponents });
  }
  for (const [key, { re, im }] of sums) if (Math.hypot(re, im) < TOLERANCE) sums.delete(key);
  return sums;
}

const multiplyTerms = (a: Term, b: Term): Term => ({
  re: a.re * b.re - a.im * b.im,
  im: a.re * b.im + a.im * b.re,
  exponents: a.exponents.map((power, i) => power + b.exponents[i]!),
});

export const add = (...summands: readonly Polynomial[]): Polynomial =>
  collect(summands.flatMap((summand) => [...summand.values()]));

export const multiply = (f: Polynomial, g: Polynomial): Polynomial =>
  collect([...f.values()].flatMap((a) => [...g.values()].map((b) => multiplyTerms(a, b))));

export const scale = (f: Polynomial, factor: number): Polynomial =>
  collect([...f.values()].map((term) => ({ ...term, re: factor * term.re, im: factor * term.im })));

/** Return the monomial of some exponents. */
export const monomial = (exponents: readonly number[]): Polynomial => collect([{ re: 1, im: 0, exponents }]);

/** Return the sine or cosine of a sum of angles, each with its multiple. */
export function wave(kind: "s" | "c", multiples: readonly number[]): Polynomial {
  const opposite = multiples.map((multiple) => -multiple);
  return kind === "c"
    ? collect([
        { re: 0.5, im: 0, exponents: multiples },
        { re: 0.5, im: 0, exponents: opposite },
      ])
    : collect([
        { re: 0, im: -0.5, exponents: multiples },
        { re: 0, im: 0.5, exponents: opposite },
      ]);
}

/** Compare two lists of exponents: negative if the first one comes first, which has higher powers. */
function compareExponents(a: readonly number[], b: readonly number[]): number {
  const i = a.findIndex((power, k) => power !== b[k]);
  return i < 0 ? 0 : b[i]! - a[i]!;
}

const leadingTerm = (f: Polynomial): Term =>
  [...f.values()].reduce((first, term) => (compareExponents(term.exponents, first.exponents) < 0 ? term : first));

/** Return the least and the largest exponent of each variable. */
function exponentRanges(f: Polynomial): (readonly [least: number, largest: number])[] {
  const lists = [...f.values()].map(({ exponents }) => exponents);
  return lists[0]!.map((_, i) => {
    const powers = lists.map((exponents) => exponents[i]!);
    return [Math.min(...powers), Math.max(...powers)];
  });
}

/** Return f / g if the quotient is a polynomial, else null. Only angles may have negative exponents. */
export function divide(f: Polynomial, g: Polynomial): Polynomial | null {
  if (f.size === 0 || g.size === 0) return null;
  const divisorRanges = exponentRanges(g);
  // The ranges of exponents of a product are the sums of those of its factors.
  const ranges = exponentRanges(f).map(([least, largest], i) => {
    const [leastOfDivisor, largestOfDivisor] = divisorRanges[i]!;
    return [least - leastOfDivisor, largest - largestOfDivisor] as const;
  });
  if (ranges.some(([least, largest]) => least > largest)) return null;
  const { re, im, exponents } = leadingTerm(g);
  const size = re * re + im * im;
  const inverse: Term = { re: re / size, im: -im / size, exponents: exponents.map((power) => -power) };
  const quotient: Term[] = [];
  for (let rest = f; rest.size > 0;) {
    const term = multiplyTerms(leadingTerm(rest), inverse);
    if (term.exponents.some((power, i) => power < ranges[i]![0] || power > ranges[i]![1])) return null;
    quotient.push(term);
    rest = add(rest, scale(multiply(new Map([["", term]]), g), -1));
  }
  return collect(quotient);
}

/** A term of the real form: sines and cosines ("s" or "c") of sums of angles, given by the multiple of each angle. */
export interface RealTerm {
  readonly coefficient: number;
  readonly waves: readonly { readonly kind: "s" | "c"; readonly multiples: readonly number[] }[];
  /** The exponents of the lengths. */
  readonly powers: readonly number[];
}

/** Return the real form. A group lists the angles of joints that are parallel. */
export function realForm(f: Polynomial, groups: readonly (readonly number[])[], angleCount: number): RealTerm[] {
  const sums = new Map<string, RealTerm>();
  for (const { re, im, exponents } of f.values()) {
    const powers = exponents.slice(angleCount);
    let parts: { re: number; im: number; waves: RealTerm["waves"] }[] = [{ re, im, waves: [] }];
    for (const group of groups) {
      const multiples = exponents.slice(0, angleCount).map((power, i) => (group.includes(i) ? power : 0));
      const first = multiples.find((multiple) => multiple !== 0);
      if (first === undefined) continue;
      const sign = Math.sign(first);
      const positive = multiples.map((multiple) => sign * multiple + 0);
      parts = parts.flatMap(({ re, im, waves }) => [
        { re, im, waves: [...waves, { kind: "c" as const, multiples: positive }] },
        { re: -sign * im, im: sign * re, waves: [...waves, { kind: "s" as const, multiples: positive }] },
      ]);
    }
    for (const { re, waves } of parts) {
      const key = JSON.stringify([powers, waves]);
      sums.set(key, { coefficient: re + (sums.get(key)?.coefficient ?? 0), waves, powers });
    }
  }
  const anglesOf = ({ waves }: RealTerm): number[] =>
    Array.from({ length: angleCount }, (_, i) => waves.reduce((sum, { multiples }) => sum + multiples[i]!, 0));
  return [...sums.values()]
    .filter(({ coefficient }) => Math.abs(coefficient) > TOLERANCE)
    .sort((a, b) => compareExponents(a.powers, b.powers) || compareExponents(anglesOf(a), anglesOf(b)));
}
