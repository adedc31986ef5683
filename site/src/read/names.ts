// Find what a name in an answer means: a symbol, a function, a sine written as s1, or a product of these.
// The rules of ../../../exercises/formula/names.py; ../../tests/readers.test.ts compares both.

import { anyOf, compile, LIMITS, respell, table, VOCABULARY, wholePattern } from "./vocabulary.js";

/** Every function that an expression may call, under each of its names. */
export const FUNCTIONS = table(VOCABULARY.functions);

/** The functions that c and s mean before an angle, as in c1 and s12. */
export const SHORTHAND = table<string>(VOCABULARY.shorthand);

/** The number of arguments of functions that do not take exactly one. */
export const ARITY = table(VOCABULARY.arity);

/** Maximum length of a name. */
export const MAX_NAME_LENGTH = LIMITS.name;

const CONSTANTS = table(VOCABULARY.constants);
const CONSTANT_NAMES = new Set(CONSTANTS.values());
const LETTERS = table(VOCABULARY.letters);
/** As qd1, dtheta1 and theta_dot1; one of the groups is the digit. */
const RATE = wholePattern("rate");
/** As c1, s_12 and calpha1; groups: c or s, the letter of the angle (alpha or beta; none for theta), the digits. */
const SHORTHAND_NAME = wholePattern("shorthand_name");
/** The symbols that q1, th1 and t1 may mean; the first one that the problem has is used. */
const JOINT_SYMBOLS = table<readonly string[]>(VOCABULARY.joints);
/** As q1 and th12; groups: the letters, and the digits. */
const INDEXED_JOINT = compile(`^(${[...JOINT_SYMBOLS.keys()].join("|")})([0-9]{1,4})$`);

/** A part of a typed name. */
export interface Piece {
  readonly kind: "name" | "function" | "sin" | "cos" | "sum";
  /** The name of a symbol or function; or, for "sin", "cos" and "sum", the names of the angles that are added. */
  readonly parts: readonly string[];
}

const makeNamePiece = (symbol: string): Piece => ({ kind: "name", parts: [symbol] });

/** Return a name as the symbol tables write it: without module, Greek letters, and underscores before digits. */
export function toPlainName(name: string): string {
  if (/^[a-z]+[0-9]*$/.test(name)) return name; // the common case, for speed
  let withoutModule = name;
  for (const module of VOCABULARY.modules)
    if (withoutModule.startsWith(module)) withoutModule = withoutModule.slice(module.length);
  return [...withoutModule.normalize("NFKC")]
    .map((sign) => LETTERS.get(sign) ?? sign)
    .join("")
    .replace(/_(?=[0-9])/g, "");
}

/** Return the meaning of a name; `symbols` are the names of the problem's symbols, which have precedence. */
export function splitIntoPieces(typedName: string, symbols: ReadonlySet<string>): readonly Piece[] {
  const plainName = toPlainName(typedName);
  const isInCapitals = !symbols.has(plainName) && symbols.has(plainName.toLowerCase());
  const name = isInCapitals ? plainName.toLowerCase() : plainName;
  if (symbols.has(name)) return [makeNamePiece(name)];
  const functionName = FUNCTIONS.get(name) ?? FUNCTIONS.get(name.toLowerCase());
  if (functionName !== undefined) return [{ kind: "function", parts: [functionName] }];
  const conventionalPiece = findConventionalPiece(name, symbols);
  if (conventionalPiece) return [conventionalPiece];
  for (const letter of VOCABULARY.whole_numbers) {
    if (name === `${letter}pi` || name === `pi${letter}`) return [makeNamePiece(letter), makeNamePiece("pi")]; // kπ
  }
  if (/^[ij]/.test(name) && symbols.has(name.slice(1))) return [makeNamePiece("I"), makeNamePiece(name.slice(1))]; // e^(iθ1)
  const product = splitProduct(name, symbols);
  return product.length > 0 ? product : [makeNamePiece(name)];
}

/** Return the names in a product with dots, as in a1.a2.sin; an empty list if one is unknown, as in a1.subs. */
export function splitAtDots(typedName: string, symbols: ReadonlySet<string>): readonly string[] {
  if (!toPlainName(typedName).includes(".")) return [];
  const names = typedName.split(".");
  const isKnown = ({ kind, parts: [symbol = ""] }: Piece) =>
    kind !== "name" || CONSTANT_NAMES.has(symbol) || (symbols.size > 0 ? symbols.has(symbol) : /[0-9]$/.test(symbol));
  return names.flatMap((name) => splitIntoPieces(name, symbols)).every(isKnown) ? names : [];
}

/** Return what a name that is not a symbol of the problem means by convention; null if it means nothing. */
function findConventionalPiece(name: string, symbols: ReadonlySet<string>): Piece | null {
  const shorthand = SHORTHAND_NAME.exec(name);
  const anglesInSum = shorthand ? listAngles(shorthand[3] as string, symbols, shorthand[2]) : [];
  if (shorthand && anglesInSum.length > 0)
    return { kind: SHORTHAND.get(shorthand[1] as string) as "sin" | "cos", parts: anglesInSum };
  const rate = RATE.exec(name);
  if (rate) {
    const symbol = `qd${rate.slice(1).find((digit) => digit)}`;
    return symbols.has(symbol) || symbols.size === 0 ? makeNamePiece(symbol) : null;
  }
  const constant = CONSTANTS.get(name);
  if (constant !== undefined) return makeNamePiece(constant);
  return symbols.size === 0 ? null : findSymbolPiece(name, symbols);
}

/** Return the symbol that a name means in another spelling, or the sum of angles that theta12 means; else null. */
function findSymbolPiece(name: string, symbols: ReadonlySet<string>): Piece | null {
  const spelling = respell(name);
  const symbolName = [spelling, spelling.toLowerCase()].find((candidate) => symbols.has(candidate));
  if (symbolName !== undefined) return makeNamePiece(symbolName);
  const [, jointName = "", digits = ""] = INDEXED_JOINT.exec(spelling.toLowerCase()) ?? [];
  if (!digits) return null;
  if (digits.length === 1) {
    const candidates = JOINT_SYMBOLS.get(jointName)?.map((symbol) => symbol + digits);
    const symbol = candidates?.find((candidate) => symbols.has(candidate));
    return symbol === undefined ? null : makeNamePiece(symbol);
  }
  const anglesInSum = VOCABULARY.sums_of_angles.includes(jointName) ? listAngles(digits, symbols) : [];
  return anglesInSum.length > 0 ? { kind: "sum", parts: anglesInSum } : null;
}

/** Return the angles whose sum c12 or theta12 means; an empty list if the problem lacks one of them. */
function listAngles(digits: string, symbols: ReadonlySet<string>, letter = "theta"): string[] {
  const names = [...digits].map((digit) => letter + digit);
  return symbols.size === 0 || names.every((angle) => symbols.has(angle)) ? names : [];
}

/** Return the factors of a name without spaces, as a1c12, costheta1 or a1c; an empty list if a part is unknown. */
function splitProduct(name: string, symbols: ReadonlySet<string>): Piece[] {
  if (symbols.size === 0) return [];
  const words = anyOf(new Set([...symbols, ...FUNCTIONS.keys(), "pi"]));
  const pattern = compile(`${words}|${VOCABULARY.patterns.shorthand_without_space}`, "gy");
  const factors: Piece[] = [];
  let end = 0;
  for (let match = pattern.exec(name); match; match = pattern.exec(name)) {
    const word = match[0];
    const functionName = FUNCTIONS.get(word) ?? SHORTHAND.get(word);
    const piece: Piece | null =
      symbols.has(word) || word === "pi"
        ? makeNamePiece(word)
        : functionName !== undefined
          ? { kind: "function", parts: [functionName] }
          : findConventionalPiece(word, symbols);
    if (!piece) return [];
    factors.push(piece);
    end = pattern.lastIndex;
  }
  return end === name.length && factors.length > 1 ? factors : [];
}
