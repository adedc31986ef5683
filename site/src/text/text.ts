// Texts by key in the language of the page, with numbers as that language writes them.

import { type Catalogue, en, type TextKey } from "./en.js";

/** What is filled into a text: words as they stand, numbers, or another text. */
export type Values = { readonly [name: string]: string | number | Message };

/** A text that is to be shown: its key, and what is filled in. */
export interface Message {
  readonly key: TextKey;
  readonly values: Values;
}

export function message(key: TextKey, values: Values = {}): Message {
  return { key, values };
}

export interface Language {
  readonly code: string;
  readonly catalogue: Catalogue;
}

export const ENGLISH: Language = { code: "en", catalogue: en };

let page = ENGLISH;

/** The language in which the page speaks. */
export function language(): Language {
  return page;
}

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

/** A number with at most six significant digits. */
export function inDigits(value: number, spoken: Language = page): string {
  let format = formats.get(spoken.code);
  if (!format) {
    format = new Intl.NumberFormat(spoken.code, { maximumSignificantDigits: 6, useGrouping: false });
    formats.set(spoken.code, format);
  }
  return format.format(value);
}

/** By language: browsers take long to make one. */
const formats = new Map<string, Intl.NumberFormat>();
