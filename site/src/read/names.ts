// What a name in an answer stands for: a symbol, a function, a sine in the shorthand of robotics, a product of such.
// The same rules as in ../../../exercises/formula/names.py; tests hold both against the corpus.

export const FUNCTIONS: Readonly<Record<string, string>> = {
  ...Object.fromEntries(
    [
      "sin",
      "cos",
      "tan",
      "cot",
      "sec",
      "csc",
      "asin",
      "acos",
      "atan",
      "acot",
      "sinh",
      "cosh",
      "tanh",
      "exp",
      "log",
    ]
      .concat(["sqrt", "atan2", "sign", "abs"])
      .map((name) => [name, name]),
  ),
  Abs: "abs",
  fabs: "abs",
  ln: "log",
  arcsin: "asin",
  arccos: "acos",
  arctan: "atan",
  arctan2: "atan2",
  deg2rad: "radians",
  radians: "radians",
};

/** How many arguments a function takes; the others take one. */
export const ARITY: Readonly<Record<string, number>> = { atan2: 2 };

/** No name of this field is longer. */
export const LONGEST = 60;

const GREEK: Readonly<Record<string, string>> = {
  θ: "theta",
  ϑ: "theta",
  α: "alpha",
  β: "beta",
  ω: "w",
  π: "pi",
  φ: "phi",
};
const MODULES = ["np.", "numpy.", "math.", "sp.", "sympy.", "sym."];
const RATE = new RegExp(
  "^(?:(?:theta|th|q|d)_?dot_?(\\d)|(?:theta|th|q|d)_?(\\d)_?dot|dot_?(?:theta|th|q|d)_?(\\d)" +
    "|d(?:theta|th|q)_?(\\d)|(?:theta|th)d_?(\\d)|(?:theta|th|q)_?(\\d)_?d|qd_?(\\d))$",
);
const SHORT = /^([csCS])_?\{?(\d{1,4})\}?$/;

/** A part of a name: `kind` is "name", "function", or "sin", "cos" or "sum" of the angles in `parts`. */
export interface Piece {
  readonly kind: "name" | "function" | "sin" | "cos" | "sum";
  readonly parts: readonly string[];
}

/** A name in the form that the symbol tables use: no module, no Greek, no underscore before digits. */
export function plainName(name: string): string {
  if (/^[a-z]+\d*$/.test(name)) return name; // the many that are plain already
  let plain = name;
  for (const module of MODULES) if (plain.startsWith(module)) plain = plain.slice(module.length);
  return [...plain.normalize("NFKC")]
    .map((sign) => GREEK[sign] ?? sign)
    .join("")
    .replace(/_(?=\d)/g, "");
}

/** What a name stands for, `known` being the symbols of the problem, which win over everything else. */
export function piecesOf(raw: string, known: ReadonlySet<string>): readonly Piece[] {
  const plain = plainName(raw);
  const name = known.has(plain) || !known.has(plain.toLowerCase()) ? plain : plain.toLowerCase();
  if (known.has(name)) return [{ kind: "name", parts: [name] }];
  const called = functionNamed(name) ?? functionNamed(name.toLowerCase());
  if (called) return [{ kind: "function", parts: [called] }];
  const one = custom(name, known);
  if (one) return [one];
  const several = split(name, known);
  return several.length > 0 ? several : [{ kind: "name", parts: [name] }];
}

function functionNamed(name: string): string | undefined {
  return Object.hasOwn(FUNCTIONS, name) ? FUNCTIONS[name] : undefined;
}

/** What a name that is no symbol of the problem means by custom; null where it means nothing. */
function custom(name: string, known: ReadonlySet<string>): Piece | null {
  const short = SHORT.exec(name);
  const counted = short ? angles(short[2] as string, known) : [];
  if (short && counted.length > 0)
    return { kind: "cC".includes(short[1] as string) ? "cos" : "sin", parts: counted };
  const rate = RATE.exec(name);
  if (rate) {
    const symbol = `qd${rate.slice(1).find((digit) => digit)}`;
    return known.has(symbol) || known.size === 0 ? { kind: "name", parts: [symbol] } : null;
  }
  if (["e", "i", "j"].includes(name)) return { kind: "name", parts: [name === "e" ? "E" : "I"] };
  return known.size === 0 ? null : together(name, known);
}

function together(name: string, known: ReadonlySet<string>): Piece | null {
  const joined = name.replace(/_/g, "").replace("omega", "w");
  if (known.has(joined)) return { kind: "name", parts: [joined] };
  const digits = /^(?:q|th|t|theta)(\d{1,4})$/.exec(joined)?.[1];
  if (!digits) return null;
  if (digits.length === 1) {
    const own = [`theta${digits}`, `d${digits}`].find((symbol) => known.has(symbol));
    return own && (own.startsWith("t") || joined.startsWith("q")) ? { kind: "name", parts: [own] } : null;
  }
  const counted = joined.startsWith("th") ? angles(digits, known) : [];
  return counted.length > 0 ? { kind: "sum", parts: counted } : null;
}

/** The angles that c12 or theta12 counts, if all are known, or nothing is. */
function angles(digits: string, known: ReadonlySet<string>): string[] {
  const found = [...digits].map((digit) => `theta${digit}`);
  return known.size === 0 || found.every((angle) => known.has(angle)) ? found : [];
}

/** The pieces of names without a space between, as a1c12 or costheta1; nothing if a part means nothing. */
function split(name: string, known: ReadonlySet<string>): Piece[] {
  if (known.size === 0) return [];
  const words = [...new Set([...known, ...Object.keys(FUNCTIONS), "pi"])];
  words.sort((a, b) => b.length - a.length || (a < b ? -1 : 1));
  const pattern = new RegExp(
    [...words.map((word) => word.replace(/\W/g, "\\$&")), "[csCS]\\d{1,4}"].join("|"),
    "gy",
  );
  const found: Piece[] = [];
  let at = 0;
  for (let match = pattern.exec(name); match; match = pattern.exec(name)) {
    const word = match[0];
    const called = functionNamed(word);
    const piece: Piece | null =
      known.has(word) || word === "pi"
        ? { kind: "name", parts: [word] }
        : called
          ? { kind: "function", parts: [called] }
          : custom(word, known);
    if (!piece) return [];
    found.push(piece);
    at = pattern.lastIndex;
  }
  return at === name.length && found.length > 1 ? found : [];
}
