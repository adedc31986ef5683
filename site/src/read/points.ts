// Read decimal commas as points.

/** A digit of any script, but no superscript. */
const DIGIT = /\p{Nd}/u;
/** What precedes a bracket that only groups: an operator, or a function of one argument. */
const GROUPS_AFTER = /(?:[-+*/^=·−]|\b(?:sin|cos|tan|sqrt|exp|abs|asin|acos|atan|arcsin|arccos|arctan))\s*$/u;
/** What precedes a bracket of arguments: a function or a name. */
const CALLED = /[\p{L}\p{Nd}_]\s*$/u;
const GROUPS_BEFORE = /^\s*[-+*/^·−]/u;

/** Write the commas of numbers as in 0,5 as points, but not commas between entries and arguments. */
export function withPoints(text: string): string {
  if (!text.includes(",")) return text;
  const signs = [...text];
  const groups: boolean[] = []; // for each open bracket: whether it only groups
  return signs
    .map((sign, i) => {
      if ("([{".includes(sign)) groups.push(sign === "(" && onlyGroups(signs, i));
      if (")]}".includes(sign)) groups.pop();
      const between = DIGIT.test(signs[i - 1] ?? "") && DIGIT.test(signs[i + 1] ?? "");
      return sign === "," && between && (groups.at(-1) ?? true) ? "." : sign;
    })
    .join("");
}

/** Return whether a bracket only groups and is no list: an operation or a function is applied to it. */
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
