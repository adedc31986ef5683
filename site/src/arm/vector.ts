// Vectors in space and small dense matrices (lists of rows).

export type Vec3 = readonly [number, number, number];
export type Matrix = readonly (readonly number[])[];

/** Return the number from `low` to `high` that is nearest to a value. */
export const clamp = (value: number, low: number, high: number): number => Math.max(low, Math.min(high, value));

export const ZERO: Vec3 = [0, 0, 0];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export const scaleVector = (a: Vec3, factor: number): Vec3 => [a[0] * factor, a[1] * factor, a[2] * factor];

/** Return a + by b. */
export const addScaled = (a: Vec3, b: Vec3, factor: number): Vec3 => [
  a[0] + factor * b[0],
  a[1] + factor * b[1],
  a[2] + factor * b[2],
];

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Return the inner product of two vectors of equal length. */
export function dot(a: readonly number[], b: readonly number[]): number {
  let sum = 0;
  for (let i = 0; i < a.length; i += 1) sum += (a[i] as number) * (b[i] as number);
  return sum;
}

export const norm = (a: readonly number[]): number => Math.sqrt(dot(a, a));

/** Return the unit vector along a vector; zero stays zero. */
export function unit(a: Vec3): Vec3 {
  const size = norm(a);
  return size > 0 ? scaleVector(a, 1 / size) : ZERO;
}

/** Return the product of a matrix and a vector. */
export const multiply = (matrix: Matrix, v: readonly number[]): number[] => matrix.map((row) => dot(row, v));

export function transpose(matrix: Matrix): number[][] {
  return (matrix[0] ?? []).map((_, j) => matrix.map((row) => row[j] as number));
}

/** Return the determinant of a square matrix, by elimination with the largest pivot. */
export function determinant(matrix: Matrix): number {
  const rows = matrix.map((row) => [...row]);
  let product = 1;
  for (let k = 0; k < rows.length; k += 1) {
    let pivotRow = k;
    for (let i = k + 1; i < rows.length; i += 1) {
      if (Math.abs(rows[i]![k]!) > Math.abs(rows[pivotRow]![k]!)) pivotRow = i;
    }
    const pivot = rows[pivotRow]!;
    if (pivot[k] === 0) return 0;
    if (pivotRow !== k) {
      rows[pivotRow] = rows[k]!;
      rows[k] = pivot;
      product = -product;
    }
    product *= pivot[k]!;
    for (let i = k + 1; i < rows.length; i += 1) {
      const row = rows[i]!;
      const factor = row[k]! / pivot[k]!;
      for (let j = k; j < row.length; j += 1) row[j] = row[j]! - factor * pivot[j]!;
    }
  }
  return product;
}
