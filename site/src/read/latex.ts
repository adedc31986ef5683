// LaTeX as the plain text that the grammar reads; what is not known is left, for the grammar to complain about.

import { FUNCTIONS } from "./names.js";

const TOKEN = /\\[a-zA-Z]+|\\[\s\S]|\s+|[\s\S]/gu;
const SPACES = new Set(["quad", "qquad", ",", ";", ":", " "]);
const NOTHING = new Set([
  "left",
  "right",
  "displaystyle",
  "limits",
  "big",
  "Big",
  "bigl",
  "bigr",
  "!",
  "(",
  ")",
  "[",
  "]",
]);
const FONTS = new Set([
  "mathrm",
  "text",
  "operatorname",
  "mathbf",
  "mathit",
  "rm",
  "textrm",
  "mathsf",
  "boldsymbol",
]);
const WORDS: Readonly<Record<string, string>> = {
  cdot: "*",
  times: "*",
  ast: "*",
  div: "/",
  arcsin: " asin",
  arccos: " acos",
  arctan: " atan",
  infty: " oo",
  in: " in ",
  lor: " or ",
  vee: " or ",
  land: " and ",
  wedge: " and ",
};
const MATRIX = /^(?:[bpvBV]?matrix|array|smallmatrix)$/;
const DEEPEST = 40;

export function latexAsText(text: string): string {
  return new Walk(text.match(TOKEN) ?? []).until([]);
}

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
    while (this.at < this.tokens.length && !ends.includes(this.peek()) && this.depth <= DEEPEST)
      out += this.one();
    this.depth -= 1;
    return out;
  }

  private one(): string {
    const found = this.peek();
    this.at += 1;
    if (/^\s+$/.test(found)) return " ";
    if (found === "{") return `(${this.group()})`;
    if (found === "_") return this.argument().replace(/[\s,()]+/g, "");
    if (found === "^") return `^(${this.argument()})`;
    return found.startsWith("\\") && found.length > 1 ? this.command(found.slice(1)) : found;
  }

  /** What stands up to the closing brace, which is passed. */
  private group(): string {
    const inner = this.until(["}"]);
    this.at += 1;
    return inner;
  }

  /** A group, or the one token that stands for it; nothing where there is none, or too deep a nest. */
  private argument(): string {
    while (/^\s+$/.test(this.peek())) this.at += 1;
    if (this.at >= this.tokens.length || this.depth > DEEPEST) return "";
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
    if (SPACES.has(name)) return " ";
    if (NOTHING.has(name)) return "";
    if (name === "{" || name === "}") return name;
    if (FONTS.has(name)) return this.argument().trim();
    if (["frac", "dfrac", "tfrac"].includes(name)) return `((${this.argument()})/(${this.argument()}))`;
    if (name === "sqrt") return this.root();
    if (name === "dot" || name === "ddot") {
      // the rate of whichever joint variable has the index inside, or that follows
      const index = /\d*$/.exec(
        this.argument()
          .trim()
          .replace(/^[ ()]+|[ ()]+$/g, ""),
      );
      return ` ${name === "dot" ? "qd" : "qdd"}${index?.[0] ?? ""}`;
    }
    if (name === "begin") return this.matrix();
    return WORDS[name] ?? (Object.hasOwn(FUNCTIONS, name) ? ` ${name} ` : ` ${name}`);
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
    if (!MATRIX.test(kind)) return "";
    if (kind === "array" && this.peek() === "{") this.argument();
    const rows: string[][] = [[]];
    while (this.at < this.tokens.length) {
      rows.at(-1)?.push(this.until(["&", "\\\\", "\\end"]));
      const end = this.peek();
      this.at += 1;
      if (end === "\\\\") rows.push([]);
      else if (end !== "&") {
        this.argument();
        break;
      }
    }
    const filled = rows.filter((row) => row.some((entry) => entry.trim()));
    return `[${filled.map((row) => `[${row.map((entry) => entry.trim()).join(", ")}]`).join(", ")}]`;
  }
}
