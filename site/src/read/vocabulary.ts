// The words, signs, units and habits of answers, shared with the grader's parser. Add a synonym there, and both know
// it.

import vocabulary from "../../../exercises/formula/vocabulary.json" with { type: "json" };

export const VOCABULARY = vocabulary;
export const LIMITS = vocabulary.limits;

/** A table of the vocabulary; a Map, in which no word of JavaScript's own objects is found. */
export function table<T>(entries: Readonly<Record<string, T>>): ReadonlyMap<string, T> {
  return new Map(Object.entries(entries));
}

/** A pattern as Python has it: \w, which stands in brackets only, is any letter or digit of any script. */
export function compiled(pattern: string, flags = ""): RegExp {
  return new RegExp(pattern.replaceAll("\\w", "\\p{L}\\p{N}_"), `u${flags}`);
}

/** One of the vocabulary's patterns, to be found anywhere. */
export function pattern(name: keyof typeof vocabulary.patterns, flags = ""): RegExp {
  return compiled(vocabulary.patterns[name], flags);
}

/** One of the vocabulary's patterns, which a whole text must be. */
export const whole = (name: keyof typeof vocabulary.patterns): RegExp => compiled(`^(?:${vocabulary.patterns[name]})$`);

/** Signs as they stand in a pattern for themselves. */
export const literally = (text: string): string => text.replace(/[\\^$.*+?()[\]{}|/]/g, "\\$&");

const SPACES = new Set(vocabulary.spaces);

export const isSpace = (sign: string | undefined): boolean => sign !== undefined && SPACES.has(sign);

/** A text without the spaces at its end; trimEnd takes other signs away, too, which Python does not. */
export function withoutSpacesAtEnd(text: string): string {
  let end = text.length;
  while (isSpace(text[end - 1])) end -= 1;
  return text.slice(0, end);
}

/** A text without spaces around it. */
export function stripped(text: string): string {
  let start = 0;
  while (isSpace(text[start])) start += 1;
  return withoutSpacesAtEnd(text.slice(start));
}

/** How many signs a text has, exactly if more than `most`: those outside the first plane count once, as in Python. */
export const lengthOf = (text: string, most: number): number => (text.length > most ? [...text].length : text.length);
