// Prompts without what is said in them of typing letters, which are ticked on the page and written on paper.

import type { Part } from "../bank.js";

const OPTIONS = /<ul>\s*<li>\s*(?:<p>)?<strong>A\.<\/strong>[\s\S]*?<\/ul>/;
/** The paragraph on the answer: "the letter, typed in quotes, as in …". */
const ON_LETTERS =
  /<p><strong>[^<]*<\/strong>(?:(?!<\/p>)[\s\S])*<code>(?:&quot;|")(?:[A-H]+|true)(?:&quot;|")<\/code>[\s\S]*?<\/p>/;

/** The prompt without its options, which are there to be chosen, and without how their letters are typed. */
export function promptOf(part: Part): string {
  return part.options === null ? part.prompt : promptOnPaper(part).replace(OPTIONS, "");
}

/** The prompt with its options, without how their letters are typed. */
export function promptOnPaper({ options, prompt }: Part): string {
  return options === null ? prompt : prompt.replace(ON_LETTERS, "");
}
