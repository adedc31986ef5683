// Texts by key in the language of the page, with numbers as that language writes them.

import english from "./en.json" with { type: "json" };

/** English has every text, `{name}` is filled in; another language has the same keys. */
export type TextKey = keyof typeof english;
export type Catalogue = Readonly<Record<TextKey, string>>;

/** What is filled into a text: words as they stand, numbers, or another text. */
export type Values = { readonly [name: string]: string | number | Message };

/** A text that is to be shown: its key, and what is filled in. */
export type Message = { readonly key: TextKey; readonly values: Values };

export const message = (key: TextKey, values: Values = {}): Message => ({ key, values });

export type Language = { readonly code: string; readonly catalogue: Catalogue };

export const ENGLISH: Language = { code: "en", catalogue: english };

let page = ENGLISH;

/** The language in which the page speaks. */
export const language = (): Language => page;

export function speak(chosen: Language): void {
  page = chosen;
}

/** The text of a message; numbers are written with the language's decimal sign, never with separators of thousands. */
export function said({ key, values }: Message, spoken: Language = page): string {
  return spoken.catalogue[key].replace(/\{([\w-]+)\}/g, (_, name: string) => {
    const value = values[name] ?? "";
    if (typeof value === "object") return said(value, spoken);
    return typeof value === "number" ? inDigits(value, spoken) : value;
  });
}

/** A text of the catalogue in the language of the page. */
export const say = (key: TextKey, values: Values = {}): string => said(message(key, values));

/** A number with at most six significant digits and a true minus sign, like Intl.NumberFormat, which starts slowly. */
export function inDigits(value: number, spoken: Language = page): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value < 0 ? "−∞" : "∞";
  const [mantissa = "", exponent = ""] = Math.abs(value).toExponential(5).split("e");
  const digits = mantissa.replace(".", "").replace(/0+$/, "");
  const whole = Number(exponent) + 1; // so many digits stand before the decimal sign
  const before = whole > 0 ? digits.slice(0, whole).padEnd(whole, "0") : "0";
  const after = whole > 0 ? digits.slice(whole) : digits && "0".repeat(-whole) + digits;
  const sign = value < 0 || Object.is(value, -0) ? "−" : "";
  return sign + before + (after && spoken.catalogue["number.point"] + after);
}
