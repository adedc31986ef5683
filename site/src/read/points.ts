// The decimal comma.

/** A digit of any script, but none that is raised. */
const DIGIT = /\p{Nd}/u;
/** What stands before a bracket that only groups: a sign of an operation, or a function of one argument. */
const GROUPS_AFTER = /(?:[-+*/^=·−]|\b(?:sin|cos|tan|sqrt|exp|abs|asin|acos|atan|arcsin|arccos|arctan))\s*$/u;
/** A function of several, or a name. */
const CALLED = /[\p{L}\p{Nd}_]\s*$/u;
const GROUPS_BEFORE = /^\s*[-+*/^·−]/u;

/** A text with the commas of numbers as in 0,5 written as points, but not those between entries and arguments. */
export function withPoints(text: string): string {
  if (!text.includes(",")) return text;
  const signs = [...text];
  const groups: boolean[] = []; // of each bracket that is open, whether it only groups
  return signs
    .map((sign, i) => {
      if ("([{".includes(sign)) groups.push(sign === "(" && onlyGroups(signs, i));
      if (")]}".includes(sign)) groups.pop();
      const between = DIGIT.test(signs[i - 1] ?? "") && DIGIT.test(signs[i + 1] ?? "");
      return sign === "," && between && (groups.at(-1) ?? true) ? "." : sign;
    })
    .join("");
}

/** Whether a bracket belongs to a formula, and is no list: something is done with it, or a function is taken of it. */
function onlyGroups(signs: readonly string[], open: number): boolean {
  let depth = 0;
  const close = signs.findIndex((sign, i) => {
    if (i < open) return false;
    depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
    return depth === 0;
  });
  const before = signs.slice(0, open).join("");
  const after = close < 0 ? "" : signs.slice(close + 1).join("");
  return GROUPS_AFTER.test(before) || (!CALLED.test(before) && GROUPS_BEFORE.test(after));
}
