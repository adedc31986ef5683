// Parse a text to a tree of plain nodes, by a grammar and a whitelist; nothing of the text is ever executed.
// The grammar of ../../../exercises/formula/parser.py; ../../tests/readers.test.ts compares both.

import { type Message, message, type Values, type TextKey } from "../text/text.js";
import { METRE, withoutMetres } from "./metres.js";
import { ARITY, factorsOf, FUNCTIONS, MAX_NAME_LENGTH, type Piece, piecesOf, plainName, SHORTHAND } from "./names.js";
import { plain } from "./notation.js";
import { carryOutProducts } from "./products.js";
import { deeperBy, type Token, tokensOf } from "./tokens.js";
import {
  call,
  CHAIN,
  columnsOf,
  inRows,
  integer,
  isRectangle,
  type Kind,
  listOf,
  name,
  namesIn,
  type Node,
  node,
  errorAt,
  ParseError,
  rebuild,
  replaceName,
} from "./tree.js";
import { lengthOf, LIMITS, pattern, table, VOCABULARY, wholePattern } from "./vocabulary.js";

/** Calls of SymPy, NumPy or Python that are no functions of numbers, with their meaning. */
const CONTAINERS = table(VOCABULARY.call_meanings);
const BOUND = table(VOCABULARY.binding_calls);
const UNDEFINED = new Set(Object.keys(VOCABULARY.undefined));
const BLANK = new Set(VOCABULARY.blank);
/** Names between two conditions, which are no factors. */
const WORDS = new Set(VOCABULARY.operator_words);
const INVERSES = table(VOCABULARY.inverses);
const JOINT = wholePattern("joint");
const ANGLE = wholePattern("angle");
const SHORT_OF_ANGLE = pattern("shorthand_of_angle");
const SYNONYMS = table<string>(VOCABULARY.synonyms);
/** Names that are multiplied by a bracket after them: nobody defines functions of these names. */
const BEFORE_BRACKETS = new Set(["pi", "I", ...VOCABULARY.whole_numbers]);
const MODULO = new Set(VOCABULARY.modulo);
const UNITS = table(VOCABULARY.units);
const POWERS_OF_UNIT = new Set(["/", "^", "**"]);
/** Tokens after a name that is a factor, and no unit at the end of a product. */
const AFTER_FACTOR = new Set(["*", "(", ...POWERS_OF_UNIT]);

/** Tokens that a factor between bars can't contain, and tokens that may follow its second bar. */
const NO_FACTOR = new Set(["=", "==", ",", ";", ":", "&"]);
const ENDS_FACTOR = new Set(["*", "/", "^", "**", "=", "==", ")", "]", "}", ",", ";"]);
const BEFORE_STATEMENT = new Set([",", ";", "and", "&", "or", "[", "(", "{"]);
/** Words after a comma that add nothing to it; entries of a vector are no alternatives. */
const BETWEEN_ENTRIES = new Set(["and", "&"]);
const BETWEEN_CONDITIONS = new Set(["and", "&", "or", "|"]);

/** Parse a text; `known` are the names of the problem's symbols, which have precedence over shorthand. */
export function parse(text: string, known: ReadonlySet<string>): Node {
  const length = lengthOf(text, LIMITS.characters);
  if (length > LIMITS.characters) throw new ParseError("read.long", { length, most: LIMITS.characters });
  return new Parser(plain(text, known), known).parse();
}

/** Operator-precedence parser. Depth is limited, so that no text can exhaust the stack. */
class Parser {
  private readonly tokens: readonly Token[];
  /** Meanings of function names and symbols that do not depend on their place, by name. */
  private readonly plain = new Map<string, string | Node>();
  private readonly pieces = new Map<string, readonly Piece[]>();
  private at = 0;
  private depth = 0;
  /** The token index at which the argument of a function without brackets ended last. */
  private bareArgumentEnd = -1;
  /** The last product of names without a space between them, and without brackets. */
  private joinedProduct: Node | null = null;
  /** Whether the next bar ends an absolute value. */
  private inBars = false;
  /** Whether functions have square brackets, as in Mathematica, so that {a, b} is a list. */
  private bracesAreLists = false;

  constructor(
    private readonly text: string,
    private readonly known: ReadonlySet<string>,
  ) {
    this.tokens = tokensOf(text).flatMap((token) => this.translate(token));
    const count = this.tokens.filter((token) => token.text === "±").length;
    if (count > LIMITS.plus_minus_signs) throw new ParseError("read.either", { count });
  }

  /** Return a token, or the tokens that a word means, such as `or` for the German word oder. */
  private translate(token: Token): readonly Token[] {
    if (token.kind !== "name") return [token];
    const text = this.known.has(token.text) ? undefined : SYNONYMS.get(token.text);
    if (text === "") return [];
    if (text !== undefined) {
      const kind = /^[0-9]+$/.test(text) ? "number" : /^[a-z]+$/.test(text) ? "name" : "op";
      return [{ ...token, kind, text }];
    }
    let { at } = token;
    const factors = factorsOf(token.text, this.known).flatMap((name): readonly Token[] => {
      const times: Token = { kind: "op", text: "*", at };
      const factor: Token = { kind: "name", text: name, at };
      at += name.length + 1;
      return [times, factor];
    });
    return factors.length > 0 ? factors.slice(1) : [token]; // a1.a2.sin
  }

  parse(): Node {
    if (this.here().kind === "end") throw new ParseError("read.nothing");
    this.skipLambda();
    const parsed = this.parseAll();
    const asList = (top: Node, args: readonly Node[]): Node => ({
      ...top,
      args,
      kind: top.kind === "set" ? "list" : top.kind,
    });
    const tree = this.bracesAreLists ? rebuild(parsed, asList) : parsed;
    const isMetre = !this.known.has(METRE) && this.tokens.some(({ text }) => text === METRE);
    return carryOutProducts(isMetre ? withoutMetres(tree) : tree);
  }

  /** Parse everything up to the end. */
  private parseAll(): Node {
    const parsedRows = this.rows("");
    if (this.here().kind !== "end") throw this.fail("read.unexpected", { found: this.describeToken() });
    const flat = parsedRows.rows.every((row) => row.length === 1); // a; b
    const rows = parsedRows.rows.length > 1 && flat ? [parsedRows.rows.flat()] : parsedRows.rows;
    if (rows.length > 1) return listOf(rows);
    const items = rows[0] as readonly Node[];
    if (items.length === 0) throw new ParseError("read.nothing"); // only semicolons
    if (items.some(({ kind }) => kind === "pair")) return this.dictionaryOf(items); // x: a, y: b
    return parsedRows.comma || items.length > 1 ? node("list", ...items) : (items[0] as Node);
  }

  /**
   * Parse entries between commas, in rows that semicolons end, up to the closing sign; also return whether there was a
   * comma. In braces, and outside of brackets, an entry may be named, as in x: a.
   */
  private rows(close: string): { rows: readonly (readonly Node[])[]; comma: boolean } {
    const rows: Node[][] = [[]];
    let comma = false;
    while (!this.closed(close)) {
      if (this.take(";")) {
        rows.push([]);
        continue;
      }
      const first = this.disjunction();
      const isJoined = close === "" && this.isCommaAnd() && this.isCondition(first);
      const item = isJoined ? this.conjunctionAfterComma(first, rows) : first;
      const named = (close === "" || close === "}") && this.take(":");
      rows.at(-1)?.push(named ? node("pair", item, this.disjunction()) : item);
      if (this.take(",")) {
        comma = true;
        const [[begun]] = rows.filter((row) => row.length > 0) as [[Node]];
        const beside = this.isCondition(begun) ? BETWEEN_CONDITIONS : BETWEEN_ENTRIES;
        if (close === "" && beside.has(this.peek())) {
          this.at += 1;
          if (this.here().kind === "end") throw this.fail("read.operand", { found: this.describeToken() });
        }
      } else if (this.peek() !== ";") {
        if (close) this.expect(close);
        break;
      }
    }
    const filled = rows.filter((row) => row.length > 0);
    return { rows: filled.length > 0 ? filled : [[]], comma };
  }

  private closed(close: string): boolean {
    return close ? this.take(close) : this.here().kind === "end";
  }

  /** Return a dictionary from pairs and the values after them. */
  private dictionaryOf(items: readonly Node[]): Node {
    const pairs: Node[][] = [];
    for (const item of items) {
      const last = pairs.at(-1);
      if (item.kind === "pair") pairs.push([...item.args]);
      else if (last && isValue(item))
        last.push(item); // theta2: 0, pi
      else throw this.fail("read.dictionary");
    }
    return node("dict", ...pairs.map(([called, ...values]) => node("pair", called as Node, oneOrSet(values))));
  }

  private here(): Token {
    return this.tokens[this.at] as Token;
  }

  private peek(): string {
    return this.here().text;
  }

  private ahead(count: number): Token {
    return this.tokens[Math.min(this.at + count, this.tokens.length - 1)] as Token;
  }

  private textAt(ahead: number): string {
    return this.ahead(ahead).text;
  }

  private fail(key: TextKey, values: Values = {}): ParseError {
    return errorAt(key, values, this.text, this.here().at);
  }

  /** Return the current token as errors name it. */
  private describeToken(): string | Message {
    return this.peek() ? `'${this.peek()}'` : message("read.the-end");
  }

  private take(sign: string, synonym = sign): boolean {
    const { kind, text } = this.here();
    if ((text !== sign && text !== synonym) || (kind !== "op" && kind !== "name")) return false;
    this.at += 1;
    return true;
  }

  private expect(text: string): void {
    if (!this.take(text)) throw this.fail("read.expected", { due: text, found: this.describeToken() });
  }

  private deeper<T>(work: () => T, tooDeep: TextKey): T {
    this.depth += 1;
    if (this.depth > LIMITS.depth) throw this.fail(tooDeep, { most: LIMITS.depth });
    const result = work();
    this.depth -= 1;
    return result;
  }

  /** Skip the head of a Python function, lambda theta1, theta2: …; its result is the answer. */
  private skipLambda(): void {
    if (!this.take("lambda")) return;
    while (this.here().kind === "name") {
      this.at += 1;
      if (!this.take(",")) break;
    }
    this.expect(":");
  }

  private isCommaAnd(): boolean {
    return this.peek() === "," && ["and", "&"].includes(this.textAt(1));
  }

  /** Return whether a term is a condition on a symbol of the problem; x = 1 only names an entry. */
  private isCondition({ kind, args }: Node): boolean {
    if (kind === "and" || kind === "or") return args.every((arg) => this.isCondition(arg));
    return (kind === "eq" || kind === "in") && [...namesIn(args[0] as Node)].some((symbol) => this.known.has(symbol));
  }

  /** Parse "A, and B" as "A and B" if B is a condition; other commas make it ambiguous. */
  private conjunctionAfterComma(first: Node, rows: readonly (readonly Node[])[]): Node {
    const here = this.at;
    const terms = first.kind === "and" ? [...first.args] : [first];
    while (this.isCommaAnd()) {
      const before = this.at;
      this.at += 2;
      const term = this.relation();
      if (!this.isCondition(term)) {
        this.at = before;
        break;
      }
      terms.push(term);
    }
    if (this.at === here) return first;
    const isAlone = rows.length === 1 && rows[0]?.length === 0;
    const isOpen = [",", "or", "|"].includes(this.peek());
    if (!isAlone || isOpen || first.kind === "or") throw this.fail("read.unexpected", { found: "'and'" });
    return node("and", ...terms);
  }

  private readonly alternatives = (): Node => this.several("or", this.conjunction, "or", "|");

  private disjunction(): Node {
    return this.deeper(this.alternatives, "read.brackets");
  }

  // Functions that others call back are fields: binding them for each of ten thousand brackets would take long.
  private readonly conjunction = (): Node => this.several("and", this.relation, "and", "&");

  private several(kind: "or" | "and", parseTerm: () => Node, word: string, sign: string): Node {
    const first = parseTerm();
    if (!this.take(word, sign)) return first;
    const terms = [first, parseTerm()];
    while (this.take(word, sign)) terms.push(parseTerm());
    return node(kind, ...terms);
  }

  private readonly relation = (): Node => {
    const first = this.modulo(this.sum());
    if (this.take("in")) return node("in", first, this.modulo(this.sum()));
    const sides = [first];
    while (this.take("=", "==")) sides.push(this.values());
    if (sides.length > 2 && sides[0]?.kind === "name" && sides[1]?.kind === "list") sides.shift(); // P = [x; y] = […]
    const equations = sides.slice(1).map((right, i) => node("eq", sides[i] as Node, right));
    if (equations.length > 1) return { ...node("and", ...equations), text: CHAIN }; // theta1 = theta2 = 0
    return equations[0] ?? first;
  };

  /** Parse the right side of an equation: a value, or several, as in theta2 = 0 or pi. */
  private values(): Node {
    const values = [this.modulo(this.sum())];
    while (["or", "and", "|", "&"].includes(this.peek())) {
      const here = this.at;
      this.at += 1;
      const other = this.here().kind === "end" ? null : this.modulo(this.sum());
      if (!other || ["=", "==", "in", ":"].includes(this.peek()) || !isValue(other)) {
        this.at = here; // another condition begins there
        break;
      }
      values.push(other);
    }
    return oneOrSet(values);
  }

  /** Parse theta2 = 0 mod pi, or (mod pi): the value, and all values that differ by multiples of pi. */
  private modulo(value: Node): Node {
    const bracket = this.peek() === "(" && MODULO.has(this.textAt(1));
    if (!bracket && !MODULO.has(this.peek())) return value;
    this.at += bracket ? 2 : 1;
    const isNumber = ["end", "op"].includes(this.here().kind) && this.peek() !== "(";
    if (this.textAt(-1) === "%" && isNumber) throw this.fail("read.percent");
    const step = node("*", name(VOCABULARY.whole_numbers[0] as string), this.sum());
    if (bracket) this.expect(")");
    const isCollection = value.kind === "list" || value.kind === "set";
    return isCollection ? node(value.kind, ...value.args.map((part) => node("+", part, step))) : node("+", value, step);
  }

  private sum(): Node {
    const isEither = this.take("±");
    let top = isEither ? this.product() : this.signed(this.product);
    if (isEither) top = node("set", top, node("neg", top));
    for (let op = this.peek(); op === "+" || op === "-" || op === "±"; op = this.peek()) {
      const isAfterBareArgument = this.at === this.bareArgumentEnd;
      this.at += 1;
      const right = this.signed(this.product);
      if (isAfterBareArgument && right.kind === "name" && ANGLE.test(right.text))
        throw this.fail("read.reach", { sign: op, name: right.text });
      top = op === "±" ? node("set", node("+", top, right), node("-", top, right)) : node(op, top, right);
    }
    return top;
  }

  /** Parse the next operand, with the product of all signs before it. */
  private signed(next: () => Node): Node {
    let negative = false;
    while (this.here().kind === "op" && (this.peek() === "+" || this.peek() === "-")) {
      negative = negative !== (this.peek() === "-");
      this.at += 1;
    }
    return negative ? node("neg", next()) : next();
  }

  private readonly product = (): Node => {
    let top = this.power();
    let divisorEnd = -1;
    for (;;) {
      if (this.take("*", ".")) {
        top = node("*", top, this.signed(this.power));
        divisorEnd = -1;
      } else if (this.take("/")) {
        const here = this.at;
        const divisor = this.signed(this.power);
        top = node("/", top, divisor);
        divisorEnd = this.isSymbol(here) && divisor.kind === "name" ? this.at : -1;
      } else if (this.here().kind === "number" && this.tokens[this.at - 1]?.kind === "number") {
        throw this.fail("read.two-numbers"); // 1 000 or 1.2.3 is probably no product
      } else if (this.here().kind === "number" && this.peek().startsWith(".")) {
        throw this.fail("read.point", { number: this.peek(), factor: this.peek().slice(1) }); // a1.2
      } else if (this.peek() === "(" && MODULO.has(this.textAt(1))) return top;
      else if (this.isUnit()) {
        top = inUnit(top, this.peek());
        this.at += 1;
      } else if (this.at === divisorEnd && this.here().kind === "name" && !WORDS.has(this.peek())) {
        throw this.fail("read.below", { name: this.textAt(-1), next: this.peek() });
      } else if (this.peek() === "|" && this.isBarOfFactor()) top = node("*", top, this.power());
      else if (this.peek() === "[" && this.isRowBelow(top)) top = this.withRow(top);
      else if (this.startsFactor()) top = node("*", top, this.factor());
      else return top;
    }
  };

  /** Return whether a divisor is a single name. */
  private isSymbol(at: number): boolean {
    const { kind, text } = this.tokens[at] as Token;
    return kind === "name" && this.at === at + 1 && !isConstant(text);
  }

  /** Parse a factor without a sign; [0] is no factor, because Python would select an entry by it. */
  private factor(): Node {
    const here = this.at;
    const bracket = this.peek() === "[";
    const factor = this.power();
    const [only] = factor.args;
    if (bracket && factor.kind === "list" && factor.args.length === 1 && /^(number|neg)$/.test(only?.kind ?? "")) {
      this.at = here;
      throw this.fail("read.no-entry");
    }
    return factor;
  }

  /** Return whether a factor between bars begins here, as in a1|s2|, and no alternative after a bar, as in 0 | pi. */
  private isBarOfFactor(): boolean {
    if (this.inBars) return false;
    let depth = 0;
    let symbols = false;
    let at = this.at + 1;
    for (; ; at += 1) {
      const { kind, text } = this.tokens[at] as Token;
      if (kind === "end" || (text === "|" && depth === 0)) break;
      depth += deeperBy(text);
      if (depth < 0 || (depth === 0 && (NO_FACTOR.has(text) || WORDS.has(text)))) return false;
      symbols ||= kind === "name" && !isConstant(text);
    }
    const [bar, first, last, close] = [this.here(), this.tokens[this.at + 1], this.tokens[at - 1], this.tokens[at]];
    if (!first || !last || close?.kind === "end" || !symbols) return false;
    const isTight = first.at === bar.at + 1 && last.at + last.text.length === close?.at;
    const behind = this.tokens[at + 1] as Token;
    return isTight || behind.kind === "end" || ENDS_FACTOR.has(behind.text);
  }

  /** Return whether a list is a row with another row after it, as calculators write [a, b][c, d]. */
  private isRowBelow(top: Node): boolean {
    return top.kind === "list" && top.args.length > 1 && this.textAt(-1) === "]" && !this.isColumnAhead();
  }

  /** Return whether the list that begins here has rows, as in [a; b] or [[a, b], [c, d]]. */
  private isColumnAhead(): boolean {
    let depth = 0;
    for (let at = this.at; at < this.tokens.length; at += 1) {
      const { text } = this.tokens[at] as Token;
      depth += deeperBy(text);
      if (depth === 0) return false;
      if ((text === ";" && depth === 1) || (text === "[" && at === this.at + 1)) return true;
    }
    return false;
  }

  /** Add the list that follows as a row. */
  private withRow(top: Node): Node {
    this.take("[");
    const row = this.bracketed("]", "list");
    const rows = top.args.every(({ kind }) => kind === "list") ? top.args : [top];
    if (rows.length >= LIMITS.matrix_rows || rows.some(({ args }) => args.length !== row.args.length))
      throw this.fail("read.two-lists");
    return node("list", ...rows, row);
  }

  /** Return whether a name after a number is a unit, as in 0.25 rad or 25 cm * a1; metres.ts decides on m later. */
  private isUnit(): boolean {
    const { kind, text } = this.here();
    const isName = kind === "name" && UNITS.has(text) && !this.known.has(text);
    if (!isName || VOCABULARY.whole_numbers.includes(text)) return false;
    const before = this.tokens[this.at - 1];
    if (before?.kind !== "number" && !VOCABULARY.before_whole_numbers.includes(before?.text ?? "")) return false;
    const next = this.ahead(1);
    if (VOCABULARY.lengths.includes(text)) return !POWERS_OF_UNIT.has(next.text);
    return !AFTER_FACTOR.has(next.text) && (next.kind !== "name" || WORDS.has(next.text)) && next.kind !== "number";
  }

  private startsFactor(): boolean {
    const { kind, text } = this.here();
    return kind === "number" || (kind === "name" && !WORDS.has(text)) || text === "(" || text === "[";
  }

  private readonly power = (): Node => {
    const base = this.primary();
    if (this.peek() !== "**" && this.peek() !== "^") return base;
    const isOfLastName = base === this.joinedProduct;
    const exponents: Node[] = [];
    while (this.take("**", "^")) {
      exponents.push(this.signed(this.primary));
      if (exponents.length > LIMITS.depth) throw this.fail("read.powers", { most: LIMITS.depth });
    }
    const raised = exponents[0];
    const isTransposed = raised?.kind === "name" && VOCABULARY.transposed.includes(raised.text);
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

  private readonly primary = (): Node => {
    const { kind, text } = this.here();
    if (kind === "number") {
      this.at += 1;
      return numberOf(text);
    }
    if (kind === "name" && !WORDS.has(text)) {
      this.at += 1;
      return this.named(text);
    }
    if (this.take("...")) return node("blank");
    if (this.take("(")) return this.bracketed(")", "group");
    if (this.take("[")) return this.bracketed("]", "list");
    if (this.take("{")) return this.bracketed("}", "set");
    if (this.take("|")) return this.deeper(() => this.absolute(), "read.brackets");
    throw this.fail("read.operand", { found: this.describeToken() });
  };

  /** Parse |a1*sin(theta2)| to its second bar; a bar between two conditions means "or". */
  private absolute(): Node {
    const outer = this.inBars;
    this.inBars = true;
    const inner = this.sum();
    this.inBars = outer;
    this.expect("|");
    return call("abs", inner);
  }

  private bracketed(close: string, kind: "group" | "list" | "set"): Node {
    const outer = this.inBars;
    this.inBars = false;
    const { rows, comma } = this.rows(close);
    this.inBars = outer;
    this.joinedProduct = null;
    const inLine = close !== "]" && rows.every((row) => row.length === 1); // (a; b), {0; pi}
    if (rows.length > 1 && inLine && kind !== "list") return node("list", ...rows.flat());
    if (rows.length > 1) return listOf(rows); // [a, b; c, d]
    const items = rows[0] as readonly Node[];
    const first = items[0];
    if (kind === "group") return first && items.length === 1 && !comma ? first : node("list", ...items);
    return items.some((item) => item.kind === "pair") ? this.dictionaryOf(items) : node(kind, ...items);
  }

  private args(close: string): readonly Node[] {
    return this.bracketed(close, "list").args;
  }

  /** Parse a name, and what belongs to it, such as the arguments of a function. */
  private named(raw: string): Node {
    const length = lengthOf(raw, MAX_NAME_LENGTH);
    if (length > MAX_NAME_LENGTH) throw this.fail("read.long-name", { length });
    const opens = this.peek() === "(";
    const plain = this.plain.get(raw);
    if (typeof plain === "string") return this.function(plain);
    if (plain && !opens) return plain;
    if (raw.endsWith(".diff") && opens) return this.bound("Derivative", this.first(raw.slice(0, -".diff".length)));
    const spelled = plainName(raw);
    if (opens && BOUND.has(spelled)) return this.bound(spelled, null);
    const varies = this.known.has(spelled) || JOINT.test(spelled);
    if (opens && varies && this.textAt(1) === "t" && this.textAt(2) === ")") {
      this.at += 3; // theta1(t), as dynamicsymbols prints it
      return this.first(raw);
    }
    if (opens && CONTAINERS.has(spelled)) {
      this.at += 1;
      return this.container(spelled, this.args(")"));
    }
    if (UNDEFINED.has(spelled)) {
      this.at -= 1; // the error is at the name, which was already taken
      throw this.fail("read.no-answer", { name: spelled });
    }
    if (BLANK.has(spelled)) return node("blank");
    if (SHORTHAND.has(spelled) && !this.known.has(spelled) && this.isAngleAhead()) return this.shorthand(spelled);
    const pieces = this.piecesOf(raw);
    const symbol = pieces.length === 1 && pieces[0]?.kind === "name" ? pieces[0].parts[0] : undefined;
    if (opens && symbol && !this.known.has(spelled) && !this.known.has(symbol) && !BEFORE_BRACKETS.has(symbol)) {
      const isFirst = this.at === 1 || BEFORE_STATEMENT.has(this.textAt(-2));
      const behind = isFirst ? this.behindBracket() : 0;
      if (this.tokens[behind]?.text === "=") {
        this.at = behind; // J(q) = …
        return name(symbol);
      }
      throw this.fail("read.function", { name: spelled });
    }
    const only = pieces.length === 1 && spelled === raw ? pieces[0] : undefined;
    if (only?.kind === "function") this.plain.set(raw, only.parts[0] as string);
    else if (only && this.known.has(spelled)) this.plain.set(raw, treeOfPiece(only));
    const product = this.productOf(pieces);
    if (FUNCTIONS.has(pieces.at(-1)?.kind ?? "") && SHORT_OF_ANGLE.test(spelled)) this.bareArgumentEnd = this.at;
    return product;
  }

  /** Return the token index after the closing bracket; 0 if the bracket is never closed. */
  private behindBracket(): number {
    let depth = 0;
    for (let at = this.at; at < this.tokens.length; at += 1) {
      depth += deeperBy((this.tokens[at] as Token).text);
      if (depth === 0) return at + 1;
    }
    return 0;
  }

  /** Return whether an angle or a bracket follows, possibly after a power: c theta1, s^2(theta1). */
  private isAngleAhead(): boolean {
    const isPower = this.peek() === "^" || this.peek() === "**";
    const ahead = !isPower ? 0 : this.textAt(1) === "(" ? 4 : 2;
    const { kind, text } = this.ahead(ahead);
    const piece = kind === "name" ? this.piecesOf(text)[0] : undefined;
    return text === "(" || piece?.kind === "sum" || ANGLE.test(piece?.parts[0] ?? "");
  }

  /** Parse c or s of an angle; S(1), as SymPy writes it, is no sine. */
  private shorthand(short: string): Node {
    const here = this.at;
    const functionName = SHORTHAND.get(short) as string;
    const result = this.function(functionName);
    if ([...namesIn(result)].some((symbol) => ANGLE.test(symbol))) return result;
    this.at = here;
    throw this.fail("read.shorthand", { name: short, function: functionName });
  }

  private piecesOf(raw: string): readonly Piece[] {
    const pieces = this.pieces.get(raw) ?? piecesOf(raw, this.known);
    this.pieces.set(raw, pieces);
    return pieces;
  }

  private first(raw: string): Node {
    return treeOfPiece(this.piecesOf(raw)[0] as Piece);
  }

  /** Return the product that joined names mean; a function applies to what follows it. */
  private productOf(pieces: readonly Piece[]): Node {
    const factors: Node[] = [];
    for (let i = 0; i < pieces.length; i += 1) {
      const piece = pieces[i] as Piece;
      const next = pieces[i + 1];
      const called = piece.parts[0] as string;
      if (piece.kind !== "function") factors.push(treeOfPiece(piece));
      else if (next && next.kind !== "function" && !ARITY.has(called)) {
        factors.push(applied(called, [treeOfPiece(next)]));
        i += 1;
        this.bareArgumentEnd = i + 1 >= pieces.length ? this.at : -1;
      } else if (!next) factors.push(this.function(called));
      else throw this.fail("read.no-argument", { name: called });
    }
    const product = factors.reduce((some, factor) => node("*", some, factor));
    if (factors.length > 1) this.joinedProduct = product;
    return product;
  }

  /** Parse Derivative(theta1(t), t), the rate qd1; or Lambda(_n, …), in which _n is any whole number. */
  private bound(kind: string, of: Node | null): Node {
    this.at += 1;
    const args = [...(of ? [of] : []), ...this.args(")")];
    const [first, second] = args;
    const isRate = BOUND.get(kind) === "rate";
    if (isRate && first?.kind === "name" && args.length <= 2) {
      const joint = JOINT.exec(first.text);
      if (joint) return name(`qd${joint[1]}`);
    }
    if (!isRate && first?.kind === "name" && second && args.length === 2) {
      return replaceName(second, first.text, name(VOCABULARY.whole_numbers[0] as string));
    }
    throw this.fail("read.bound", { name: kind });
  }

  private function(called: string): Node {
    return this.deeper(() => this.functionOf(called), "read.functions");
  }

  private functionOf(called: string): Node {
    const power = this.take("^", "**") ? this.signed(this.primary) : null; // sin^2(x)
    const opened = this.peek();
    const args = this.take("(") ? this.args(")") : this.take("[") ? this.args("]") : [this.bareArgument(called)];
    this.bracesAreLists ||= opened === "[";
    const expectedCount = ARITY.get(called) ?? 1;
    if (args.length !== expectedCount)
      throw this.fail("read.arguments", { name: called, due: expectedCount, count: args.length });
    const inverted = power?.kind === "neg" && power.args[0]?.kind === "number" && power.args[0].value === 1;
    const inverse = inverted ? INVERSES.get(called) : undefined;
    if (inverse !== undefined) return applied(inverse, args); // sin^-1(x) is the arc sine
    const made = applied(called, args);
    return power ? node("^", made, power) : made;
  }

  /** Parse the argument of a function without brackets: a number, a name, or both, as in sin 2 theta1. */
  private bareArgument(called: string): Node {
    const factors: Node[] = [];
    if (this.here().kind === "number") {
      factors.push(numberOf(this.peek()));
      this.at += 1;
    }
    if (this.here().kind === "name" && !WORDS.has(this.peek())) {
      const more = this.piecesOf(this.peek()).slice(1); // sin theta1cos(theta2)
      if (more.some(({ kind }) => kind !== "name")) throw this.fail("read.bare", { name: called });
      this.at += 1;
      factors.push(this.named(this.textAt(-1)));
    }
    if (factors.length === 0 || ["/", "^", "**"].includes(this.peek())) throw this.fail("read.bare", { name: called });
    this.bareArgumentEnd = this.at;
    return factors.reduce((product, factor) => node("*", product, factor));
  }

  private container(kind: string, args: readonly Node[]): Node {
    const [first, second, third] = args;
    const meaning = CONTAINERS.get(kind) as string;
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
      const filled = filledRows(first, second, third);
      if (filled) return filled;
    }
    if (meaning === "diagonal" && args.length <= LIMITS.matrix_rows) {
      return listOf(args.map((arg, i) => args.map((_, j) => (i === j ? arg : integer(0)))));
    }
    if (meaning === "list") return node("list", ...args);
    throw this.fail("read.container", { name: kind, count: args.length });
  }
}

const isConstant = (text: string): boolean =>
  VOCABULARY.before_whole_numbers.some((constant) => text.startsWith(constant));

const oneOrSet = (values: readonly Node[]): Node =>
  values.length === 1 ? (values[0] as Node) : node("set", ...values);

const isValue = (value: Node): boolean =>
  !["eq", "in", "and", "or"].includes(value.kind) &&
  [...namesIn(value)].every((symbol) => VOCABULARY.whole_numbers.includes(symbol));

/** Convert a value to metres and radians: a hundredth of cm, pi/180 of degrees. */
function inUnit(value: Node, unit: string): Node {
  const factor = UNITS.get(unit) as string;
  if (factor.startsWith("/")) return node("/", value, integer(Number(factor.slice(1))));
  return factor ? applied("radians", [value]) : value;
}

/** Return the transpose of a list of rows; a list of entries, which may be a column, stays unchanged. */
function transposeList(matrix: Node): Node {
  const rows = matrix.args.map(({ args }) => args);
  return isRectangle(matrix.args) && rows[0]?.length ? listOf(columnsOf(rows)) : matrix;
}

const isWholeNumbers = ({ text }: Node): boolean => VOCABULARY.whole_number_sets.includes(text);

/** Return the matrix of Matrix(rows, columns, [entries]); null if the number of entries differs. */
function filledRows(rows: Node, columns: Node, entries: Node): Node | null {
  const [r, c] = [rows.value, columns.value];
  const { args } = entries;
  if (r > 0 && r === args.length && args.every(({ kind, args }) => kind === "list" && args.length === c))
    return entries; // as in Maple
  const isWhole = rows.kind === "number" && columns.kind === "number";
  return isWhole && r * c > 0 && r * c === args.length ? listOf(inRows(args, c)) : null;
}

/** Return the tree of a piece of a name. */
function treeOfPiece(piece: Piece): Node {
  if (piece.kind === "name") return name(piece.parts[0] as string);
  const angle = piece.parts.map(name).reduce((total, part) => node("+", total, part));
  return piece.kind === "sum" ? angle : call(piece.kind, angle);
}

/** Return a function applied to arguments; "radians" converts from degrees. */
function applied(functionName: string, args: readonly Node[]): Node {
  if (functionName === "radians") return node("/", node("*", args[0] as Node, name("pi")), integer(180));
  return call(functionName, ...args);
}

const DIGITS = /^[0-9]+$/;

function numberOf(text: string): Node {
  if (text.length < 16 && DIGITS.test(text)) return integer(Number(text), text);
  const [mantissa = "", exponent = ""] = text.toLowerCase().split("e");
  const isLong = mantissa.length > LIMITS.mantissa || exponent.length > LIMITS.exponent_characters;
  if (isLong || Math.abs(Number(exponent)) > LIMITS.exponent) {
    throw new ParseError("read.range", { number: text.slice(0, 20) });
  }
  const decimal = mantissa.includes(".") || exponent !== "";
  const digits = mantissa.replace(".", "").replace(/^0+/, "").replace(/0+$/, "").length;
  return { kind: decimal ? "decimal" : "number", args: [], text, value: Number(text), digits: decimal ? digits : 0 };
}
