// Find what the cells of a notebook assign to names, and the texts in quotes among it. No code is run.

/** What a statement assigns to a name. */
export interface Assignment {
  readonly name: string;
  /** The assigned code; null unless the statement is a plain assignment outside loops. */
  readonly code: string | null;
}

/** The grader, too, only runs a longer cell (MAX_CELL_CHARACTERS of ../../../grader/submissions/answer_locator.py). */
export const MAX_CELL_CHARACTERS = 30_000;
/** A statement such as a = b = 1 sets at most this many names. */
const MAX_TARGETS = 10;

/** A text in quotes, with its prefix; its end is missing if a quote is. */
const LITERAL = String.raw`[A-Za-z]{0,2}(?:"""(?:[^"\\]|\\[^]?|"(?!""))*(?:"""|$)|'''(?:[^'\\]|\\[^]?|'(?!''))*(?:'''|$)|"(?:[^"\\\n]|\\[^]?)*"?|'(?:[^'\\\n]|\\[^]?)*'?)`;
/** A text in quotes, a name, a comment, the end of a line or statement, a bracket, or any other sign. */
const TOKEN = new RegExp(String.raw`${LITERAL}|[\p{L}\p{N}_]+|#[^\n]*|\\\n|;[ \t]*|[^]`, "gu");
const ASSIGNMENT = /^([\p{L}_][\p{L}\p{N}_]*)\s*(?::[^=]*)?=(?!=)/u;
/** Names before an assignment of another kind, as in "    a = 1", "a += 1" and "a, b = 1, 2". */
const OTHER_TARGETS = /^[\s\p{L}\p{N}_,()[\]:]*?(?:\*\*|\/\/|<<|>>|[-+*/%@&|^])?=(?!=)/u;

/** Return the assignments of a cell in their order. If it is longer than the limit, their code is unknown. */
export function listAssignments(source: string, limit = MAX_CELL_CHARACTERS): readonly Assignment[] {
  if (source.length <= limit) return splitIntoStatements(source).flatMap(listTargets);
  const lines = source.matchAll(/^[ \t]*(\w+)\b[^\n=!<>]*=(?!=)/gm);
  return Array.from(lines, ([, name = ""]) => ({ name, code: null }));
}

/** Return the statements of a cell without comments; those of indented lines begin with a space. */
function splitIntoStatements(source: string): readonly string[] {
  const statements = [""];
  let depth = 0;
  for (const token of source.match(TOKEN) ?? []) {
    const current = statements.at(-1)!;
    if ("([{".includes(token)) depth += 1;
    else if (")]}".includes(token)) depth = Math.max(0, depth - 1);
    if (depth === 0 && token === "\n") statements.push("");
    else if (depth === 0 && token[0] === ";") statements.push(/^\s/.test(current) ? " " : "");
    else if (token[0] !== "#") statements[statements.length - 1] = current + (token === "\\\n" ? " " : token);
  }
  return statements;
}

/** Return what a statement assigns: a value to each of the names in a = b = value. */
function listTargets(statement: string): readonly Assignment[] {
  const names: string[] = [];
  let code = statement;
  for (let match = ASSIGNMENT.exec(code); match && names.length < MAX_TARGETS; match = ASSIGNMENT.exec(code)) {
    names.push(match[1]!);
    code = code.slice(match[0].length).trim();
  }
  if (names.length > 0) return names.map((name) => ({ name, code }));
  const targets = OTHER_TARGETS.exec(statement);
  return targets ? findNames(targets[0]).map((name) => ({ name, code: null })) : [];
}

const findNames = (code: string): readonly string[] => code.match(/[\p{L}_][\p{L}\p{N}_]*/gu) ?? [];

/** Return the text of code that is only text in quotes, such as "a" 'b' or (r"a"); null for other code. */
export function parseText(code: string): string | null {
  const inner = /^\(([^]*)\)$/.exec(code)?.[1] ?? code;
  const texts = (inner.match(TOKEN) ?? []).filter((token) => token.trim() !== "").map(decodeLiteral);
  return texts.length > 0 && !texts.includes(null) ? texts.join("") : null;
}

/** Return the text of a literal; null for other code, and for text that is not plain or not complete, such as f"{a}". */
function decodeLiteral(literal: string): string | null {
  const [, prefix = "", quote, rest = ""] = /^([rRuU]?)("""|'''|"|')([^]*)$/.exec(literal) ?? [];
  if (quote === undefined || !rest.endsWith(quote)) return null;
  const body = rest.slice(0, -quote.length);
  return prefix.toLowerCase() === "r" ? body : decodeEscapes(body);
}

const ESCAPE = /\\(?:([0-7]{1,3})|x([\da-fA-F]{2})|u([\da-fA-F]{4})|U(00[01][\da-fA-F]{5})|([^]))/g;
const SIGNS: Readonly<Record<string, string>> = {
  ...{ a: "\x07", b: "\b", f: "\f", n: "\n", r: "\r", t: "\t", v: "\v", "\n": "", "\\": "\\", "'": "'", '"': '"' },
};

/** Return a text with the escapes of Python, such as \t, replaced by their signs; null if one is invalid. */
function decodeEscapes(body: string): string | null {
  let isValid = true;
  const text = body.replace(ESCAPE, (all, octal?: string, hex2?: string, hex4?: string, hex8?: string, sign = "") => {
    if (octal !== undefined) return String.fromCodePoint(parseInt(octal, 8));
    const digits = hex2 ?? hex4 ?? hex8;
    if (digits !== undefined && parseInt(digits, 16) <= 0x10ffff) return String.fromCodePoint(parseInt(digits, 16));
    isValid &&= digits === undefined && !"xuUN".includes(sign);
    return SIGNS[sign] ?? all; // as in "\sin", which Python leaves as it is
  });
  return isValid ? text : null;
}

const LITERALS = new RegExp(LITERAL, "gu");
const ONLY_BLANKS = /^(?:[\s()[\],]|Matrix|blank|None|Ellipsis|\.{3})*$/;

/** Return whether all of an answer's code is the placeholder "blank", some of it, or none. */
export function findBlanks(code: string): "all" | "some" | "none" {
  const plainCode = code.replace(LITERALS, '""');
  if (ONLY_BLANKS.test(plainCode) && /[beE.N]/.test(plainCode.replaceAll("Matrix", ""))) return "all";
  return /\bblank\b/.test(plainCode) ? "some" : "none";
}
