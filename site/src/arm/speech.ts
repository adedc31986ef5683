// Numbers of the arm as they are shown, and the unit of its angles.

import { createContext } from "preact";

/** Whether angles are told in radians, as in a table that is typed so; else in degrees. */
export const InRadians = createContext(false);

/** A number with so many decimals, none of them needless, and no minus before a zero. */
export function decimals(value: number, count: number): number {
  const rounded = Number(value.toFixed(count));
  return rounded === 0 ? 0 : rounded;
}

/** Three significant digits. */
export const digits = (value: number): number => (Math.abs(value) < 5e-7 ? 0 : Number(value.toPrecision(3)));

/** An angle in its unit, with a decimal in degrees and three in radians. */
export const angleIn = (radians: boolean, angle: number): number => (radians ? decimals(angle, 3) : degrees(angle));

export const degrees = (angle: number): number => decimals((angle * 180) / Math.PI, 1);
