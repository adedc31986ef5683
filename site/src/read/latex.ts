// LaTeX as the plain text that the grammar reads; what is not known is left, for the grammar to complain about.

import { FUNCTIONS } from "./names.js";
import { compiled, isSpace, LIMITS, pattern, stripped, table, VOCABULARY, whole } from "./vocabulary.js";

const TOKEN = pattern("latex_token", "g");
const { latex } = VOCABULARY;
const WORDS = table(latex.words);
const RATES = table(latex.rates);
const VELOCITIES = new Map(Object.entries(latex.velocities).map(([dot, of]) => [dot, table<string>(of)]));
const GOES_ON = new Set(["", "=", "+", "-", "*", "/", ")", "]", ...latex.row_ends]);
const SUM_OF_DIGITS = whole("sum_of_digits");
const HEIGHT = compiled(`^${VOCABULARY.patterns.height_of_row}`);

export const latexAsText = (text: string): string => new Walk(text.match(TOKEN) ?? []).until([]);

/** Walks through the tokens of a formula. */
class Walk {
  private at = 0;
  private depth = 0;

  constructor(private readonly tokens: readonly string[]) {}

  private peek(): string {
    return this.tokens[this.at] ?? "";
  }

  /** The text up to one of the tokens, which stays. */
  until(ends: readonly string[]): string {
    this.depth += 1;
    let out = "";
    while (this.at < this.tokens.length && !ends.includes(this.peek()) && this.depth <= LIMITS.latex_depth)
      out += this.one();
    this.depth -= 1;
    return out;
  }

  private one(): string {
    const found = this.peek();
    this.at += 1;
    if (isSpace(found[0])) return " ";
    if (found === "{") {
      const inner = this.group();
      return inner.includes(":") ? `{${inner}}` : `(${inner})`; // a dictionary of SymPy's, {\theta_2: [0, pi]}
    }
    if (found === "_") return this.subscript();
    if (found === "^") return `^(${this.argument()})`;
    if (found === "&" || latex.row_ends.includes(found)) return this.between(found);
    return found.startsWith("\\") && found.length > 1 ? this.command(found.slice(1)) : found;
  }

  /** What stands between two statements for \\\\, or nothing where the next line goes on, as in & = b. */
  private between(sign: string): string {
    const isGap = (found: string): boolean =>
      isSpace(found[0]) || found === "&" || (found.length > 1 && latex.spaces.includes(found.slice(1)));
    while (isGap(this.peek())) this.at += 1;
    if (GOES_ON.has(this.peek()) || this.peek() === "\\end") return " ";
    return sign === "&" ? " & " : "; ";
  }

  /** What stands below: 12 of {1,2} and of {1+2}; of \theta_1+\theta_2 the sum in brackets. */
  private subscript(): string {
    const bare = [...this.argument()].filter((sign) => !isSpace(sign) && !",()".includes(sign)).join("");
    const index = SUM_OF_DIGITS.test(bare) ? bare.replaceAll("+", "") : bare;
    if (/[-+]/.test(index)) return `(${index})`;
    return /[0-9]$/.test(index) && /^\p{L}/u.test(this.peek()) ? `${index} ` : index; // a_1c \theta_1
  }

  /** What stands up to the closing brace, which is passed. */
  private group(): string {
    const inner = this.until(["}"]);
    this.at += 1;
    return inner;
  }

  /** A group, or the one token that stands for it; nothing where there is none, or too deep a nest. */
  private argument(): string {
    while (isSpace(this.peek()[0])) this.at += 1;
    if (this.at >= this.tokens.length || this.depth > LIMITS.latex_depth) return "";
    this.depth += 1;
    let found: string;
    if (this.peek() === "{") {
      this.at += 1;
      found = this.group();
    } else {
      found = this.one();
    }
    this.depth -= 1;
    return found;
  }

  private command(name: string): string {
    if (latex.spaces.includes(name)) return " ";
    if (latex.nothing.includes(name)) return "";
    if (latex.braces.includes(name)) return name;
    if (latex.fonts.includes(name)) return stripped(this.argument());
    if (latex.fractions.includes(name)) return `((${this.argument()})/(${this.argument()}))`;
    if (latex.roots.includes(name)) return this.root();
    const rate = RATES.get(name); // of whichever joint variable has the index inside, or that follows
    if (rate !== undefined) {
      const of = this.argument().replace(/^[ ()]+|[ ()]+$/g, "");
      const velocity = VELOCITIES.get(name)?.get(of);
      return ` ${velocity ?? rate + (/[0-9]*$/.exec(of)?.[0] ?? "")}`;
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

  /** The rows of \begin{matrix} … \end{matrix} as nested lists. */
  private matrix(): string {
    const kind = this.argument();
    if (!latex.matrices.includes(kind)) return " ";
    if (latex.with_columns.includes(kind) && this.peek() === "{") this.argument();
    const text = this.rows("\\end");
    this.argument();
    return text;
  }

  /** The rows up to what closes them as nested lists; that is passed. */
  private rows(close: string): string {
    const rows: string[][] = [[]];
    while (this.at < this.tokens.length) {
      rows.at(-1)?.push(stripped(this.until(["&", ...latex.row_ends, close])));
      const end = this.peek();
      this.at += 1;
      if (latex.row_ends.includes(end)) {
        rows.push([]);
        this.passHeight();
      } else if (end !== "&") break;
    }
    const filled = rows.filter((row) => row.some((entry) => entry !== ""));
    return `[${filled.map((row) => `[${row.join(", ")}]`).join(", ")}]`;
  }

  /** What says how far apart two rows are, as in \\\\[2pt], is passed. */
  private passHeight(): void {
    if (this.peek() !== "[" || !HEIGHT.test(this.tokens.slice(this.at, this.at + 12).join(""))) return;
    while (this.peek() !== "]") this.at += 1;
    this.at += 1;
  }
}
