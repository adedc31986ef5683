// Singular values and vectors of small matrices by one-sided Jacobi rotations (Hestenes), and least squares with them.
//
// Columns of A V are made square to each other by plane rotations; their lengths are then the singular values. The
// small ones come out as exactly as the large ones, which is what nearness to a singularity is about.

import { dot, type Matrix, norm, times, transposed } from "./vector.js";

/** Singular values, largest first, as many as A has columns, and the right singular vectors that belong to them. */
export type Right = { readonly sigma: readonly number[]; readonly v: readonly (readonly number[])[] };

const SWEEPS = 30;

/** The right singular vectors of A, all of them: those past the rank span the null space. */
export function right(matrix: Matrix): Right {
  const columns = transposed(matrix);
  const v = columns.map((_, i) => columns.map((__, j) => (i === j ? 1 : 0)));
  for (let sweep = 0; sweep < SWEEPS && swept(columns, v); sweep += 1);
  const found = columns.map((column, j) => ({ size: norm(column), vector: v[j]! }));
  found.sort((a, b) => b.size - a.size);
  return { sigma: found.map(({ size }) => size), v: found.map(({ vector }) => vector) };
}

/** One pass over all pairs of columns; whether any of them had to be turned. */
function swept(columns: number[][], v: number[][]): boolean {
  let turned = false;
  for (let i = 0; i < columns.length; i += 1) {
    for (let j = i + 1; j < columns.length; j += 1) {
      const [a, b] = [columns[i]!, columns[j]!];
      const [aa, bb, ab] = [dot(a, a), dot(b, b), dot(a, b)];
      if (Math.abs(ab) <= 1e-15 * Math.sqrt(aa * bb) || Math.abs(ab) < 1e-300) continue;
      turned = true;
      const zeta = (bb - aa) / (2 * ab);
      const t = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.sqrt(1 + zeta * zeta));
      const c = 1 / Math.sqrt(1 + t * t);
      rotate(a, b, c, c * t);
      rotate(v[i]!, v[j]!, c, c * t);
    }
  }
  return turned;
}

function rotate(a: number[], b: number[], c: number, s: number): void {
  for (let k = 0; k < a.length; k += 1) {
    const [x, y] = [a[k]!, b[k]!];
    a[k] = c * x - s * y;
    b[k] = s * x + c * y;
  }
}

/** The min(m, n) singular values of an m x n matrix, largest first. */
export function singularValues(matrix: Matrix): readonly number[] {
  const rows = matrix.length;
  const columns = matrix[0]?.length ?? 0;
  const { sigma } = right(columns > rows ? transposed(matrix) : matrix);
  return sigma.slice(0, Math.min(rows, columns));
}

/** A principal axis of a symmetric matrix: an eigenvalue and its unit vector. */
export type Axis = { readonly value: number; readonly vector: readonly number[] };

/** The principal axes of a symmetric matrix A, largest value first: the right singular vectors of A + c I > 0. */
export function axesOf(symmetric: Matrix): Axis[] {
  const shift = Math.max(...symmetric.map((row) => row.reduce((sum, value) => sum + Math.abs(value), 0)), 1e-9);
  const { sigma, v } = right(symmetric.map((row, i) => row.map((value, j) => (i === j ? value + shift : value))));
  return sigma.map((size, k) => ({ value: size - shift, vector: v[k]! }));
}

/** The shortest x that brings A x nearest to b; `damping` (as large as small singular values) keeps x bounded. */
export function leastSquares(matrix: Matrix, b: readonly number[], damping = 0): number[] {
  const { sigma, v } = right(matrix);
  const x = v.map(() => 0);
  const floor = 1e-12 * (sigma[0] ?? 0);
  v.forEach((vector, k) => {
    const s = sigma[k]!;
    if (s <= floor) return;
    const share = dot(times(matrix, vector), b) / (s * s + damping * damping);
    vector.forEach((value, i) => (x[i] = x[i]! + share * value));
  });
  return x;
}

/** A^T (A A^T + damping^2)^-1 b, by elimination: ten times as fast as by singular values, less exact near rank loss. */
export function damped(matrix: Matrix, b: readonly number[], damping: number): number[] {
  const count = matrix.length;
  const rows = matrix.map((row, i) => [
    ...matrix.map((other, j) => dot(row, other) + (i === j ? damping * damping : 0)),
    b[i]!,
  ]);
  for (let k = 0; k < count; k += 1) {
    const pivot = rows[k]!;
    if (!(pivot[k]! > 0)) return leastSquares(matrix, b, damping);
    for (let i = k + 1; i < count; i += 1) {
      const share = rows[i]![k]! / pivot[k]!;
      for (let j = k; j <= count; j += 1) rows[i]![j] = rows[i]![j]! - share * pivot[j]!;
    }
  }
  const y = rows.map(() => 0);
  for (let k = count - 1; k >= 0; k -= 1) {
    let sum = rows[k]![count]!;
    for (let j = k + 1; j < count; j += 1) sum -= rows[k]![j]! * y[j]!;
    y[k] = sum / rows[k]![k]!;
  }
  return (matrix[0] ?? []).map((_, j) => matrix.reduce((sum, row, i) => sum + row[j]! * y[i]!, 0));
}
