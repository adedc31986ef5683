// The decimal comma.

/** A digit of any script, but none that is raised. */
const DIGIT = /\p{Nd}/u;

/** A text with the commas of numbers as in 0,5 written as points, those inside brackets left alone. */
export function withPoints(text: string): string {
  if (!text.includes(",")) return text;
  let depth = 0;
  return [...text]
    .map((sign, i, all) => {
      depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
      const between = DIGIT.test(all[i - 1] ?? "") && DIGIT.test(all[i + 1] ?? "");
      return sign === "," && depth === 0 && between ? "." : sign;
    })
    .join("");
}
