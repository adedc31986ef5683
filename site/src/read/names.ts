// What a name in an answer stands for: a symbol, a function, a sine in the shorthand of robotics, a product of such.
// The rules of ../../../exercises/formula/names.py; ../../tests/readers.test.ts holds both together.

import { compiled, LIMITS, literally, table, VOCABULARY, whole } from "./vocabulary.js";

/** Every function that an expression may call, under each name that is understood for it. */
export const FUNCTIONS = table(VOCABULARY.functions);

/** What c and s are before an angle. */
export const SHORTHAND = table<string>(VOCABULARY.shorthand);

/** How many arguments a function takes; the others take one. */
export const ARITY = table(VOCABULARY.arity);

/** No name of this field is longer. */
export const LONGEST = LIMITS.name;

const CONSTANTS = table(VOCABULARY.constants);
const MEANT = new Set(CONSTANTS.values());
const LETTERS = table(VOCABULARY.letters);
const VELOCITIES = table<string>(VOCABULARY.velocities);
const RATE = whole("rate");
const SHORT = whole("short");
/** What q1, th1 and t1 may be, the first of them that is a symbol of the problem. */
const JOINTS = table<readonly string[]>(VOCABULARY.joints);
const JOINT = compiled(`^(${[...JOINTS.keys()].join("|")})([0-9]{1,4})$`);

/** A part of a name: `kind` is "name", "function", or "sin", "cos" or "sum" of the angles in `parts`. */
export type Piece = { readonly kind: "name" | "function" | "sin" | "cos" | "sum"; readonly parts: readonly string[] };

const named = (symbol: string): Piece => ({ kind: "name", parts: [symbol] });

/** A name in the form that the symbol tables use: no module, no Greek, no underscore before digits. */
export function plainName(name: string): string {
  if (/^[a-z]+[0-9]*$/.test(name)) return name; // the many that are plain already
  let plain = name;
  for (const module of VOCABULARY.modules) if (plain.startsWith(module)) plain = plain.slice(module.length);
  return [...plain.normalize("NFKC")]
    .map((sign) => LETTERS.get(sign) ?? sign)
    .join("")
    .replace(/_(?=[0-9])/g, "");
}

/** What a name stands for, `known` being the symbols of the problem, which win over everything else. */
export function piecesOf(raw: string, known: ReadonlySet<string>): readonly Piece[] {
  const plain = plainName(raw);
  const name = known.has(plain) || !known.has(plain.toLowerCase()) ? plain : plain.toLowerCase();
  if (known.has(name)) return [named(name)];
  const called = FUNCTIONS.get(name) ?? FUNCTIONS.get(name.toLowerCase());
  if (called !== undefined) return [{ kind: "function", parts: [called] }];
  const one = custom(name, known);
  if (one) return [one];
  for (const whole of VOCABULARY.whole_numbers) {
    if (name === `${whole}pi` || name === `pi${whole}`) return [named(whole), named("pi")]; // kπ
  }
  if (/^[ij]/.test(name) && known.has(name.slice(1))) return [named("I"), named(name.slice(1))]; // e^(iθ1)
  const several = split(name, known);
  return several.length > 0 ? several : [named(name)];
}

/** The names in a product with dots, as in a1.a2.sin; none if one of them means nothing, as in a1.subs. */
export function factorsOf(raw: string, known: ReadonlySet<string>): readonly string[] {
  if (!plainName(raw).includes(".")) return [];
  const names = raw.split(".");
  const isKnown = ({ kind, parts: [symbol = ""] }: Piece) =>
    kind !== "name" || MEANT.has(symbol) || (known.size > 0 ? known.has(symbol) : /[0-9]$/.test(symbol));
  return names.flatMap((name) => piecesOf(name, known)).every(isKnown) ? names : [];
}

/** What a name that is no symbol of the problem means by custom; null where it means nothing. */
function custom(name: string, known: ReadonlySet<string>): Piece | null {
  const short = SHORT.exec(name);
  const counted = short ? angles(short[3] as string, known, short[2]) : [];
  if (short && counted.length > 0) return { kind: SHORTHAND.get(short[1] as string) as "sin" | "cos", parts: counted };
  const rate = RATE.exec(name);
  if (rate) {
    const symbol = `qd${rate.slice(1).find((digit) => digit)}`;
    return known.has(symbol) || known.size === 0 ? named(symbol) : null;
  }
  const constant = CONSTANTS.get(name);
  if (constant !== undefined) return named(constant);
  return known.size === 0 ? null : together(name, known);
}

function together(name: string, known: ReadonlySet<string>): Piece | null {
  let joined = name.replaceAll("_", "");
  for (const [spelled, letter] of Object.entries(VOCABULARY.spelled)) joined = joined.replaceAll(spelled, letter);
  joined = VELOCITIES.get(joined) ?? joined;
  const written = [joined, joined.toLowerCase()].find((each) => known.has(each));
  if (written !== undefined) return named(written);
  const [, spelled = "", digits = ""] = JOINT.exec(joined.toLowerCase()) ?? [];
  if (!digits) return null;
  if (digits.length === 1) {
    const own = JOINTS.get(spelled)?.map((symbol) => symbol + digits);
    const symbol = own?.find((each) => known.has(each));
    return symbol === undefined ? null : named(symbol);
  }
  const counted = VOCABULARY.sums_of_angles.includes(spelled) ? angles(digits, known) : [];
  return counted.length > 0 ? { kind: "sum", parts: counted } : null;
}

/** The angles that c12 or theta12 counts, if all are known, or nothing is. */
function angles(digits: string, known: ReadonlySet<string>, letter = "theta"): string[] {
  const found = [...digits].map((digit) => letter + digit);
  return known.size === 0 || found.every((angle) => known.has(angle)) ? found : [];
}

/** The pieces of names without a space between, as a1c12, costheta1 or a1c; nothing if a part means nothing. */
function split(name: string, known: ReadonlySet<string>): Piece[] {
  if (known.size === 0) return [];
  const words = [...new Set([...known, ...FUNCTIONS.keys(), "pi"])];
  words.sort((a, b) => b.length - a.length || (a < b ? -1 : 1));
  const pattern = compiled([...words.map(literally), VOCABULARY.patterns.short_without_space].join("|"), "gy");
  const found: Piece[] = [];
  let at = 0;
  for (let match = pattern.exec(name); match; match = pattern.exec(name)) {
    const word = match[0];
    const called = FUNCTIONS.get(word) ?? SHORTHAND.get(word);
    const piece: Piece | null =
      known.has(word) || word === "pi"
        ? named(word)
        : called !== undefined
          ? { kind: "function", parts: [called] }
          : custom(word, known);
    if (!piece) return [];
    found.push(piece);
    at = pattern.lastIndex;
  }
  return at === name.length && found.length > 1 ? found : [];
}
