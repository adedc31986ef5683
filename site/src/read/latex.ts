// Convert LaTeX to the plain text that the grammar parses. Unknown commands stay, so that the parser reports them.

import { FUNCTIONS } from "./names.js";
import { compile, isSpace, LIMITS, pattern, strip, table, VOCABULARY, wholePattern } from "./vocabulary.js";

const TOKEN = pattern("latex_token", "g");
const { latex } = VOCABULARY;
const WORDS = table(latex.words);
const RATES = table(latex.rates);
const VELOCITIES = new Map(Object.entries(latex.velocities).map(([dot, of]) => [dot, table<string>(of)]));
const CONTINUES = new Set(["", "=", "+", "-", "*", "/", ")", "]", ...latex.row_ends]);
const SUM_OF_DIGITS = wholePattern("sum_of_digits");
const HEIGHT = compile(`^${VOCABULARY.patterns.height_of_row}`);

export const latexAsText = (text: string): string => new Converter(text.match(TOKEN) ?? []).until([]);

/** Converts a formula token by token. */
class Converter {
  private at = 0;
  private depth = 0;

  constructor(private readonly tokens: readonly string[]) {}

  private peek(): string {
    return this.tokens[this.at] ?? "";
  }

  /** Return the text up to one of the tokens, which is not consumed. */
  until(ends: readonly string[]): string {
    this.depth += 1;
    let out = "";
    while (this.at < this.tokens.length && !ends.includes(this.peek()) && this.depth <= LIMITS.latex_depth)
      out += this.next();
    this.depth -= 1;
    return out;
  }

  private next(): string {
    const token = this.peek();
    this.at += 1;
    if (isSpace(token[0])) return " ";
    if (token === "{") {
      const inner = this.group();
      return inner.includes(":") ? `{${inner}}` : `(${inner})`; // a dictionary of SymPy's, {\theta_2: [0, pi]}
    }
    if (token === "_") return this.subscript();
    if (token === "^") return `^(${this.argument()})`;
    if (token === "&" || latex.row_ends.includes(token)) return this.separator(token);
    return token.startsWith("\\") && token.length > 1 ? this.command(token.slice(1)) : token;
  }

  /** Return the separator of two statements for \\\\ or &; a space if the next line continues, as in & = b. */
  private separator(sign: string): string {
    const isGap = (token: string): boolean =>
      isSpace(token[0]) || token === "&" || (token.length > 1 && latex.spaces.includes(token.slice(1)));
    while (isGap(this.peek())) this.at += 1;
    if (CONTINUES.has(this.peek()) || this.peek() === "\\end") return " ";
    return sign === "&" ? " & " : "; ";
  }

  /** Return an index: 12 for {1,2} and {1+2}; the sum in brackets for \theta_1+\theta_2. */
  private subscript(): string {
    const bare = [...this.argument()].filter((sign) => !isSpace(sign) && !",()".includes(sign)).join("");
    const index = SUM_OF_DIGITS.test(bare) ? bare.replaceAll("+", "") : bare;
    if (/[-+]/.test(index)) return `(${index})`;
    return /[0-9]$/.test(index) && /^\p{L}/u.test(this.peek()) ? `${index} ` : index; // a_1c \theta_1
  }

  /** Return the text up to the closing brace, which is consumed. */
  private group(): string {
    const inner = this.until(["}"]);
    this.at += 1;
    return inner;
  }

  /** Return a group, or the one token in its place; "" at the end, or if groups are nested too deeply. */
  private argument(): string {
    while (isSpace(this.peek()[0])) this.at += 1;
    if (this.at >= this.tokens.length || this.depth > LIMITS.latex_depth) return "";
    this.depth += 1;
    let argument: string;
    if (this.peek() === "{") {
      this.at += 1;
      argument = this.group();
    } else {
      argument = this.next();
    }
    this.depth -= 1;
    return argument;
  }

  private command(name: string): string {
    if (latex.spaces.includes(name)) return " ";
    if (latex.nothing.includes(name)) return "";
    if (latex.braces.includes(name)) return name;
    if (latex.fonts.includes(name)) return strip(this.argument());
    if (latex.fractions.includes(name)) return `((${this.argument()})/(${this.argument()}))`;
    if (latex.roots.includes(name)) return this.root();
    const rate = RATES.get(name); // the rate of the joint variable with the index inside or after it
    if (rate !== undefined) {
      const variable = this.argument().replace(/^[ ()]+|[ ()]+$/g, "");
      const velocity = VELOCITIES.get(name)?.get(variable);
      return ` ${velocity ?? rate + (/[0-9]*$/.exec(variable)?.[0] ?? "")}`;
    }
    if (name === "begin") return this.matrix();
    if (name === "end") {
      this.argument();
      return " ";
    }
    if (latex.matrices.includes(name) && this.peek() === "{") {
      this.at += 1;
      return this.rows("}");
    }
    return WORDS.get(name) ?? (FUNCTIONS.has(name) ? ` ${name} ` : ` ${name}`);
  }

  private root(): string {
    if (this.peek() !== "[") return ` sqrt(${this.argument()})`;
    this.at += 1;
    const degree = this.until(["]"]);
    this.at += 1;
    return `(${this.argument()})^(1/(${degree}))`;
  }

  /** Return the rows of \begin{matrix} … \end{matrix} as nested lists. */
  private matrix(): string {
    const kind = this.argument();
    if (!latex.matrices.includes(kind)) return " ";
    if (latex.with_columns.includes(kind) && this.peek() === "{") this.argument();
    const text = this.rows("\\end");
    this.argument();
    return text;
  }

  /** Return the rows up to the closing token as nested lists; the token is consumed. */
  private rows(close: string): string {
    const rows: string[][] = [[]];
    while (this.at < this.tokens.length) {
      rows.at(-1)?.push(strip(this.until(["&", ...latex.row_ends, close])));
      const end = this.peek();
      this.at += 1;
      if (latex.row_ends.includes(end)) {
        rows.push([]);
        this.skipHeight();
      } else if (end !== "&") break;
    }
    const filled = rows.filter((row) => row.some((entry) => entry !== ""));
    return `[${filled.map((row) => `[${row.join(", ")}]`).join(", ")}]`;
  }

  /** Consume the distance between two rows, as in \\\\[2pt]. */
  private skipHeight(): void {
    if (this.peek() !== "[" || !HEIGHT.test(this.tokens.slice(this.at, this.at + 12).join(""))) return;
    while (this.peek() !== "]") this.at += 1;
    this.at += 1;
  }
}
