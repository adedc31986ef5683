// Units of numbers, as in m/s^2: their conversion to SI units, and their dimension.
// The rules of ../../../exercises/formula/units.py; ../../tests/readers.test.ts compares both.

import { anyOf, compile, pattern, SUPERSCRIPTS, UNITS, VOCABULARY } from "./vocabulary.js";

/** The text after a number that converts it to SI units, as "/100" for cm; and the powers of kg, m and s. */
export type Unit = { readonly conversion: string; readonly dimension: readonly number[] };

const BASE_UNITS = new Map(Object.entries(VOCABULARY.base_units as Record<string, (string | number)[]>));
const POWER = `(?:${VOCABULARY.patterns.power_of_unit})`;
const SEPARATOR = `(?:${VOCABULARY.patterns.between_units})`;
const NAMES = anyOf(BASE_UNITS.keys());
const UNIT = `(?:1 ?/ ?)?(?:${NAMES})${POWER}?(?:${SEPARATOR}(?:${NAMES})${POWER}?){0,4}`;
const WHOLE_UNIT = compile(`^(?:${UNIT})$`);
const FACTOR = compile(`(${SEPARATOR})(${NAMES})(${POWER}?)`, "g");
const VALUE_WITH_UNIT = compile(
  `(?:(?<=[0-9.]) ?|${VOCABULARY.patterns.before_unit})(?:(${UNIT})|\\[ ?(${UNIT}) ?\\])${VOCABULARY.patterns.after_unit}`,
  "g",
);
const LATEX_UNIT = pattern("latex_unit", "g");
const NAME_OF_NUMBER = pattern("name_of_number", "g");
/** At most this many units of an answer are found. */
const MAX_UNITS = 100;

/** Return a unit without spaces around its slash, as the vocabulary writes it. */
export const normalizeUnit = (typedUnit: string): string => typedUnit.replace(" /", "/").replace("/ ", "/");

/** Return the unit that a text names; null if there is no such unit. */
export function parseUnit(text: string): Unit | null {
  if (text === "" || text === "1") return { conversion: "", dimension: [0, 0, 0] };
  if (!WHOLE_UNIT.test(text)) return null;
  const multipliers: string[] = [];
  const divisors: string[] = [];
  const dimension = [0, 0, 0];
  for (const [, separator = "", name = "", typedPower = ""] of (text[0] === "1" ? text : ` ${text}`).matchAll(FACTOR)) {
    const digits = [...typedPower].map((sign) => SUPERSCRIPTS.get(sign) ?? sign).join("");
    const power = Number(digits.replace(/[\^*()]/g, "").replace("−", "-") || 1) * (separator.includes("/") ? -1 : 1);
    const [numerator, denominator, ...powers] = BASE_UNITS.get(name) as [string, string, number, number, number];
    const [above, below] = power > 0 ? [multipliers, divisors] : [divisors, multipliers];
    for (let k = 0; k < Math.abs(power); k += 1) {
      if (numerator !== "1") above.push(numerator);
      if (denominator !== "1") below.push(denominator);
    }
    powers.forEach((base, i) => (dimension[i] = (dimension[i] as number) + power * base));
  }
  const conversion = [...multipliers.map((factor) => `*${factor}`), ...divisors.map((factor) => `/${factor}`)].join("");
  return { conversion, dimension };
}

/** Return the unit of each value that has one, the name before the value ("" if none), and the index of its end. */
export function findUnits(text: string): { name: string; unit: string; end: number }[] {
  let endOfLastUnit = 0;
  return [...text.matchAll(VALUE_WITH_UNIT)].slice(0, MAX_UNITS).map((match) => {
    const names = [...text.slice(endOfLastUnit, match.index).matchAll(NAME_OF_NUMBER)];
    endOfLastUnit = match.index + match[0].length;
    return { name: names.at(-1)?.[1] ?? "", unit: normalizeUnit((match[1] ?? match[2]) as string), end: match.index };
  });
}

/** Remove the units that `toPlainText` leaves, because they could be symbols; an answer in numbers has none. */
export function convertUnitsOfNumbers(text: string): string {
  return text.replace(VALUE_WITH_UNIT, (match: string, bare: string | undefined, inBrackets: string, index: number) => {
    const typedUnit = bare ?? inBrackets;
    const unit = parseUnit(typedUnit);
    const isList = "]}".includes(text[index - 1] as string);
    return unit === null || UNITS.has(normalizeUnit(typedUnit)) || (isList && unit.conversion)
      ? match
      : unit.conversion;
  });
}

/** Replace the units of LaTeX, as in 0.5\,\mathrm{m/s}, by plain ones. */
export const replaceLatexUnits = (text: string): string => text.replace(LATEX_UNIT, " $1");
