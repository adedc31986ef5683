// Replace decimal commas by points.

/** A digit of any script, but no superscript. */
const DIGIT = /\p{Nd}/u;
/** Text before a bracket that only groups: it ends in an operator, or a function of one argument. */
const BEFORE_GROUPING_BRACKET =
  /(?:[-+*/^=·−]|\b(?:sin|cos|tan|sqrt|exp|abs|asin|acos|atan|arcsin|arccos|arctan))\s*$/u;
/** Text before a bracket of arguments: it ends in a function or a name. */
const BEFORE_ARGUMENTS = /[\p{L}\p{Nd}_]\s*$/u;
/** Text after a bracket that only groups: it begins with an operator. */
const AFTER_GROUPING_BRACKET = /^\s*[-+*/^·−]/u;

/** Write the commas of numbers as in 0,5 as points, but not commas between entries and arguments. */
export function readCommasAsPoints(text: string): string {
  if (!text.includes(",")) return text;
  const signs = [...text];
  const groupingFlags: boolean[] = []; // for each open bracket, outermost first: whether it only groups
  return signs
    .map((sign, i) => {
      if ("([{".includes(sign)) groupingFlags.push(sign === "(" && isGroupingBracket(signs, i));
      if (")]}".includes(sign)) groupingFlags.pop();
      const isBetweenDigits = DIGIT.test(signs[i - 1] ?? "") && DIGIT.test(signs[i + 1] ?? "");
      return sign === "," && isBetweenDigits && (groupingFlags.at(-1) ?? true) ? "." : sign;
    })
    .join("");
}

/** Return whether the bracket opened at index `open` only groups: an operation or function applies to it. */
function isGroupingBracket(signs: readonly string[], open: number): boolean {
  let depth = 0;
  const close = signs.findIndex((sign, i) => {
    if (i < open) return false;
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    return depth === 0;
  });
  const textBefore = signs.slice(0, open).join("");
  const textAfter = close < 0 ? "" : signs.slice(close + 1).join("");
  return (
    BEFORE_GROUPING_BRACKET.test(textBefore) ||
    (!BEFORE_ARGUMENTS.test(textBefore) && AFTER_GROUPING_BRACKET.test(textAfter))
  );
}
