// Typeset a tree as LaTeX with its terms in their order and nothing simplified, to show how an answer was parsed.

import type { SymbolInfo } from "../bank.js";
import { decimalSign } from "../text/text.js";
import { asMatrix, catchParseError, type Node } from "./tree.js";

type Symbols = Readonly<Record<string, SymbolInfo>>;

const FUNCTIONS: Readonly<Record<string, string>> = {
  asin: "\\arcsin",
  acos: "\\arccos",
  atan: "\\arctan",
  log: "\\ln",
  atan2: "\\operatorname{atan2}",
  sign: "\\operatorname{sign}",
  acot: "\\operatorname{arccot}",
};
const CONSTANTS = new Map(Object.entries({ pi: "\\pi", E: "e", I: "i" }));
const SUM = 0;
const PRODUCT = 1;
const FACTOR = 2;
const ATOM = 3;

type Piece = { readonly latex: string; readonly level: number };

/** Return the LaTeX of an answer. */
export function typesetTree(tree: Node, symbols: Symbols): string {
  const isCondition = ({ kind }: Node): boolean => ["eq", "in", "and"].includes(kind);
  if (tree.kind === "list" && !tree.args.every(isCondition)) {
    const rows = catchParseError(
      () => asMatrix(tree),
      () => null,
    );
    const lines = rows?.map((row) => row.map((entry) => piece(entry, symbols).latex).join(" & "));
    if (lines) return `\\begin{bmatrix} ${lines.join(" \\\\ ")} \\end{bmatrix}`;
  }
  return piece(tree, symbols).latex;
}

function piece(tree: Node, symbols: Symbols): Piece {
  const inner = (index: number, level: number) => at(piece(tree.args[index] as Node, symbols), level);
  const listed = (between: string) => tree.args.map((arg) => piece(arg, symbols).latex).join(between);
  const { kind, text } = tree;
  if (kind === "number" || kind === "decimal")
    return { latex: decimalSign() === "," ? text.replace(".", "{,}") : text, level: ATOM };
  if (kind === "name") return { latex: named(text, symbols), level: ATOM };
  if (kind === "blank") return { latex: "\\square", level: ATOM };
  if (kind === "neg") return { latex: `-${inner(0, PRODUCT)}`, level: SUM };
  if (kind === "+" || kind === "-") return { latex: `${inner(0, SUM)} ${kind} ${inner(1, PRODUCT)}`, level: SUM };
  if (kind === "*") return { latex: product(inner(0, PRODUCT), inner(1, FACTOR)), level: PRODUCT };
  if (kind === "/") return { latex: `\\frac{${inner(0, SUM)}}{${inner(1, SUM)}}`, level: FACTOR };
  if (kind === "^") return { latex: `${inner(0, ATOM)}^{${inner(1, SUM)}}`, level: FACTOR };
  if (kind === "call") return called(tree, symbols);
  if (kind === "set" || kind === "dict") return { latex: `\\{${listed(", ")}\\}`, level: ATOM };
  if (kind === "list") return { latex: listed(",\\; "), level: ATOM };
  if (kind === "eq" || kind === "pair") return { latex: listed(" = "), level: SUM };
  if (kind === "in") return { latex: listed(" \\in "), level: SUM };
  return { latex: listed(` \\text{ ${kind} } `), level: SUM };
}

const at = ({ latex, level }: Piece, least: number): string => (level >= least ? latex : `\\left(${latex}\\right)`);

function product(left: string, right: string): string {
  return /^[\d]/.test(right) ? `${left} \\cdot ${right}` : `${left} \\, ${right}`;
}

function named(name: string, symbols: Symbols): string {
  const known = CONSTANTS.get(name) ?? (Object.hasOwn(symbols, name) ? symbols[name]?.latex : undefined);
  return known ?? `\\text{${name.replace(/[^\p{L}\p{N}.]/gu, " ")}}`;
}

function called(tree: Node, symbols: Symbols): Piece {
  const args = tree.args.map((arg) => piece(arg, symbols).latex).join(", ");
  const short = /^(sin|cos)$/.test(tree.text) ? shorthand(tree.args[0] as Node) : null;
  if (short) return { latex: `${tree.text[0]}_{${short}}`, level: ATOM };
  if (tree.text === "sqrt") return { latex: `\\sqrt{${args}}`, level: ATOM };
  if (tree.text === "abs") return { latex: `\\left|${args}\\right|`, level: ATOM };
  return { latex: `${FUNCTIONS[tree.text] ?? `\\${tree.text}`}\\left(${args}\\right)`, level: ATOM };
}

/** Return "12" for theta1 + theta2; null for other angles. */
function shorthand(tree: Node): string | null {
  if (tree.kind === "name") return /^theta(\d)$/.exec(tree.text)?.[1] ?? null;
  if (tree.kind !== "+") return null;
  const [left, right] = tree.args.map(shorthand);
  return left && right ? left + right : null;
}
