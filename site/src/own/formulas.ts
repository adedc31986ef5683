// Formulas of J and det J of a short arm, derived in the browser and compared with its numbers before they are shown.
//
// Lengths are symbols: a_i and d_i of the table, p_x, p_y, p_z of the point. J_i = z_{i-1} x p*_{i-1} (revolute) or
// z_{i-1} (prismatic), as in ../arm/model.ts. A determinant is factored by trial division: by lengths, by the sines and
// cosines of sums of parallel joints' angles, and by entries of J in the arm's frames.

import { type Arm, stateAt } from "../arm/model.js";
import { determinant, dot } from "../arm/vector.js";
import { makeRandomPoses } from "../random.js";
import { add, divide, monomial, multiply, type Polynomial, realForm, type RealTerm } from "./trig-polynomial.js";
import { scale, wave, ZERO } from "./trig-polynomial.js";

/** A joint angle, a prismatic joint's variable or a length, as a_{1}, with the value of a length (m). */
export type Variable = { readonly latex: string; readonly value: number | null };

/** number * lengths^powers * the product of factors, each with its power. */
export interface Product {
  readonly number: number;
  readonly powers: readonly number[];
  readonly factors: readonly { readonly terms: readonly RealTerm[]; readonly power: number }[];
}

export interface Formulas {
  readonly angles: readonly Variable[];
  readonly lengths: readonly Variable[];
  readonly jacobian: readonly (readonly Product[])[];
  /** det J; null if J is not square, "long" if the formula is too long to be read. */
  readonly determinant: Product | "long" | null;
}

/** Why there are no formulas: too many joints, angles other than multiples of 90°, too many terms, or disagreement. */
export type Reason = "joints" | "angles" | "long" | "numbers";

/** Formulas of arms with more joints are too long for the page. */
export const MAX_FORMULA_JOINTS = 4;
/** A sum with more terms is too long to be read. */
const MAX_TERMS = 16;
/** Determinants with more products of terms are not expanded. */
const MAX_WORK = 1e5;
const CHECKED_POSES = 6;

type Vector = readonly [Polynomial, Polynomial, Polynomial];
type SymbolicFrame = Readonly<Record<"x" | "y" | "z" | "o", Vector>>;

/** Return a sine, cosine or coordinate of an axis as -1, 0 or 1; NaN if it is none of them. */
function wholeOf(value: number): number {
  const whole = Math.round(value);
  return Math.abs(value - whole) < 1e-9 ? whole + 0 : NaN;
}

/** Return the formulas of an arm; `reversed` marks the joints whose d has the opposite sign in the table. */
export function deriveFormulas(arm: Arm, reversed: readonly boolean[] = []): Formulas | Reason {
  const count = arm.joints.length;
  if (count > MAX_FORMULA_JOINTS) return "joints";
  const angles: Variable[] = [];
  const lengths: Variable[] = [];
  const angleOf = arm.joints.map(({ kind }, i) =>
    kind === "R" ? angles.push({ latex: `\\theta_{${i + 1}}`, value: null }) - 1 : -1,
  );
  const addLength = (latex: string, value: number | null): number => lengths.push({ latex, value }) - 1;
  const lengthOf = (latex: string, value: number): number => (value === 0 ? -1 : addLength(latex, value));
  const rows = arm.joints.map(({ kind, otherConstant, a }, i) => {
    const indexOfA = lengthOf(`a_{${i + 1}}`, a);
    const d = `d_{${i + 1}}`;
    const isRevolute = kind === "R";
    return { a: indexOfA, d: isRevolute ? lengthOf(d, (reversed[i] ? -1 : 1) * otherConstant) : addLength(d, null) };
  });
  const tool = arm.point.offset.map((value, axis) => lengthOf(`p_{${"xyz"[axis]}}`, value));

  const size = angles.length + lengths.length;
  const powersOf = (index: number): number[] => Array.from({ length: size }, (_, k) => (k === index ? 1 : 0));
  const number = (value: number): Polynomial => (value === 0 ? ZERO : scale(monomial(powersOf(-1)), value));
  const length = (index: number): Polynomial => (index < 0 ? ZERO : monomial(powersOf(angles.length + index)));
  const combine = (a: Vector, f: Polynomial, b: Vector, g: Polynomial): Vector =>
    [0, 1, 2].map((k) => add(multiply(a[k]!, f), multiply(b[k]!, g))) as unknown as Vector;

  const baseAxis = (axis: readonly number[]): Vector =>
    axis.map((value) => number(wholeOf(value))) as unknown as Vector;
  const { x, y, z } = arm.base;
  if ([...x, ...y, ...z].some((value) => Number.isNaN(wholeOf(value)))) return "angles";
  const frames: SymbolicFrame[] = [{ x: baseAxis(x), y: baseAxis(y), z: baseAxis(z), o: [ZERO, ZERO, ZERO] }];
  for (const [i, joint] of arm.joints.entries()) {
    const frame = frames[i]!;
    const constantAngle = joint.kind === "R" ? joint.offset : joint.otherConstant;
    const [c0, s0] = [wholeOf(Math.cos(constantAngle)), wholeOf(Math.sin(constantAngle))];
    const [ca, sa] = [wholeOf(Math.cos(joint.alpha)), wholeOf(Math.sin(joint.alpha))];
    if ([c0, s0, ca, sa].some(Number.isNaN)) return "angles";
    const [c, s] = (["c", "s"] as const).map((kind) => wave(kind, powersOf(angleOf[i]!)));
    const isRevolute = joint.kind === "R";
    const cosine = isRevolute ? add(scale(c!, c0), scale(s!, -s0)) : number(c0);
    const sine = isRevolute ? add(scale(s!, c0), scale(c!, s0)) : number(s0);
    const x1 = combine(frame.x, cosine, frame.y, sine);
    const side = combine(frame.x, scale(sine, -1), frame.y, cosine);
    const d = isRevolute
      ? scale(length(rows[i]!.d), reversed[i] ? -1 : 1)
      : add(length(rows[i]!.d), number(joint.offset));
    const corner = combine(frame.o, number(1), frame.z, d);
    frames.push({
      x: x1,
      y: combine(side, number(ca), frame.z, number(sa)),
      z: combine(side, number(-sa), frame.z, number(ca)),
      o: combine(corner, number(1), x1, length(rows[i]!.a)),
    });
  }

  const last = frames[count]!;
  const point = (["x", "y", "z"] as const).reduce(
    (sum, axis, k) => combine(sum, number(1), last[axis], length(tool[k]!)),
    last.o,
  );
  const columns = arm.joints.map(({ kind }, i): Polynomial[] => {
    const { z, o } = frames[i]!;
    if (kind === "P") return [...z, ZERO, ZERO, ZERO];
    const r = combine(point, number(1), o, number(-1));
    const crossed = [0, 1, 2].map((k) => {
      const [m, n] = [(k + 1) % 3, (k + 2) % 3];
      return add(multiply(z[m]!, r[n]!), scale(multiply(z[n]!, r[m]!), -1));
    });
    return [...crossed, ...z];
  });
  const jacobian = arm.task.map((row) => columns.map((column) => column[row]!));

  // Groups of parallel joints, with the direction of each axis along the first one.
  const groups: { angle: number; direction: number }[][] = [];
  let direction = 0; // 0: the next joint begins a group
  arm.joints.forEach(({ alpha }, i) => {
    if (direction === 0) groups.push([]);
    if (direction === 0) direction = 1;
    if (angleOf[i]! >= 0) groups.at(-1)!.push({ angle: angleOf[i]!, direction });
    direction *= wholeOf(Math.cos(alpha));
  });
  const trigFactors = groups.flatMap((group) =>
    group.flatMap((_, i) =>
      group.slice(i).flatMap((_, k) => {
        const multiples = powersOf(-1);
        for (const { angle, direction } of group.slice(i, i + k + 1))
          multiples[angle] = direction * group[i]!.direction;
        return (["s", "c"] as const).map((kind) => wave(kind, multiples));
      }),
    ),
  );
  const entriesInFrames = frames.flatMap((frame) =>
    columns.flatMap((column) =>
      (["x", "y", "z"] as const).flatMap((axis) =>
        [0, 3].map((first) => add(...[0, 1, 2].map((k) => multiply(frame[axis][k]!, column[first + k]!)))),
      ),
    ),
  );
  const angleCount = angles.length;
  const angleGroups = groups.map((group) => group.map(({ angle }) => angle));
  const toReal = (f: Polynomial): RealTerm[] => realForm(f, angleGroups, angleCount);
  const context = { trigFactors, angleCount, toReal };
  const written = jacobian.map((row) => row.map((entry) => factorize(entry, [], context)));
  if (written.flat().some(isLong)) return "long";
  const det = jacobian.length === count ? deriveDeterminant(jacobian, entriesInFrames, context) : null;
  const formulas = { angles, lengths, jacobian: written, determinant: det };
  return agrees(arm, formulas, angleOf) ? formulas : "numbers";
}

const isLong = ({ factors }: Product): boolean => factors.some(({ terms }) => terms.length > MAX_TERMS);

/** Return the determinant of J as a product; "long" if it would take long, or is too long to be read. */
function deriveDeterminant(
  jacobian: readonly (readonly Polynomial[])[],
  entriesInFrames: readonly Polynomial[],
  context: FactorContext,
): Product | "long" {
  const largestInColumns = jacobian.map((_, j) => Math.max(1, ...jacobian.map((row) => row[j]!.size)));
  if (largestInColumns.reduce((product, size) => product * size, 1) > MAX_WORK) return "long";
  const product = factorize(expandDeterminant(jacobian), entriesInFrames, context);
  return isLong(product) ? "long" : product;
}

/** Return a determinant, expanded by its first row. */
function expandDeterminant([first, ...rest]: readonly (readonly Polynomial[])[]): Polynomial {
  if (rest.length === 0) return first![0]!;
  const minorOf = (j: number): Polynomial => expandDeterminant(rest.map((row) => row.filter((_, k) => k !== j)));
  return add(
    ...first!.map((entry, j) => (entry.size === 0 ? ZERO : scale(multiply(entry, minorOf(j)), j % 2 === 0 ? 1 : -1))),
  );
}

interface FactorContext {
  readonly trigFactors: readonly Polynomial[];
  readonly angleCount: number;
  readonly toReal: (f: Polynomial) => RealTerm[];
}

/** What remains of a polynomial without the lengths, sines and cosines that all its terms share, and these. */
type Stripped = {
  readonly rest: Polynomial;
  readonly powers: readonly number[];
  readonly found: readonly Polynomial[];
};

function strip(f: Polynomial, { trigFactors, angleCount }: FactorContext): Stripped {
  const exponents = [...f.values()].map((term) => term.exponents);
  const powers = (exponents[0] ?? []).map((_, i) =>
    i < angleCount ? 0 : Math.min(...exponents.map((powersOfTerm) => powersOfTerm[i]!)),
  );
  const withoutLengths = multiply(f, monomial(powers.map((power) => -power)));
  const [rest, found] = divideOut(withoutLengths, trigFactors);
  return { rest, powers: powers.slice(angleCount), found };
}

/** Divide a polynomial by some factors, as often as possible. */
function divideOut(f: Polynomial, factors: readonly Polynomial[]): [Polynomial, Polynomial[]] {
  const found: Polynomial[] = [];
  let rest = f;
  for (const factor of rest.size === 0 ? [] : factors)
    for (let next = divide(rest, factor); next; next = divide(rest, factor)) {
      rest = next;
      found.push(factor);
    }
  return [rest, found];
}

/** Return a polynomial as a product; factors of several terms are looked for in other polynomials. */
function factorize(f: Polynomial, others: readonly Polynomial[], context: FactorContext): Product {
  if (f.size === 0) return { number: 0, powers: [], factors: [] };
  const { rest, powers, found } = strip(f, context);
  const sums = others.map((other) => strip(other, context).rest).filter((sum) => context.toReal(sum).length > 1);
  const [remainder, foundSums] = divideOut(rest, sums);
  let number = 1;
  const factors: { terms: readonly RealTerm[]; power: number }[] = [];
  for (const factor of [...found, ...foundSums, remainder]) {
    const terms = context.toReal(factor);
    const least = Math.min(...terms.map(({ coefficient }) => Math.abs(coefficient)));
    const isCommon = terms.every(({ coefficient }) => Number.isInteger(coefficient / least));
    const sign = terms.every(({ coefficient }) => coefficient < 0) ? -1 : 1;
    const content = sign * (isCommon && (terms.length === 1 || Number.isInteger(Math.log2(least))) ? least : 1);
    number *= content;
    if (terms.length === 1 && terms[0]!.waves.length === 0 && terms[0]!.powers.every((power) => power === 0)) continue;
    const primitive = terms.map((term) => ({ ...term, coefficient: term.coefficient / content }));
    const same = factors.find(({ terms }) => JSON.stringify(terms) === JSON.stringify(primitive));
    if (same) same.power += 1;
    else factors.push({ terms: primitive, power: 1 });
  }
  return { number, powers, factors };
}

/** Return the value of a product, given those of angles (rad) and lengths (m). */
export function evaluateProduct(product: Product, angles: readonly number[], lengths: readonly number[]): number {
  const valueOf = (powers: readonly number[]): number =>
    powers.reduce((value, power, i) => value * lengths[i]! ** power, 1);
  const valueOfTerm = ({ coefficient, waves, powers }: RealTerm): number =>
    waves.reduce(
      (value, { kind, multiples }) => {
        const angle = dot(multiples, angles);
        return value * (kind === "s" ? Math.sin(angle) : Math.cos(angle));
      },
      coefficient * valueOf(powers),
    );
  return product.factors.reduce(
    (value, { terms, power }) => value * terms.reduce((sum, term) => sum + valueOfTerm(term), 0) ** power,
    product.number * valueOf(product.powers),
  );
}

/** Return whether formulas agree with the arm's numbers at random poses. */
function agrees(arm: Arm, formulas: Formulas, angleOf: readonly number[]): boolean {
  const { lengths, jacobian } = formulas;
  const isClose = (value: number, expected: number): boolean =>
    Math.abs(value - expected) <= 1e-8 * Math.max(1, Math.abs(expected));
  return makeRandomPoses(CHECKED_POSES, arm.joints.length, 17).every((pose) => {
    const variables = pose.filter((_, i) => angleOf[i]! < 0);
    const angles = pose.filter((_, i) => angleOf[i]! >= 0);
    const values = lengths.map(({ value }) => value ?? variables.shift()!);
    const evaluate = (product: Product): number => evaluateProduct(product, angles, values);
    const { taskJacobian } = stateAt(arm, pose);
    const det = formulas.determinant;
    return (
      jacobian.every((row, k) => row.every((entry, j) => isClose(evaluate(entry), taskJacobian[k]![j]!))) &&
      (det === null || det === "long" || isClose(evaluate(det), determinant(taskJacobian)))
    );
  });
}
