// Prompts without the instructions on how to type letters, because they are ticked on the page and written on paper.

import type { Part } from "../bank.js";

const OPTIONS = /<ul>\s*<li>\s*(?:<p>)?<strong>A\.<\/strong>[\s\S]*?<\/ul>/;
/** The paragraph of a prompt that says how letters are typed: "the letter, typed in quotes, for example …". */
const LETTER_INSTRUCTIONS =
  /<p><strong>[^<]*<\/strong>(?:(?!<\/p>)[\s\S])*<code>(?:&quot;|")(?:[A-H]+|true)(?:&quot;|")<\/code>[\s\S]*?<\/p>/;

/** Return the prompt without its options, which are fields on the page, and without the instructions on letters. */
export function removeOptions(part: Part): string {
  return part.options === null ? part.prompt : removeLetterInstructions(part).replace(OPTIONS, "");
}

/** Return the prompt with its options, without the instructions on letters. */
export function removeLetterInstructions({ options, prompt }: Part): string {
  return options === null ? prompt : prompt.replace(LETTER_INSTRUCTIONS, "");
}
