// Parse a text to a tree of plain nodes, by a grammar and a whitelist; nothing of the text is ever executed.
// The grammar of ../../../exercises/formula/parser.py; ../../tests/readers.test.ts compares both.

import { type Message, message, type Values, type TextKey } from "../text/text.js";
import { METRE, removeMetres } from "./metres.js";
import {
  ARITY,
  splitAtDots,
  FUNCTIONS,
  MAX_NAME_LENGTH,
  type Piece,
  splitIntoPieces,
  toPlainName,
  SHORTHAND,
} from "./names.js";
import { toPlainText } from "./notation.js";
import { carryOutProducts } from "./products.js";
import { computeDepthChange, type Token, splitIntoTokens } from "./tokens.js";
import {
  call,
  CHAIN,
  transposeRows,
  splitIntoRows,
  integer,
  isRectangle,
  type Kind,
  listOf,
  name,
  findNames,
  type Node,
  node,
  errorAt,
  hasNameOf,
  isListOrSet,
  ParseError,
  rebuild,
  replaceName,
} from "./tree.js";
import { countCharacters, LIMITS, pattern, table, UNITS, VOCABULARY, wholePattern } from "./vocabulary.js";

/** Calls of SymPy, NumPy or Python that are not functions of numbers, with their meanings, such as "set" or "matrix". */
const CALL_MEANINGS = table(VOCABULARY.call_meanings);
/** Calls that bind a variable, with what they mean: a rate for Derivative(theta1(t), t), a whole number for Lambda. */
const BINDING_CALLS = table(VOCABULARY.binding_calls);
/** Names that stand for no formula: NaN of NumPy, oo of SymPy. */
const UNDEFINED_NAMES = new Set(Object.keys(VOCABULARY.undefined));
const BLANK_NAMES = new Set(VOCABULARY.blank);
/** Words such as "and" between two conditions; they are never factors. */
const OPERATOR_WORDS = new Set(VOCABULARY.operator_words);
const INVERSE_FUNCTIONS = table(VOCABULARY.inverses);
/** As theta1, q1 and d1; group: the digits. */
const JOINT = wholePattern("joint");
/** As theta1, alpha1 and beta1. */
const ANGLE = wholePattern("angle");
/** The angle at the end of a shorthand, as in ctheta1 and st12. */
const SHORTHAND_OF_ANGLE = pattern("shorthand_of_angle");
const SYNONYMS = table<string>(VOCABULARY.synonyms);
/** Names that a bracket after them multiplies, because nobody defines functions with these names. */
const BEFORE_BRACKETS = new Set(["pi", "I", ...VOCABULARY.whole_numbers]);
const MODULO_WORDS = new Set(VOCABULARY.modulo);
const UNIT_OPERATORS = new Set(["/", "^", "**"]);
/** Before these tokens, a name is a symbol that is a factor, and not a unit at the end of a product. */
const AFTER_SYMBOL = new Set(["*", "(", ...UNIT_OPERATORS]);

/** Tokens that can't be between the bars of an absolute value, and tokens that may follow its second bar. */
const NEVER_BETWEEN_BARS = new Set(["=", "==", ",", ";", ":", "&"]);
const AFTER_BAR = new Set(["*", "/", "^", "**", "=", "==", ")", "]", "}", ",", ";"]);
const BEFORE_STATEMENT = new Set([",", ";", "and", "&", "or", "[", "(", "{"]);
/** Words after a comma that add nothing to the comma: "or" is only among those between conditions. */
const WORDS_BETWEEN_ENTRIES = new Set(["and", "&"]);
const WORDS_BETWEEN_CONDITIONS = new Set(["and", "&", "or", "|"]);

/** Parse a text; `symbols` are the names of the problem's symbols, which have precedence over shorthand. */
export function parse(text: string, symbols: ReadonlySet<string>): Node {
  const length = countCharacters(text, LIMITS.characters);
  if (length > LIMITS.characters) throw new ParseError("read.long", { length, limit: LIMITS.characters });
  return new Parser(toPlainText(text, symbols), symbols).parse();
}

/**
 * Operator-precedence parser. A method `parseX` consumes the tokens of an X from the current position on and returns
 * its tree. Depth is limited, so that no text can exhaust the stack.
 */
class Parser {
  private readonly tokens: readonly Token[];
  /** Known meanings of names, if they do not depend on the place: the function's name, or the tree of a symbol. */
  private readonly meanings = new Map<string, string | Node>();
  private readonly piecesOfNames = new Map<string, readonly Piece[]>();
  /** The index of the current token. */
  private position = 0;
  /** The number of `nest` calls in progress. */
  private depth = 0;
  /** The token index after the latest argument of a function without brackets; -1 if there is none. */
  private bareArgumentEnd = -1;
  /** The latest product of names without spaces between them, such as a1c2; null after a bracket. */
  private joinedProduct: Node | null = null;
  /** Whether the next bar ends an absolute value. */
  private isInBars = false;
  /** Whether functions have square brackets, as in Mathematica, so that {a, b} is a list. */
  private bracesAreLists = false;

  constructor(
    private readonly text: string,
    private readonly symbols: ReadonlySet<string>,
  ) {
    this.tokens = splitIntoTokens(text).flatMap((token) => this.translate(token));
    const count = this.tokens.filter((token) => token.text === "±").length;
    if (count > LIMITS.plus_minus_signs) throw new ParseError("read.either", { count });
  }

  /** Return a token, or the tokens that a word means, such as `or` for the German word oder. */
  private translate(token: Token): readonly Token[] {
    if (token.kind !== "name") return [token];
    const text = this.symbols.has(token.text) ? undefined : SYNONYMS.get(token.text);
    if (text === "") return [];
    if (text !== undefined) {
      const kind = /^[0-9]+$/.test(text) ? "number" : /^[a-z]+$/.test(text) ? "name" : "op";
      return [{ ...token, kind, text }];
    }
    let { start } = token;
    const factors = splitAtDots(token.text, this.symbols).flatMap((name): readonly Token[] => {
      const times: Token = { kind: "op", text: "*", start };
      const factor: Token = { kind: "name", text: name, start };
      start += name.length + 1;
      return [times, factor];
    });
    return factors.length > 0 ? factors.slice(1) : [token]; // a1.a2.sin; the first "*" is dropped
  }

  parse(): Node {
    if (this.currentToken().kind === "end") throw new ParseError("read.nothing");
    this.skipLambda();
    const parsed = this.parseAnswer();
    const asList = (top: Node, args: readonly Node[]): Node => {
      return { ...top, args, kind: top.kind === "set" ? "list" : top.kind };
    };
    const tree = this.bracesAreLists ? rebuild(parsed, asList) : parsed;
    const isMetre = !this.symbols.has(METRE) && this.tokens.some(({ text }) => text === METRE);
    return carryOutProducts(isMetre ? removeMetres(tree) : tree);
  }

  /** Parse everything up to the end. */
  private parseAnswer(): Node {
    const parsedRows = this.parseRows("");
    if (this.currentToken().kind !== "end") throw this.errorHere("read.unexpected", { found: this.describeToken() });
    const isColumn = parsedRows.rows.every((row) => row.length === 1); // a; b
    const rows = parsedRows.rows.length > 1 && isColumn ? [parsedRows.rows.flat()] : parsedRows.rows;
    if (rows.length > 1) return listOf(rows);
    const items = rows[0] as readonly Node[];
    if (items.length === 0) throw new ParseError("read.nothing"); // only semicolons
    if (items.some(({ kind }) => kind === "pair")) return this.buildDictionary(items); // x: a, y: b
    return parsedRows.hasComma || items.length > 1 ? node("list", ...items) : (items[0] as Node);
  }

  /**
   * Parse entries between commas, in rows that semicolons end, up to the closing sign; also return whether there was a
   * comma. In braces, and outside of brackets, an entry may be named, as in x: a.
   */
  private parseRows(closingSign: string): { rows: readonly (readonly Node[])[]; hasComma: boolean } {
    const rows: Node[][] = [[]];
    let hasComma = false;
    while (!this.takeEnd(closingSign)) {
      if (this.take(";")) {
        rows.push([]);
        continue;
      }
      const first = this.parseDisjunction();
      const isJoined = closingSign === "" && this.isCommaAnd() && this.isCondition(first);
      const item = isJoined ? this.parseConjunctionAfterComma(first, rows) : first;
      const isNamed = (closingSign === "" || closingSign === "}") && this.take(":");
      rows.at(-1)?.push(isNamed ? node("pair", item, this.parseDisjunction()) : item);
      if (this.take(",")) {
        hasComma = true;
        const [[firstEntry]] = rows.filter((row) => row.length > 0) as [[Node]];
        const connectives = this.isCondition(firstEntry) ? WORDS_BETWEEN_CONDITIONS : WORDS_BETWEEN_ENTRIES;
        if (closingSign === "" && connectives.has(this.peek())) {
          this.position += 1;
          if (this.currentToken().kind === "end") throw this.errorHere("read.operand", { found: this.describeToken() });
        }
      } else if (this.peek() !== ";") {
        if (closingSign) this.expect(closingSign);
        break;
      }
    }
    const nonemptyRows = rows.filter((row) => row.length > 0);
    return { rows: nonemptyRows.length > 0 ? nonemptyRows : [[]], hasComma };
  }

  private takeEnd(closingSign: string): boolean {
    return closingSign ? this.take(closingSign) : this.currentToken().kind === "end";
  }

  /** Return a dictionary from pairs and the values after them. */
  private buildDictionary(items: readonly Node[]): Node {
    const pairs: Node[][] = [];
    for (const item of items) {
      const last = pairs.at(-1);
      if (item.kind === "pair") pairs.push([...item.args]);
      else if (last && isValue(item))
        last.push(item); // theta2: 0, pi
      else throw this.errorHere("read.dictionary");
    }
    return node("dict", ...pairs.map(([key, ...values]) => node("pair", key as Node, wrapValues(values))));
  }

  private currentToken(): Token {
    return this.tokens[this.position] as Token;
  }

  private peek(): string {
    return this.currentToken().text;
  }

  private tokenAhead(count: number): Token {
    return this.tokens[Math.min(this.position + count, this.tokens.length - 1)] as Token;
  }

  private textAhead(count: number): string {
    return this.tokenAhead(count).text;
  }

  private errorHere(key: TextKey, values: Values = {}): ParseError {
    return errorAt(key, values, this.text, this.currentToken().start);
  }

  /** Return the current token as errors name it. */
  private describeToken(): string | Message {
    return this.peek() ? `'${this.peek()}'` : message("read.the-end");
  }

  /** Skip the current token if it is this sign or word; return whether it was. */
  private take(sign: string, synonym = sign): boolean {
    const { kind, text } = this.currentToken();
    if ((text !== sign && text !== synonym) || (kind !== "op" && kind !== "name")) return false;
    this.position += 1;
    return true;
  }

  private expect(text: string): void {
    if (this.take(text)) return;
    if (this.currentToken().kind === "end") throw this.errorHere("read.unclosed", { expected: text });
    throw this.errorHere("read.expected", { expected: text, found: this.describeToken() });
  }

  /** Parse something nested one level deeper; throw the error `tooDeep` beyond the limit. */
  private nest<T>(parse: () => T, tooDeep: TextKey): T {
    this.depth += 1;
    if (this.depth > LIMITS.depth) throw this.errorHere(tooDeep, { limit: LIMITS.depth });
    const result = parse();
    this.depth -= 1;
    return result;
  }

  /** Skip the head of a Python function, lambda theta1, theta2: …; its result is the answer. */
  private skipLambda(): void {
    if (!this.take("lambda")) return;
    while (this.currentToken().kind === "name") {
      this.position += 1;
      if (!this.take(",")) break;
    }
    this.expect(":");
  }

  private isCommaAnd(): boolean {
    return this.peek() === "," && ["and", "&"].includes(this.textAhead(1));
  }

  /** Return whether a term is a condition on a symbol of the problem; x = 1 only names an entry. */
  private isCondition({ kind, args }: Node): boolean {
    if (kind === "and" || kind === "or") return args.every((arg) => this.isCondition(arg));
    return (kind === "eq" || kind === "in") && hasNameOf(args[0] as Node, this.symbols);
  }

  /** Parse "A, and B" as "A and B" if B is a condition; other commas make it ambiguous. */
  private parseConjunctionAfterComma(first: Node, rows: readonly (readonly Node[])[]): Node {
    const start = this.position;
    const terms = first.kind === "and" ? [...first.args] : [first];
    while (this.isCommaAnd()) {
      const beforeComma = this.position;
      this.position += 2;
      const term = this.parseRelation();
      if (!this.isCondition(term)) {
        this.position = beforeComma;
        break;
      }
      terms.push(term);
    }
    if (this.position === start) return first;
    const isOnlyEntry = rows.length === 1 && rows[0]?.length === 0;
    const isContinued = [",", "or", "|"].includes(this.peek());
    if (!isOnlyEntry || isContinued || first.kind === "or") throw this.errorHere("read.unexpected", { found: "'and'" });
    return node("and", ...terms);
  }

  private readonly parseAlternatives = (): Node => this.parseOperands("or", this.parseConjunction, "or", "|");

  private parseDisjunction(): Node {
    return this.nest(this.parseAlternatives, "read.brackets");
  }

  // Functions that others call back are fields: binding them for each of ten thousand brackets would take long.
  private readonly parseConjunction = (): Node => this.parseOperands("and", this.parseRelation, "and", "&");

  /** Parse one or several terms with a word or sign between them. */
  private parseOperands(kind: "or" | "and", parseTerm: () => Node, word: string, sign: string): Node {
    const first = parseTerm();
    if (!this.take(word, sign)) return first;
    const terms = [first, parseTerm()];
    while (this.take(word, sign)) terms.push(parseTerm());
    return node(kind, ...terms);
  }

  /** Parse an equation, a membership such as k in Z, or an expression alone. */
  private readonly parseRelation = (): Node => {
    const first = this.parseModulo(this.parseSum());
    if (this.take("in")) return node("in", first, this.parseModulo(this.parseSum()));
    const sides = [first];
    while (this.take("=", "==")) sides.push(this.parseValues());
    if (sides.length > 2 && sides[0]?.kind === "name" && sides[1]?.kind === "list") sides.shift(); // P = [x; y] = […]
    const equations = sides.slice(1).map((right, i) => node("eq", sides[i] as Node, right));
    if (equations.length > 1) return { ...node("and", ...equations), text: CHAIN }; // theta1 = theta2 = 0
    return equations[0] ?? first;
  };

  /** Parse the right side of an equation: a value, or several, as in theta2 = 0 or pi. */
  private parseValues(): Node {
    const values = [this.parseModulo(this.parseSum())];
    while (["or", "and", "|", "&"].includes(this.peek())) {
      const start = this.position;
      this.position += 1;
      const other = this.currentToken().kind === "end" ? null : this.parseModulo(this.parseSum());
      if (!other || ["=", "==", "in", ":"].includes(this.peek()) || !isValue(other)) {
        this.position = start; // another condition begins there
        break;
      }
      values.push(other);
    }
    return wrapValues(values);
  }

  /** Parse theta2 = 0 mod pi, or (mod pi): the value, and all values that differ by multiples of pi. */
  private parseModulo(value: Node): Node {
    const hasBracket = this.peek() === "(" && MODULO_WORDS.has(this.textAhead(1));
    if (!hasBracket && !MODULO_WORDS.has(this.peek())) return value;
    this.position += hasBracket ? 2 : 1;
    const isNumber = ["end", "op"].includes(this.currentToken().kind) && this.peek() !== "(";
    if (this.textAhead(-1) === "%" && isNumber) throw this.errorHere("read.percent");
    const step = node("*", name(VOCABULARY.whole_numbers[0] as string), this.parseSum());
    if (hasBracket) this.expect(")");
    return isListOrSet(value)
      ? node(value.kind, ...value.args.map((part) => node("+", part, step)))
      : node("+", value, step);
  }

  /** Parse terms with +, - or ± between them. */
  private parseSum(): Node {
    const isEither = this.take("±");
    let sum = isEither ? this.parseProduct() : this.parseSigned(this.parseProduct);
    if (isEither) sum = node("set", sum, node("neg", sum));
    for (let op = this.peek(); op === "+" || op === "-" || op === "±"; op = this.peek()) {
      const isAfterBareArgument = this.position === this.bareArgumentEnd;
      this.position += 1;
      const right = this.parseSigned(this.parseProduct);
      if (isAfterBareArgument && right.kind === "name" && ANGLE.test(right.text))
        throw this.errorHere("read.reach", { sign: op, name: right.text });
      sum = op === "±" ? node("set", node("+", sum, right), node("-", sum, right)) : node(op, sum, right);
    }
    return sum;
  }

  /** Parse the next operand, with the product of all signs before it. */
  private parseSigned(parseOperand: () => Node): Node {
    let isNegative = false;
    while (this.currentToken().kind === "op" && (this.peek() === "+" || this.peek() === "-")) {
      isNegative = isNegative !== (this.peek() === "-");
      this.position += 1;
    }
    return isNegative ? node("neg", parseOperand()) : parseOperand();
  }

  /** Parse factors, with or without signs between them. */
  private readonly parseProduct = (): Node => {
    let product = this.parsePower();
    let divisorEnd = -1; // the token index after a divisor that is a single name
    for (;;) {
      if (this.take("*", ".")) {
        product = node("*", product, this.parseSigned(this.parsePower));
        divisorEnd = -1;
      } else if (this.take("/")) {
        const start = this.position;
        const divisor = this.parseSigned(this.parsePower);
        product = node("/", product, divisor);
        divisorEnd = this.isSingleName(start) && divisor.kind === "name" ? this.position : -1;
      } else if (this.currentToken().kind === "number" && this.tokens[this.position - 1]?.kind === "number") {
        throw this.errorHere("read.two-numbers"); // 1 000 or 1.2.3 is probably no product
      } else if (this.currentToken().kind === "number" && this.peek().startsWith(".")) {
        throw this.errorHere("read.point", { number: this.peek(), factor: this.peek().slice(1) }); // a1.2
      } else if (this.peek() === "(" && MODULO_WORDS.has(this.textAhead(1))) return product;
      else if (this.isUnit()) {
        product = convertUnit(product, this.peek());
        this.position += 1;
      } else if (
        this.position === divisorEnd &&
        this.currentToken().kind === "name" &&
        !OPERATOR_WORDS.has(this.peek())
      ) {
        throw this.errorHere("read.below", { name: this.textAhead(-1), next: this.peek() });
      } else if (this.peek() === "|" && this.isBarOfFactor()) product = node("*", product, this.parsePower());
      else if (this.peek() === "[" && this.isRowBelow(product)) product = this.appendRow(product);
      else if (this.startsFactor()) product = node("*", product, this.parseFactor());
      else return product;
    }
  };

  /** Return whether the operand from token `start` to here is a single name. */
  private isSingleName(start: number): boolean {
    const { kind, text } = this.tokens[start] as Token;
    return kind === "name" && this.position === start + 1 && !beginsWithConstant(text);
  }

  /** Parse a factor without a sign; [0] is not a factor, because Python would select an entry by it. */
  private parseFactor(): Node {
    const start = this.position;
    const hasSquareBracket = this.peek() === "[";
    const factor = this.parsePower();
    const [onlyEntry] = factor.args;
    if (
      hasSquareBracket &&
      factor.kind === "list" &&
      factor.args.length === 1 &&
      /^(number|neg)$/.test(onlyEntry?.kind ?? "")
    ) {
      this.position = start;
      throw this.errorHere("read.no-entry");
    }
    return factor;
  }

  /** Return whether the bar here begins an absolute value, as in a1|s2|, rather than an alternative, as in 0 | pi. */
  private isBarOfFactor(): boolean {
    if (this.isInBars) return false;
    let depth = 0;
    let hasSymbol = false;
    let end = this.position + 1;
    for (; ; end += 1) {
      const { kind, text } = this.tokens[end] as Token;
      if (kind === "end" || (text === "|" && depth === 0)) break;
      depth += computeDepthChange(text);
      if (depth < 0 || (depth === 0 && (NEVER_BETWEEN_BARS.has(text) || OPERATOR_WORDS.has(text)))) return false;
      hasSymbol ||= kind === "name" && !beginsWithConstant(text);
    }
    const [first, last, close] = [this.position + 1, end - 1, end].map((i) => this.tokens[i]) as [Token, Token, Token];
    if (close.kind === "end" || !hasSymbol) return false;
    const isWithoutSpaces =
      first.start === this.currentToken().start + 1 && last.start + last.text.length === close.start;
    const nextToken = this.tokens[end + 1] as Token;
    return isWithoutSpaces || nextToken.kind === "end" || AFTER_BAR.has(nextToken.text);
  }

  /** Return whether the bracket here begins a row below a list, as calculators write [a, b][c, d]. */
  private isRowBelow(list: Node): boolean {
    return list.kind === "list" && list.args.length > 1 && this.textAhead(-1) === "]" && !this.isColumnAhead();
  }

  /** Return whether the list that begins here has rows, as in [a; b] or [[a, b], [c, d]]. */
  private isColumnAhead(): boolean {
    let depth = 0;
    for (let index = this.position; index < this.tokens.length; index += 1) {
      const { text } = this.tokens[index] as Token;
      depth += computeDepthChange(text);
      if (depth === 0) return false;
      if ((text === ";" && depth === 1) || (text === "[" && index === this.position + 1)) return true;
    }
    return false;
  }

  /** Add the list that follows as a row. */
  private appendRow(list: Node): Node {
    this.take("[");
    const row = this.parseBracket("]", "list");
    const rows = list.args.every(({ kind }) => kind === "list") ? list.args : [list];
    if (rows.length >= LIMITS.matrix_rows || rows.some(({ args }) => args.length !== row.args.length))
      throw this.errorHere("read.two-lists");
    return node("list", ...rows, row);
  }

  /** Return whether the name here is a unit of the number before, as in 0.25 rad or 25 cm * a1; metres.ts handles m. */
  private isUnit(): boolean {
    const { kind, text } = this.currentToken();
    const isName = kind === "name" && UNITS.has(text) && !this.symbols.has(text);
    if (!isName || VOCABULARY.whole_numbers.includes(text)) return false;
    const previousToken = this.tokens[this.position - 1];
    if (previousToken?.kind !== "number" && !VOCABULARY.before_whole_numbers.includes(previousToken?.text ?? ""))
      return false;
    const nextToken = this.tokenAhead(1);
    if (VOCABULARY.lengths.includes(text)) return !UNIT_OPERATORS.has(nextToken.text);
    return (
      !AFTER_SYMBOL.has(nextToken.text) &&
      (nextToken.kind !== "name" || OPERATOR_WORDS.has(nextToken.text)) &&
      nextToken.kind !== "number"
    );
  }

  /** Return whether the current token begins a factor without a sign before it. */
  private startsFactor(): boolean {
    const { kind, text } = this.currentToken();
    return kind === "number" || (kind === "name" && !OPERATOR_WORDS.has(text)) || text === "(" || text === "[";
  }

  /** Parse a factor with its exponents, as in a^b^c. */
  private readonly parsePower = (): Node => {
    const base = this.parsePrimary();
    if (this.peek() !== "**" && this.peek() !== "^") return base;
    const isOfLastName = base === this.joinedProduct;
    const exponents: Node[] = [];
    while (this.take("**", "^")) {
      exponents.push(this.parseSigned(this.parsePrimary));
      if (exponents.length > LIMITS.depth) throw this.errorHere("read.powers", { limit: LIMITS.depth });
    }
    const firstExponent = exponents[0];
    const isTransposed = firstExponent?.kind === "name" && VOCABULARY.transposed.includes(firstExponent.text);
    if (base.kind === "list" && exponents.length === 1 && isTransposed) return transposeList(base);
    let tower = exponents.pop();
    if (!tower) return base;
    for (let exponent = exponents.pop(); exponent; exponent = exponents.pop()) {
      // -a^-b^c: the sign of an exponent applies to the whole power
      const inner = exponent.args[0];
      tower = exponent.kind === "neg" && inner ? node("neg", node("^", inner, tower)) : node("^", exponent, tower);
    }
    const [left, right] = base.args;
    if (isOfLastName && left && right) return node("*", left, node("^", right, tower)); // a1c2^2
    return node("^", base, tower);
  };

  /** Parse the smallest operand: a number, name, bracket, absolute value, or a blank "...". */
  private readonly parsePrimary = (): Node => {
    const { kind, text } = this.currentToken();
    if (kind === "number") {
      this.position += 1;
      return parseNumber(text);
    }
    if (kind === "name" && !OPERATOR_WORDS.has(text)) {
      this.position += 1;
      return this.parseNamed(text);
    }
    if (this.take("...")) return node("blank");
    if (this.take("(")) return this.parseBracket(")", "group");
    if (this.take("[")) return this.parseBracket("]", "list");
    if (this.take("{")) return this.parseBracket("}", "set");
    if (this.take("|")) return this.nest(() => this.parseAbsoluteValue(), "read.brackets");
    throw this.errorHere("read.operand", { found: this.describeToken() });
  };

  /** Parse |a1*sin(theta2)| to its second bar; a bar between two conditions means "or". */
  private parseAbsoluteValue(): Node {
    const wasInBars = this.isInBars;
    this.isInBars = true;
    const inner = this.parseSum();
    this.isInBars = wasInBars;
    this.expect("|");
    return call("abs", inner);
  }

  /** Parse the rest of a bracket whose opening sign was already taken. */
  private parseBracket(closingSign: string, kind: "group" | "list" | "set"): Node {
    const wasInBars = this.isInBars;
    this.isInBars = false;
    const { rows, hasComma } = this.parseRows(closingSign);
    this.isInBars = wasInBars;
    this.joinedProduct = null;
    const isColumn = closingSign !== "]" && rows.every((row) => row.length === 1); // (a; b), {0; pi}
    if (rows.length > 1 && isColumn && kind !== "list") return node("list", ...rows.flat());
    if (rows.length > 1) return listOf(rows); // [a, b; c, d]
    const items = rows[0] as readonly Node[];
    const first = items[0];
    if (kind === "group") return first && items.length === 1 && !hasComma ? first : node("list", ...items);
    return items.some((item) => item.kind === "pair") ? this.buildDictionary(items) : node(kind, ...items);
  }

  private parseArguments(closingSign: string): readonly Node[] {
    return this.parseBracket(closingSign, "list").args;
  }

  /** Parse what begins with a name, which was already taken, such as a function with its arguments. */
  private parseNamed(typedName: string): Node {
    const length = countCharacters(typedName, MAX_NAME_LENGTH);
    if (length > MAX_NAME_LENGTH) throw this.errorHere("read.long-name", { length });
    const hasBracket = this.peek() === "(";
    const meaning = this.meanings.get(typedName);
    if (typeof meaning === "string") return this.parseFunction(meaning);
    if (meaning && !hasBracket) return meaning;
    if (typedName.endsWith(".diff") && hasBracket)
      return this.parseBindingCall("Derivative", this.firstPiece(typedName.slice(0, -".diff".length)));
    const plainTypedName = toPlainName(typedName);
    if (hasBracket && BINDING_CALLS.has(plainTypedName)) return this.parseBindingCall(plainTypedName, null);
    const isVariable = this.symbols.has(plainTypedName) || JOINT.test(plainTypedName);
    if (hasBracket && isVariable && this.textAhead(1) === "t" && this.textAhead(2) === ")") {
      this.position += 3; // theta1(t), as dynamicsymbols prints it
      return this.firstPiece(typedName);
    }
    if (hasBracket && CALL_MEANINGS.has(plainTypedName)) {
      this.position += 1;
      return this.buildCall(plainTypedName, this.parseArguments(")"));
    }
    if (UNDEFINED_NAMES.has(plainTypedName)) {
      this.position -= 1; // the error is at the name, which was already taken
      throw this.errorHere("read.no-answer", { name: plainTypedName });
    }
    if (BLANK_NAMES.has(plainTypedName)) return node("blank");
    if (SHORTHAND.has(plainTypedName) && !this.symbols.has(plainTypedName) && this.isAngleAhead())
      return this.parseShorthand(plainTypedName);
    const pieces = this.piecesOf(typedName);
    const symbol = pieces.length === 1 && pieces[0]?.kind === "name" ? pieces[0].parts[0] : undefined;
    if (
      hasBracket &&
      symbol &&
      !this.symbols.has(plainTypedName) &&
      !this.symbols.has(symbol) &&
      !BEFORE_BRACKETS.has(symbol)
    ) {
      const beginsStatement = this.position === 1 || BEFORE_STATEMENT.has(this.textAhead(-2));
      const indexAfterBracket = beginsStatement ? this.findEndOfBracket() : 0;
      if (this.tokens[indexAfterBracket]?.text === "=") {
        this.position = indexAfterBracket; // J(q) = …
        return name(symbol);
      }
      throw this.errorHere("read.function", { name: plainTypedName });
    }
    const onlyPiece = pieces.length === 1 && plainTypedName === typedName ? pieces[0] : undefined;
    if (onlyPiece?.kind === "function") this.meanings.set(typedName, onlyPiece.parts[0] as string);
    else if (onlyPiece && this.symbols.has(plainTypedName)) this.meanings.set(typedName, buildTreeOfPiece(onlyPiece));
    const product = this.buildProduct(pieces);
    if (FUNCTIONS.has(pieces.at(-1)?.kind ?? "") && SHORTHAND_OF_ANGLE.test(plainTypedName))
      this.bareArgumentEnd = this.position;
    return product;
  }

  /** Return the index of the token after the bracket that begins here; 0 if the bracket is never closed. */
  private findEndOfBracket(): number {
    let depth = 0;
    for (let index = this.position; index < this.tokens.length; index += 1) {
      depth += computeDepthChange((this.tokens[index] as Token).text);
      if (depth === 0) return index + 1;
    }
    return 0;
  }

  /** Return whether an angle or a bracket follows, possibly after a power: c theta1, s^2(theta1). */
  private isAngleAhead(): boolean {
    const isPower = this.peek() === "^" || this.peek() === "**";
    const distance = !isPower ? 0 : this.textAhead(1) === "(" ? 4 : 2;
    const { kind, text } = this.tokenAhead(distance);
    const piece = kind === "name" ? this.piecesOf(text)[0] : undefined;
    return text === "(" || piece?.kind === "sum" || ANGLE.test(piece?.parts[0] ?? "");
  }

  /** Parse c or s of an angle; S(1), as SymPy writes it, is not a sine. */
  private parseShorthand(shorthand: string): Node {
    const start = this.position;
    const functionName = SHORTHAND.get(shorthand) as string;
    const result = this.parseFunction(functionName);
    if ([...findNames(result)].some((symbol) => ANGLE.test(symbol))) return result;
    this.position = start;
    throw this.errorHere("read.shorthand", { name: shorthand, function: functionName });
  }

  private piecesOf(typedName: string): readonly Piece[] {
    const pieces = this.piecesOfNames.get(typedName) ?? splitIntoPieces(typedName, this.symbols);
    this.piecesOfNames.set(typedName, pieces);
    return pieces;
  }

  private firstPiece(typedName: string): Node {
    return buildTreeOfPiece(this.piecesOf(typedName)[0] as Piece);
  }

  /** Return the product that joined names mean, such as a1c2; a function applies to the piece or text after it. */
  private buildProduct(pieces: readonly Piece[]): Node {
    const factors: Node[] = [];
    for (let i = 0; i < pieces.length; i += 1) {
      const piece = pieces[i] as Piece;
      const next = pieces[i + 1];
      const functionName = piece.parts[0] as string;
      if (piece.kind !== "function") factors.push(buildTreeOfPiece(piece));
      else if (next && next.kind !== "function" && !ARITY.has(functionName)) {
        factors.push(applyFunction(functionName, [buildTreeOfPiece(next)]));
        i += 1;
        this.bareArgumentEnd = i + 1 >= pieces.length ? this.position : -1;
      } else if (!next) factors.push(this.parseFunction(functionName));
      else throw this.errorHere("read.no-argument", { name: functionName });
    }
    const product = factors.reduce((product, factor) => node("*", product, factor));
    if (factors.length > 1) this.joinedProduct = product;
    return product;
  }

  /** Parse Derivative(theta1(t), t), the rate qd1; or Lambda(_n, …), in which _n is any whole number. */
  private parseBindingCall(kind: string, firstArgument: Node | null): Node {
    this.position += 1;
    const args = [...(firstArgument ? [firstArgument] : []), ...this.parseArguments(")")];
    const [first, second] = args;
    const isRate = BINDING_CALLS.get(kind) === "rate";
    if (isRate && first?.kind === "name" && args.length <= 2) {
      const joint = JOINT.exec(first.text);
      if (joint) return name(`qd${joint[1]}`);
    }
    if (!isRate && first?.kind === "name" && second && args.length === 2) {
      return replaceName(second, first.text, name(VOCABULARY.whole_numbers[0] as string));
    }
    throw this.errorHere("read.bound", { name: kind });
  }

  private parseFunction(functionName: string): Node {
    return this.nest(() => this.parseCall(functionName), "read.functions");
  }

  private parseCall(functionName: string): Node {
    const power = this.take("^", "**") ? this.parseSigned(this.parsePrimary) : null; // sin^2(x)
    const openingSign = this.peek();
    const args = this.take("(")
      ? this.parseArguments(")")
      : this.take("[")
        ? this.parseArguments("]")
        : [this.parseBareArgument(functionName)];
    this.bracesAreLists ||= openingSign === "[";
    const expectedCount = ARITY.get(functionName) ?? 1;
    if (args.length !== expectedCount)
      throw this.errorHere("read.arguments", { name: functionName, expected: expectedCount, count: args.length });
    const isInverse = power?.kind === "neg" && power.args[0]?.kind === "number" && power.args[0].value === 1;
    const inverseName = isInverse ? INVERSE_FUNCTIONS.get(functionName) : undefined;
    if (inverseName !== undefined) return applyFunction(inverseName, args); // sin^-1(x) is the arc sine
    const result = applyFunction(functionName, args);
    return power ? node("^", result, power) : result;
  }

  /** Parse the argument of a function without brackets: a number, a name, or both, as in sin 2 theta1. */
  private parseBareArgument(functionName: string): Node {
    const factors: Node[] = [];
    if (this.currentToken().kind === "number") {
      factors.push(parseNumber(this.peek()));
      this.position += 1;
    }
    if (this.currentToken().kind === "name" && !OPERATOR_WORDS.has(this.peek())) {
      const laterPieces = this.piecesOf(this.peek()).slice(1); // sin theta1cos(theta2)
      if (laterPieces.some(({ kind }) => kind !== "name")) throw this.errorHere("read.bare", { name: functionName });
      this.position += 1;
      factors.push(this.parseNamed(this.textAhead(-1)));
    }
    if (factors.length === 0 || ["/", "^", "**"].includes(this.peek()))
      throw this.errorHere("read.bare", { name: functionName });
    this.bareArgumentEnd = this.position;
    return factors.reduce((product, factor) => node("*", product, factor));
  }

  /** Return the tree of a call in `CALL_MEANINGS`. */
  private buildCall(kind: string, args: readonly Node[]): Node {
    const [first, second, third] = args;
    const meaning = CALL_MEANINGS.get(kind) as string;
    const isCondition = first !== undefined && (meaning === "or" || meaning === "and");
    const isPair = args.length === 2 && ["eq", "in", "/", "^"].includes(meaning);
    if (meaning === "set" || isCondition || isPair) return node(meaning as Kind, ...args);
    if (meaning === "image" && first && args.length === 2 && isWholeNumbers(second as Node)) return first;
    if (meaning === "condition" && second && args.length <= 3) return second;
    if (meaning === "transposed" && first && args.length === 1) return transposeList(first);
    if (meaning === "inverse" && first && args.length === 1) return node("^", first, node("neg", integer(1)));
    if (meaning === "modulo" && first && second && args.length === 2) {
      // the rest is a whole number of times the second argument less
      return node("-", first, node("*", name(VOCABULARY.whole_numbers[0] as string), second));
    }
    if (first && args.length === 1) return first;
    if (meaning === "matrix" && args.length === 3 && first && second && third?.kind === "list") {
      const matrix = buildMatrix(first, second, third);
      if (matrix) return matrix;
    }
    if (meaning === "diagonal" && args.length <= LIMITS.matrix_rows) {
      return listOf(args.map((arg, i) => args.map((_, j) => (i === j ? arg : integer(0)))));
    }
    if (meaning === "list") return node("list", ...args);
    throw this.errorHere("read.container", { name: kind, count: args.length });
  }
}

const beginsWithConstant = (text: string): boolean =>
  VOCABULARY.before_whole_numbers.some((constant) => text.startsWith(constant));

/** Return the only value, or the set of several. */
const wrapValues = (values: readonly Node[]): Node =>
  values.length === 1 ? (values[0] as Node) : node("set", ...values);

/** Return whether a node is a value of a joint: it has no symbols except whole numbers such as k. */
const isValue = (value: Node): boolean =>
  !["eq", "in", "and", "or"].includes(value.kind) &&
  [...findNames(value)].every((symbol) => VOCABULARY.whole_numbers.includes(symbol));

/** Convert a value to metres and radians: a hundredth of cm, pi/180 of degrees. */
function convertUnit(value: Node, unit: string): Node {
  const factor = UNITS.get(unit) as string;
  if (factor.startsWith("/")) return node("/", value, integer(Number(factor.slice(1))));
  return factor ? applyFunction("radians", [value]) : value;
}

/** Return the transpose of a list of rows; a list of entries, which may be a column, stays unchanged. */
function transposeList(matrix: Node): Node {
  const rows = matrix.args.map(({ args }) => args);
  return isRectangle(matrix.args) && rows[0]?.length ? listOf(transposeRows(rows)) : matrix;
}

const isWholeNumbers = ({ text }: Node): boolean => VOCABULARY.whole_number_sets.includes(text);

/** Return the matrix of Matrix(rows, columns, [entries]); null if the number of entries differs. */
function buildMatrix(rows: Node, columns: Node, entries: Node): Node | null {
  const [rowCount, columnCount] = [rows.value, columns.value];
  const { args } = entries;
  const isRow = (row: Node) => row.kind === "list" && row.args.length === columnCount;
  if (rowCount > 0 && rowCount === args.length && args.every(isRow)) return entries; // as in Maple
  const isWhole = rows.kind === "number" && columns.kind === "number";
  const count = rowCount * columnCount;
  return isWhole && count > 0 && count === args.length ? listOf(splitIntoRows(args, columnCount)) : null;
}

/** Return the tree of a piece of a name. */
function buildTreeOfPiece(piece: Piece): Node {
  if (piece.kind === "name") return name(piece.parts[0] as string);
  const angle = piece.parts.map(name).reduce((total, part) => node("+", total, part));
  return piece.kind === "sum" ? angle : call(piece.kind, angle);
}

/** Return a function applied to arguments; "radians" converts from degrees. */
function applyFunction(functionName: string, args: readonly Node[]): Node {
  if (functionName === "radians") return node("/", node("*", args[0] as Node, name("pi")), integer(180));
  return call(functionName, ...args);
}

const DIGITS = /^[0-9]+$/;

/** Return the node of a number. Throws ParseError if it is too long or too large. */
function parseNumber(text: string): Node {
  if (text.length < 16 && DIGITS.test(text)) return integer(Number(text), text);
  const [mantissa = "", exponent = ""] = text.toLowerCase().split("e");
  const isLong = mantissa.length > LIMITS.mantissa || exponent.length > LIMITS.exponent_characters;
  if (isLong || Math.abs(Number(exponent)) > LIMITS.exponent) {
    throw new ParseError("read.range", { number: text.slice(0, 20) });
  }
  const isDecimal = mantissa.includes(".") || exponent !== "";
  const digits = mantissa.replace(".", "").replace(/^0+/, "").replace(/0+$/, "").length;
  const number = { ...node(isDecimal ? "decimal" : "number"), text, value: Number(text) };
  return { ...number, digits: isDecimal ? digits : 0 };
}
