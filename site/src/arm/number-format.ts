// Numbers of the arm as they are shown, and the unit of its angles.

import { createContext } from "preact";

/** Whether angles are shown in radians, as in a table typed in radians; else in degrees. */
export const InRadians = createContext(false);

/** Round to a number of decimals; −0 becomes 0. */
export function roundToDecimals(value: number, count: number): number {
  const rounded = Number(value.toFixed(count));
  return rounded === 0 ? 0 : rounded;
}

/** Round to three significant digits. */
export const roundToDigits = (value: number): number => (Math.abs(value) < 5e-7 ? 0 : Number(value.toPrecision(3)));

/** Convert an angle (rad) to the shown unit: radians with three decimals, or degrees with one. */
export const convertAngle = (inRadians: boolean, angle: number): number =>
  inRadians ? roundToDecimals(angle, 3) : toDegrees(angle);

export const toDegrees = (angle: number): number => roundToDecimals((angle * 180) / Math.PI, 1);
