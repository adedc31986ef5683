// Prompts without instructions on how to type an answer in a notebook: letters are ticked on the page, and the field for
// a set of configurations has its own instructions.

import type { AskedPart } from "../bank.js";

const OPTIONS = /<ul>\s*<li>\s*(?:<p>)?<strong>A\.<\/strong>[\s\S]*?<\/ul>/;
/** The paragraph of a prompt that says how letters are typed: "the letter, typed in quotes, for example …". */
const LETTER_INSTRUCTIONS =
  /<p><strong>[^<]*<\/strong>(?:(?!<\/p>)[\s\S])*<code>(?:&quot;|")(?:[A-H]+|true)(?:&quot;|")<\/code>[\s\S]*?<\/p>/;

/** The paragraph of a prompt with examples of conditions in a notebook, such as "[Eq(cos(theta1), 0)]". */
const CONDITION_INSTRUCTIONS = /<p><strong>[^<]*<\/strong>(?:(?!<\/p>)[\s\S])*<code>\[Eq\([\s\S]*?<\/p>/;

/** Return the prompt without its options, which are fields on the page, and without instructions for notebooks. */
export function removeOptions(part: AskedPart): string {
  if (part.key.type === "configurations") return part.prompt.replace(CONDITION_INSTRUCTIONS, "");
  return part.options === null ? part.prompt : removeLetterInstructions(part).replace(OPTIONS, "");
}

/** Return the prompt with its options, without the instructions on letters. */
export function removeLetterInstructions({ options, prompt }: AskedPart): string {
  return options === null ? prompt : prompt.replace(LETTER_INSTRUCTIONS, "");
}
