// Convert LaTeX to the plain text that the grammar parses. Unknown commands become names, which the parser reports.

import { FUNCTIONS } from "./names.js";
import { compile, isSpace, LIMITS, pattern, strip, table, VOCABULARY, wholePattern } from "./vocabulary.js";

const TOKEN = pattern("latex_token", "g");
const { latex } = VOCABULARY;
const WORDS = table(latex.words);
const RATES = table(latex.rates);
/** The velocities that a command such as \dot means for a coordinate: vx for \dot{x}. */
const VELOCITIES = new Map(
  Object.entries(latex.velocities).map(([command, velocities]) => [command, table<string>(velocities)]),
);
/** Tokens that continue the statement before \\ or &; "" is the end of the text. */
const CONTINUATION_TOKENS = new Set(["", "=", "+", "-", "*", "/", ")", "]", ...latex.row_ends]);
/** As "1+2" in the subscript {1+2}. */
const SUM_OF_DIGITS = wholePattern("sum_of_digits");
/** As "[2pt]" after the end of a row. */
const ROW_HEIGHT = compile(`^${VOCABULARY.patterns.height_of_row}`);

/** Return a formula in LaTeX as plain text. */
export const convertLatex = (text: string): string => new Converter(text.match(TOKEN) ?? []).convertUntil([]);

/** Converts a formula token by token. */
class Converter {
  /** The index of the next token. */
  private position = 0;
  /** The number of groups and arguments in progress. */
  private depth = 0;

  constructor(private readonly tokens: readonly string[]) {}

  private peek(): string {
    return this.tokens[this.position] ?? "";
  }

  /** Convert the text up to one of these tokens, which is not consumed. */
  convertUntil(endTokens: readonly string[]): string {
    this.depth += 1;
    let text = "";
    while (this.position < this.tokens.length && !endTokens.includes(this.peek()) && this.depth <= LIMITS.latex_depth)
      text += this.convertNext();
    this.depth -= 1;
    return text;
  }

  private convertNext(): string {
    const token = this.peek();
    this.position += 1;
    if (isSpace(token[0])) return " ";
    if (token === "{") {
      const inner = this.convertGroup();
      return inner.includes(":") ? `{${inner}}` : `(${inner})`; // a dictionary of SymPy's, {\theta_2: [0, pi]}
    }
    if (token === "_") return this.convertSubscript();
    if (token === "^") return `^(${this.convertArgument()})`;
    if (token === "&" || latex.row_ends.includes(token)) return this.convertSeparator(token);
    return token.startsWith("\\") && token.length > 1 ? this.convertCommand(token.slice(1)) : token;
  }

  /** Return the separator of two statements for \\ or &; a space if the statement continues after it, as in & = b. */
  private convertSeparator(sign: string): string {
    const isGap = (token: string): boolean =>
      isSpace(token[0]) || token === "&" || (token.length > 1 && latex.spaces.includes(token.slice(1)));
    while (isGap(this.peek())) this.position += 1;
    if (CONTINUATION_TOKENS.has(this.peek()) || this.peek() === "\\end") return " ";
    return sign === "&" ? " & " : "; ";
  }

  /** Convert a subscript: 12 for {1,2} and {1+2}; a sum in brackets for {\theta_1+\theta_2}. */
  private convertSubscript(): string {
    const subscript = [...this.convertArgument()].filter((sign) => !isSpace(sign) && !",()".includes(sign)).join("");
    const index = SUM_OF_DIGITS.test(subscript) ? subscript.replaceAll("+", "") : subscript;
    if (/[-+]/.test(index)) return `(${index})`;
    return /[0-9]$/.test(index) && /^\p{L}/u.test(this.peek()) ? `${index} ` : index; // a_1c \theta_1
  }

  /** Convert the text up to the closing brace, and consume the brace. */
  private convertGroup(): string {
    const inner = this.convertUntil(["}"]);
    this.position += 1;
    return inner;
  }

  /** Convert a group, or the token that stands for one; return "" at the end, or if groups are nested too deeply. */
  private convertArgument(): string {
    while (isSpace(this.peek()[0])) this.position += 1;
    if (this.position >= this.tokens.length || this.depth > LIMITS.latex_depth) return "";
    this.depth += 1;
    let argument: string;
    if (this.peek() === "{") {
      this.position += 1;
      argument = this.convertGroup();
    } else {
      argument = this.convertNext();
    }
    this.depth -= 1;
    return argument;
  }

  private convertCommand(name: string): string {
    if (latex.spaces.includes(name)) return " ";
    if (latex.nothing.includes(name)) return "";
    if (latex.braces.includes(name)) return name;
    if (latex.fonts.includes(name)) return strip(this.convertArgument());
    if (latex.fractions.includes(name)) return `((${this.convertArgument()})/(${this.convertArgument()}))`;
    if (latex.roots.includes(name)) return this.convertRoot();
    const rate = RATES.get(name); // "qd", to which the index of the joint variable is added
    if (rate !== undefined) {
      const variable = this.convertArgument().replace(/^[ ()]+|[ ()]+$/g, "");
      const velocity = VELOCITIES.get(name)?.get(variable);
      return ` ${velocity ?? rate + (/[0-9]*$/.exec(variable)?.[0] ?? "")}`;
    }
    if (name === "begin") return this.convertMatrix();
    if (name === "end") {
      this.convertArgument();
      return " ";
    }
    if (latex.matrices.includes(name) && this.peek() === "{") {
      this.position += 1;
      return this.convertRows("}");
    }
    return WORDS.get(name) ?? (FUNCTIONS.has(name) ? ` ${name} ` : ` ${name}`);
  }

  private convertRoot(): string {
    if (this.peek() !== "[") return ` sqrt(${this.convertArgument()})`;
    this.position += 1;
    const degree = this.convertUntil(["]"]);
    this.position += 1;
    return `(${this.convertArgument()})^(1/(${degree}))`;
  }

  /** Convert \begin{matrix} … \end{matrix} to a list of rows. */
  private convertMatrix(): string {
    const kind = this.convertArgument();
    if (!latex.matrices.includes(kind)) return " ";
    if (latex.with_columns.includes(kind) && this.peek() === "{") this.convertArgument();
    const text = this.convertRows("\\end");
    this.convertArgument();
    return text;
  }

  /** Convert rows up to the closing token to a list of rows, and consume the token. */
  private convertRows(closingToken: string): string {
    const rows: string[][] = [[]];
    while (this.position < this.tokens.length) {
      rows.at(-1)?.push(strip(this.convertUntil(["&", ...latex.row_ends, closingToken])));
      const token = this.peek();
      this.position += 1;
      if (latex.row_ends.includes(token)) {
        rows.push([]);
        this.skipHeight();
      } else if (token !== "&") break;
    }
    const nonemptyRows = rows.filter((row) => row.some((entry) => entry !== ""));
    return `[${nonemptyRows.map((row) => `[${row.join(", ")}]`).join(", ")}]`;
  }

  /** Consume the distance between two rows, as in \\[2pt]. */
  private skipHeight(): void {
    if (this.peek() !== "[" || !ROW_HEIGHT.test(this.tokens.slice(this.position, this.position + 12).join(""))) return;
    while (this.peek() !== "]") this.position += 1;
    this.position += 1;
  }
}
