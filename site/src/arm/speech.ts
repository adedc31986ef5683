// The language of the page for the arm's parts, and the numbers in it.

import { createContext } from "preact";
import { useContext } from "preact/hooks";

import type { TextKey } from "../text/en.js";
import { ENGLISH, inDigits, type Language, message, said, type Values } from "../text/text.js";

export const Spoken = createContext<Language>(ENGLISH);

/** Whether angles are told in radians, as in a table that is typed so; else in degrees. */
export const InRadians = createContext(false);

/** A text of the catalogue in the page's language. */
export type Say = (key: TextKey, values?: Values) => string;

export function useSay(): Say {
  const language = useContext(Spoken);
  return sayIn(language);
}

/** The same outside of a component; numbers get a true minus sign. */
export function sayIn(language: Language): Say {
  return (key, values) => said(message(key, values), language).replace(/-(?=\d)/g, "−");
}

/** A number in the page's language, with a true minus sign. */
export function useDigits(): (value: number) => string {
  const language = useContext(Spoken);
  return (value) => inDigits(value, language).replace("-", "−");
}

/** A number with so many decimals, none of them needless, and no minus before a zero. */
export function decimals(value: number, count: number): number {
  const rounded = Number(value.toFixed(count));
  return rounded === 0 ? 0 : rounded;
}

/** Three significant digits. */
export function digits(value: number): number {
  return Math.abs(value) < 5e-7 ? 0 : Number(value.toPrecision(3));
}

/** An angle in its unit, with a decimal in degrees and three in radians. */
export function angleIn(radians: boolean, angle: number): number {
  return radians ? decimals(angle, 3) : degrees(angle);
}

export function degrees(angle: number): number {
  return decimals((angle * 180) / Math.PI, 1);
}
