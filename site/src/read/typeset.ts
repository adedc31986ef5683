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
/** Levels of precedence, from loose to tight: an expression in a place that requires a higher level gets brackets. */
const SUM_LEVEL = 0;
const PRODUCT_LEVEL = 1;
const FACTOR_LEVEL = 2;
const ATOM_LEVEL = 3;

/** The LaTeX of an expression, and its level of precedence. */
type Typeset = { readonly latex: string; readonly level: number };

/** Return the LaTeX of an answer. */
export function typesetTree(tree: Node, symbols: Symbols): string {
  const isCondition = ({ kind }: Node): boolean => ["eq", "in", "and"].includes(kind);
  if (tree.kind === "list" && tree.args.length > 1 && tree.args.every(isCondition))
    return typesetNode({ ...tree, kind: "or" }, symbols).latex; // commas between conditions mean "or"
  if (tree.kind === "list" && !tree.args.every(isCondition)) {
    const rows = catchParseError(
      () => asMatrix(tree),
      () => null,
    );
    const lines = rows?.map((row) => row.map((entry) => typesetNode(entry, symbols).latex).join(" & "));
    if (lines) return `\\begin{bmatrix} ${lines.join(" \\\\ ")} \\end{bmatrix}`;
  }
  return typesetNode(tree, symbols).latex;
}

function typesetNode(tree: Node, symbols: Symbols): Typeset {
  const argumentLatex = (index: number, minLevel: number) =>
    bracketBelow(typesetNode(tree.args[index] as Node, symbols), minLevel);
  const joinArguments = (separator: string) => tree.args.map((arg) => typesetNode(arg, symbols).latex).join(separator);
  const { kind, text } = tree;
  if (kind === "number" || kind === "decimal")
    return { latex: decimalSign() === "," ? text.replace(".", "{,}") : text, level: ATOM_LEVEL };
  if (kind === "name") return { latex: typesetSymbol(text, symbols), level: ATOM_LEVEL };
  if (kind === "blank") return { latex: "\\square", level: ATOM_LEVEL };
  if (kind === "neg") return { latex: `-${argumentLatex(0, PRODUCT_LEVEL)}`, level: SUM_LEVEL };
  if (kind === "+" || kind === "-")
    return { latex: `${argumentLatex(0, SUM_LEVEL)} ${kind} ${argumentLatex(1, PRODUCT_LEVEL)}`, level: SUM_LEVEL };
  if (kind === "*")
    return {
      latex: typesetProduct(argumentLatex(0, PRODUCT_LEVEL), argumentLatex(1, FACTOR_LEVEL)),
      level: PRODUCT_LEVEL,
    };
  if (kind === "/")
    return { latex: `\\frac{${argumentLatex(0, SUM_LEVEL)}}{${argumentLatex(1, SUM_LEVEL)}}`, level: FACTOR_LEVEL };
  if (kind === "^")
    return { latex: `${argumentLatex(0, ATOM_LEVEL)}^{${argumentLatex(1, SUM_LEVEL)}}`, level: FACTOR_LEVEL };
  if (kind === "call") return typesetCall(tree, symbols);
  if (kind === "set" || kind === "dict") return { latex: `\\{${joinArguments(", ")}\\}`, level: ATOM_LEVEL };
  if (kind === "list") return { latex: joinArguments(",\\; "), level: ATOM_LEVEL };
  if (kind === "eq" || kind === "pair") return { latex: joinArguments(" = "), level: SUM_LEVEL };
  if (kind === "in") return { latex: joinArguments(" \\in "), level: SUM_LEVEL };
  return { latex: joinArguments(` \\text{ ${kind} } `), level: SUM_LEVEL };
}

const bracketBelow = ({ latex, level }: Typeset, minLevel: number): string =>
  level >= minLevel ? latex : `\\left(${latex}\\right)`;

function typesetProduct(left: string, right: string): string {
  return /^[\d]/.test(right) ? `${left} \\cdot ${right}` : `${left} \\, ${right}`;
}

function typesetSymbol(name: string, symbols: Symbols): string {
  const symbolText = CONSTANTS.get(name) ?? (Object.hasOwn(symbols, name) ? symbols[name]?.latex : undefined);
  return symbolText ?? `\\text{${name.replace(/[^\p{L}\p{N}.]/gu, " ")}}`;
}

/** Typeset a function with its arguments; sin(theta1 + theta2) is written s_{12}. */
function typesetCall(tree: Node, symbols: Symbols): Typeset {
  const args = tree.args.map((arg) => typesetNode(arg, symbols).latex).join(", ");
  const isWave = tree.text === "sin" || tree.text === "cos";
  const jointDigits = isWave ? findJointDigits(tree.args[0] as Node) : null;
  if (jointDigits) return { latex: `${tree.text === "sin" ? "s" : "c"}_{${jointDigits}}`, level: ATOM_LEVEL };
  if (tree.text === "sqrt") return { latex: `\\sqrt{${args}}`, level: ATOM_LEVEL };
  if (tree.text === "abs") return { latex: `\\left|${args}\\right|`, level: ATOM_LEVEL };
  return { latex: `${FUNCTIONS[tree.text] ?? `\\${tree.text}`}\\left(${args}\\right)`, level: ATOM_LEVEL };
}

/** Return the digits of the joints in a sum of joint angles: "12" for theta1 + theta2; null for other angles. */
function findJointDigits(tree: Node): string | null {
  if (tree.kind === "name") return /^theta(\d)$/.exec(tree.text)?.[1] ?? null;
  if (tree.kind !== "+") return null;
  const [left, right] = tree.args.map(findJointDigits);
  return left && right ? left + right : null;
}
