// Units of numbers, as in m/s^2: their conversion to SI units, and their dimension.
// The rules of ../../../exercises/formula/units.py; ../../tests/readers.test.ts compares both.

import { anyOf, compile, pattern, SUPERSCRIPTS, UNITS, VOCABULARY } from "./vocabulary.js";

export interface Unit {
  /** The text after a number that converts it to SI units, such as "/100" for cm. */
  readonly conversion: string;
  /** The powers of kg, m and s: [0, 1, -2] for m/s^2. */
  readonly dimension: readonly number[];
}

/** By name: the numerator and the denominator of the conversion to SI units, and the powers of kg, m and s. */
const BASE_UNITS = new Map(Object.entries(VOCABULARY.base_units as Record<string, (string | number)[]>));
/** A power, as in "^2", "^(-1)" and "²". */
const POWER = `(?:${VOCABULARY.patterns.power_of_unit})`;
/** A sign between two base units, as in "m/s", "m*s" and "m s". */
const SEPARATOR = `(?:${VOCABULARY.patterns.between_units})`;
const NAMES = anyOf(BASE_UNITS.keys());
/** Up to five base units with powers, as in "m/s^2"; or the reciprocal of these, as in "1/s". */
const UNIT = `(?:1 ?/ ?)?(?:${NAMES})${POWER}?(?:${SEPARATOR}(?:${NAMES})${POWER}?){0,4}`;
const WHOLE_UNIT = compile(`^(?:${UNIT})$`);
/** A base unit of a unit; groups: the sign before it, its name, its power. */
const FACTOR = compile(`(${SEPARATOR})(${NAMES})(${POWER}?)`, "g");
/** A unit after a value, without brackets (group 1) or with them (group 2), as in "0.5 m/s" and "0.5 [m/s]". */
const VALUE_WITH_UNIT = compile(
  `(?:(?<=[0-9.]) ?|${VOCABULARY.patterns.before_unit})(?:(${UNIT})|\\[ ?(${UNIT}) ?\\])${VOCABULARY.patterns.after_unit}`,
  "g",
);
/** A space and a unit in LaTeX, as in "\,\mathrm{m/s}". */
const LATEX_UNIT = pattern("latex_unit", "g");
/** A name before a value, as in "qd1 =". */
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
  const textWithSeparator = text[0] === "1" ? text : ` ${text}`; // a sign is before each base unit, as in " m/s", "1/s"
  for (const [, separator = "", name = "", typedPower = ""] of textWithSeparator.matchAll(FACTOR)) {
    const plainPower = [...typedPower].map((sign) => SUPERSCRIPTS.get(sign) ?? sign).join("");
    const exponent = Number(plainPower.replace(/[\^*()]/g, "").replace("−", "-") || 1);
    const power = separator.includes("/") ? -exponent : exponent;
    const [numerator, denominator, ...powers] = BASE_UNITS.get(name) as [string, string, number, number, number];
    const [numerators, denominators] = power > 0 ? [multipliers, divisors] : [divisors, multipliers];
    for (let k = 0; k < Math.abs(power); k += 1) {
      if (numerator !== "1") numerators.push(numerator);
      if (denominator !== "1") denominators.push(denominator);
    }
    powers.forEach((basePower, i) => (dimension[i] = (dimension[i] as number) + power * basePower));
  }
  const conversion = [...multipliers.map((factor) => `*${factor}`), ...divisors.map((factor) => `/${factor}`)].join("");
  return { conversion, dimension };
}

interface FoundUnit {
  /** The name before the value, as qd1 in "qd1 = 0.5 rad/s"; "" if there is none. */
  readonly name: string;
  readonly unit: string;
  /** The index at which the value ends. */
  readonly end: number;
}

/** Return the units of all values that have one. */
export function findUnits(text: string): FoundUnit[] {
  let endOfLastUnit = 0;
  return [...text.matchAll(VALUE_WITH_UNIT)].slice(0, MAX_UNITS).map((match) => {
    const names = [...text.slice(endOfLastUnit, match.index).matchAll(NAME_OF_NUMBER)];
    const [wholeMatch, bareUnit, bracketedUnit] = match;
    endOfLastUnit = match.index + wholeMatch.length;
    return {
      name: names.at(-1)?.[1] ?? "",
      unit: normalizeUnit((bareUnit ?? bracketedUnit) as string),
      end: match.index,
    };
  });
}

/** Convert the units that `toPlainText` leaves because they could be symbols: an answer in numbers has no symbols. */
export function convertUnitsOfNumbers(text: string): string {
  return text.replace(
    VALUE_WITH_UNIT,
    (match: string, bareUnit: string | undefined, bracketedUnit: string, index: number) => {
      const typedUnit = bareUnit ?? bracketedUnit;
      const unit = parseUnit(typedUnit);
      const isList = "]}".includes(text[index - 1] as string);
      return unit === null || UNITS.has(normalizeUnit(typedUnit)) || (isList && unit.conversion)
        ? match
        : unit.conversion;
    },
  );
}

/** Replace the units of LaTeX, as in 0.5\,\mathrm{m/s}, by plain ones. */
export const replaceLatexUnits = (text: string): string => text.replace(LATEX_UNIT, " $1");
