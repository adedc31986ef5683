// The page's texts by key in its language, with numbers formatted for this language.

import english from "./en.json" with { type: "json" };

/** The keys of texts. English has every text, with `{name}` for values; other languages have the same keys. */
export type TextKey = keyof typeof english;
type Catalogue = Readonly<Record<TextKey, string>>;

/** Values to insert into a text: words, numbers, or another text. */
export type Values = { readonly [name: string]: string | number | Message };

/** A text to be shown: its key and the inserted values. */
export type Message = { readonly key: TextKey; readonly values: Values };

export const message = (key: TextKey, values: Values = {}): Message => ({ key, values });

export type Language = { readonly code: string; readonly catalogue: Catalogue };

export const ENGLISH: Language = { code: "en", catalogue: english };

let pageLanguage = ENGLISH;

/** Return the language of the page. */
export const getLanguage = (): Language => pageLanguage;

export function setLanguage(language: Language): void {
  pageLanguage = language;
}

/** Return the text of a message; numbers have the language's decimal sign, and never separators of thousands. */
export function textOf({ key, values }: Message, inLanguage: Language = pageLanguage): string {
  return inLanguage.catalogue[key].replace(/\{([\w-]+)\}/g, (_, name: string) => {
    const value = values[name] ?? "";
    if (typeof value === "object") return textOf(value, inLanguage);
    return typeof value === "number" ? formatNumber(value, inLanguage) : value;
  });
}

/** Return a text of the catalogue in the page's language. */
export const say = (key: TextKey, values: Values = {}): string => textOf(message(key, values));

/** Return names of symbols as the page shows them: θ1 for theta1. */
export const withGreek = (names: string): string => names.replaceAll("theta", "θ");

/** Return the decimal sign of the page's language: a point or a comma. */
export const decimalSign = (): string => pageLanguage.catalogue["number.point"];

/** Return the separator of listed numbers: a comma, or a semicolon if the decimal sign is a comma. */
export const numberSeparator = (): string => (decimalSign() === "," ? "; " : ", ");

/** Format a number with at most six significant digits and a true minus sign; Intl.NumberFormat starts slowly. */
export function formatNumber(value: number, inLanguage: Language = pageLanguage): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value < 0 ? "−∞" : "∞";
  const [mantissa = "", exponent = ""] = Math.abs(value).toExponential(5).split("e");
  const digits = mantissa.replace(".", "").replace(/0+$/, "");
  const wholeDigits = Number(exponent) + 1; // so many digits stand before the decimal sign
  const before = wholeDigits > 0 ? digits.slice(0, wholeDigits).padEnd(wholeDigits, "0") : "0";
  const after = wholeDigits > 0 ? digits.slice(wholeDigits) : digits && "0".repeat(-wholeDigits) + digits;
  const sign = value < 0 || Object.is(value, -0) ? "−" : "";
  return sign + before + (after && inLanguage.catalogue["number.point"] + after);
}

/** Format a number of points, rounded to two decimals. */
export const formatRounded = (value: number): string => formatNumber(Math.round(value * 100) / 100);
