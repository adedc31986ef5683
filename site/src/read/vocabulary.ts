// The words, signs, units and notations of answers, shared with the grader's parser: add a synonym there for both.

import vocabulary from "../../../exercises/formula/vocabulary.json" with { type: "json" };

export const VOCABULARY = vocabulary;
export const LIMITS = vocabulary.limits;

/** Return a table of the vocabulary as a Map, which contains no names of JavaScript's own objects. */
export function table<T>(entries: Readonly<Record<string, T>>): ReadonlyMap<string, T> {
  return new Map(Object.entries(entries));
}

/** Compile a pattern of Python: \w, which occurs only in brackets, matches letters and digits of any script. */
export function compile(pattern: string, flags = ""): RegExp {
  return new RegExp(pattern.replaceAll("\\w", "\\p{L}\\p{N}_"), `u${flags}`);
}

/** Compile one of the vocabulary's patterns, to be found anywhere. */
export function pattern(name: keyof typeof vocabulary.patterns, flags = ""): RegExp {
  return compile(vocabulary.patterns[name], flags);
}

/** Compile one of the vocabulary's patterns, which must match the whole text. */
export const wholePattern = (name: keyof typeof vocabulary.patterns): RegExp =>
  compile(`^(?:${vocabulary.patterns[name]})$`);

/** Escape signs that have a meaning in patterns. */
export const escapeSigns = (text: string): string => text.replace(/[\\^$.*+?()[\]{}|/]/g, "\\$&");

/** Return a pattern for any of some texts, which tries longer ones first. */
export const anyOf = (texts: Iterable<string>, escape = escapeSigns): string =>
  [...texts]
    .sort((a, b) => b.length - a.length || (a < b ? -1 : 1))
    .map(escape)
    .join("|");

/** By unit, the text after a number that converts it to SI units, such as "*pi/180"; "" for SI units. */
export const UNITS = table(vocabulary.units);
/** By superscript, the plain digit or sign. */
export const SUPERSCRIPTS = table(vocabulary.superscripts);
/** By a name such as xdot, the name of the velocity, such as vx. */
const VELOCITIES = table<string>(vocabulary.velocities);

/** Return a name as symbols are spelled: vx for x_dot, and wx for omega_x. */
export function respell(name: string): string {
  let spelling = name.replaceAll("_", "");
  for (const [spelled, letter] of Object.entries(vocabulary.spelled_letters))
    spelling = spelling.replaceAll(spelled, letter);
  return VELOCITIES.get(spelling) ?? spelling;
}

const SPACES = new Set(vocabulary.spaces);

export const isSpace = (sign: string | undefined): boolean => sign !== undefined && SPACES.has(sign);

/** Remove the spaces at the end of a text; trimEnd also removes signs that Python's rstrip keeps. */
export function stripEnd(text: string): string {
  let end = text.length;
  while (isSpace(text[end - 1])) end -= 1;
  return text.slice(0, end);
}

/** Remove the spaces around a text. */
export function strip(text: string): string {
  let start = 0;
  while (isSpace(text[start])) start += 1;
  return stripEnd(text.slice(start));
}

/** Return the number of characters of a text as Python counts them, if its UTF-16 length exceeds `limit`; else that. */
export const countCharacters = (text: string, limit: number): number =>
  text.length > limit ? [...text].length : text.length;
