// The decimal comma.

/** A text with the commas of numbers as in 0,5 written as points, those inside brackets left alone. */
export function withPoints(text: string): string {
  if (!text.includes(",")) return text;
  let depth = 0;
  return [...text]
    .map((sign, i, all) => {
      depth += Number("([{".includes(sign)) - Number(")]}".includes(sign));
      const between = /\d/.test(all[i - 1] ?? "") && /\d/.test(all[i + 1] ?? "");
      return sign === "," && depth === 0 && between ? "." : sign;
    })
    .join("");
}
