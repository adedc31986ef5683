// Singular values and vectors of small matrices by one-sided Jacobi rotations (Hestenes), and least squares by them.
//
// Plane rotations make the columns of A V orthogonal; their lengths are then the singular values. Small values are as
// accurate as large ones, which matters near singularities.

import { dot, type Matrix, norm, multiply, transpose } from "./vector.js";

/** The singular values, largest first, one for each column of A, and their right singular vectors. */
type RightSingular = { readonly sigma: readonly number[]; readonly v: readonly (readonly number[])[] };

const MAX_SWEEPS = 30;

/** Return all right singular vectors of A; those after the rank span the null space. */
export function decompose(matrix: Matrix): RightSingular {
  const columns = transpose(matrix);
  const v = columns.map((_, i) => columns.map((__, j) => (i === j ? 1 : 0)));
  for (let k = 0; k < MAX_SWEEPS && sweepColumns(columns, v); k += 1);
  const pairs = columns.map((column, j) => ({ size: norm(column), vector: v[j]! }));
  pairs.sort((a, b) => b.size - a.size);
  return { sigma: pairs.map(({ size }) => size), v: pairs.map(({ vector }) => vector) };
}

/** Rotate each pair of columns once; return whether any pair was rotated. */
function sweepColumns(columns: number[][], v: number[][]): boolean {
  let hasRotated = false;
  for (let i = 0; i < columns.length; i += 1) {
    for (let j = i + 1; j < columns.length; j += 1) {
      const [a, b] = [columns[i]!, columns[j]!];
      const [aa, bb, ab] = [dot(a, a), dot(b, b), dot(a, b)];
      if (Math.abs(ab) <= 1e-15 * Math.sqrt(aa * bb) || Math.abs(ab) < 1e-300) continue;
      hasRotated = true;
      const zeta = (bb - aa) / (2 * ab);
      const t = (zeta < 0 ? -1 : 1) / (Math.abs(zeta) + Math.sqrt(1 + zeta * zeta));
      const c = 1 / Math.sqrt(1 + t * t);
      rotate(a, b, c, c * t);
      rotate(v[i]!, v[j]!, c, c * t);
    }
  }
  return hasRotated;
}

function rotate(a: number[], b: number[], c: number, s: number): void {
  for (let k = 0; k < a.length; k += 1) {
    const [x, y] = [a[k]!, b[k]!];
    a[k] = c * x - s * y;
    b[k] = s * x + c * y;
  }
}

/** Return the min(m, n) singular values of an m x n matrix, largest first. */
export function singularValues(matrix: Matrix): readonly number[] {
  const rows = matrix.length;
  const columns = matrix[0]?.length ?? 0;
  const { sigma } = decompose(columns > rows ? transpose(matrix) : matrix);
  return sigma.slice(0, Math.min(rows, columns));
}

/** A principal axis of a symmetric matrix: an eigenvalue and its unit vector. */
export type Axis = { readonly value: number; readonly vector: readonly number[] };

/** Return the principal axes of a symmetric matrix A, largest eigenvalue first, by the SVD of A + c I > 0. */
export function axesOf(symmetric: Matrix): Axis[] {
  const shift = Math.max(...symmetric.map((row) => row.reduce((sum, value) => sum + Math.abs(value), 0)), 1e-9);
  const { sigma, v } = decompose(symmetric.map((row, i) => row.map((value, j) => (i === j ? value + shift : value))));
  return sigma.map((size, k) => ({ value: size - shift, vector: v[k]! }));
}

/** Return the shortest x that minimises |A x - b|; a `damping` as large as small singular values bounds x. */
export function leastSquares(matrix: Matrix, b: readonly number[], damping = 0): number[] {
  const { sigma, v } = decompose(matrix);
  const x = v.map(() => 0);
  const floor = 1e-12 * (sigma[0] ?? 0);
  v.forEach((vector, k) => {
    const s = sigma[k]!;
    if (s <= floor) return;
    const component = dot(multiply(matrix, vector), b) / (s * s + damping * damping);
    vector.forEach((value, i) => (x[i] = x[i]! + component * value));
  });
  return x;
}

/** Return A^T (A A^T + damping^2)^-1 b by elimination: ten times as fast as the SVD, less exact near rank loss. */
export function solveDamped(matrix: Matrix, b: readonly number[], damping: number): number[] {
  const count = matrix.length;
  const rows = matrix.map((row, i) => [
    ...matrix.map((other, j) => dot(row, other) + (i === j ? damping * damping : 0)),
    b[i]!,
  ]);
  for (let k = 0; k < count; k += 1) {
    const pivot = rows[k]!;
    if (!(pivot[k]! > 0)) return leastSquares(matrix, b, damping);
    for (let i = k + 1; i < count; i += 1) {
      const factor = rows[i]![k]! / pivot[k]!;
      for (let j = k; j <= count; j += 1) rows[i]![j] = rows[i]![j]! - factor * pivot[j]!;
    }
  }
  const y = rows.map(() => 0);
  for (let k = count - 1; k >= 0; k -= 1) {
    let sum = rows[k]![count]!;
    for (let j = k + 1; j < count; j += 1) sum -= rows[k]![j]! * y[j]!;
    y[k] = sum / rows[k]![k]!;
  }
  return multiply(transpose(matrix), y);
}
