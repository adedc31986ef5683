// Convert vectors and matrices without commas: entries in lines or columns, Matlab's [a b; c d], 0,5; 1,25. The rules
// of ../../../exercises/formula/tables.py, for texts that otherwise do not have the expected shape.

import { withoutUnits } from "./notation.js";
import { compile, pattern, strip, UNITS, VOCABULARY, wholePattern } from "./vocabulary.js";

const FRAME_OF_TABLE = pattern("frame_of_table", "g");
const MARKDOWN_RULE = pattern("rule_of_markdown");
const MARKDOWN_BAR = pattern("bar_of_markdown");
/** The equals sign before a formula in a cell of a spreadsheet. */
const SPREADSHEET_SIGN = pattern("sign_of_spreadsheet", "g");
const TABLE_GAP = pattern("gap_of_table");
const MATLAB_GAP = pattern("gap_of_matlab");
const CONTINUATION = compile(VOCABULARY.patterns.line_goes_on);
const MATLAB_ROWS = wholePattern("rows_of_matlab");
const NAME_OF_TABLE = pattern("name_of_table");
/** A comma between entries, which has a space beside it; and a comma between the digits of a number. */
const LIST_COMMA = pattern("comma_of_list");
const DECIMAL_COMMA = pattern("comma_of_number", "g");
const BETWEEN_NUMBERS = pattern("between_numbers");
const NUMBER = wholePattern("decimal_with_comma");
const NAMED_NUMBER = pattern("named_number", "y");
const UNIT_FACTORS = ["", ...new Set(UNITS.values())];
/** Maximum number of characters of a table. */
const MAX_CHARACTERS = 4000;

/** The texts of a table's cells, in rows. */
type Cells = readonly (readonly string[])[];
type Split = (line: string) => readonly string[];

/** Return a table as the text of a list of rows; null if it has another shape, or is ambiguous. */
export function tableText(text: string, rows: number, columns: number): string | null {
  if ([...text].length > MAX_CHARACTERS) return null;
  const isTable = (cells: Cells): boolean =>
    cells.length === rows && cells.every((row) => row.length === columns && row.every(isSingleEntry));
  const texts = new Set(readingsOf(text.replace(NAME_OF_TABLE, ""), rows, columns).filter(isTable).map(listText));
  const isUnambiguous = texts.size === 1 || !text.match(DECIMAL_COMMA); // 1,2 x is 1.2 and x, or 1 and 2 x
  return isUnambiguous ? ([...texts][0] ?? null) : null;
}

/** Return the ways to read a text as a table: by lines, by Matlab's semicolons, and by each separator of entries. */
function readingsOf(text: string, rows: number, columns: number): Cells[] {
  const tables: Cells[] = [];
  const typedLines = text.split("\n");
  const isMarkdown = typedLines.some((line) => MARKDOWN_RULE.test(line));
  const contentLines = typedLines
    .filter((line) => !MARKDOWN_RULE.test(line))
    .map((line) => line.replace(FRAME_OF_TABLE, ""))
    .filter((line) => strip(line.replaceAll("|", "")) !== "");
  const isSpreadsheet = contentLines.every((line) => line.search(SPREADSHEET_SIGN) === 0);
  const lines = isSpreadsheet ? contentLines.map((line) => line.replace(SPREADSHEET_SIGN, "$1")) : contentLines;
  if (rows > 1 && !lines.slice(1).some((line) => CONTINUATION.test(line)))
    for (const split of columns === 1 ? [keepLine] : isMarkdown ? [splitAtBars] : [splitAtGaps, ...SPLITS])
      tables.push(lines.map((line) => entriesOf(line, split)));
  const matlab = MATLAB_ROWS.exec(strip(text));
  if (!matlab) return tables;
  const inner = (matlab[1] ?? matlab[2]) as string;
  for (const separator of [/;/, /[;\n]/]) {
    const filled = inner.split(separator).filter((row) => strip(row) !== "");
    for (const split of columns === 1 ? [keepLine, ...SPLITS] : SPLITS) {
      const cells = filled.map((row) => entriesOf(row, split));
      // one row stands for an expected column; with commas but no blanks it is a list already
      const isRow = columns === 1 && cells.length === 1 && split !== splitAtCommas;
      tables.push(isRow ? (cells[0] as readonly string[]).map((cell) => [cell]) : cells);
    }
  }
  return tables;
}

const keepLine: Split = (line) => [line];
const splitAtBars: Split = (line) => line.split(MARKDOWN_BAR);
const splitAtGaps: Split = (line) => line.split(TABLE_GAP);
const splitAtCommas: Split = (line) => line.split(",");
const SPLITS: readonly Split[] = [(line) => line.split(MATLAB_GAP), splitAtCommas, (line) => line.split(LIST_COMMA)];

/** Return the entries of a row, with decimal points; a comma after the last entry is ignored. */
function entriesOf(line: string, split: Split): readonly string[] {
  return split(strip(strip(line).replace(/,$/, ""))).map((cell) => cell.replace(DECIMAL_COMMA, "."));
}

/** Return numbers that are not separated by commas as the text of a list; null if there are others. */
export function numbersText(text: string, count: number): string | null {
  if (count < 2 || [...text].length > MAX_CHARACTERS) return null;
  let inner = strip(withoutUnits(text, new Set()));
  const brackets = inner.slice(0, 1) + inner.slice(-1);
  if (brackets === "()" || brackets === "[]" || (brackets === "{}" && inner.includes(";"))) inner = inner.slice(1, -1);
  const named = namedNumbers(inner);
  if (named.length > 0) return named.length === count ? `[${named.join(", ")}]` : null;
  const entries = inner.split(BETWEEN_NUMBERS).map(strip);
  if (entries.length === count && entries.every(isNumber))
    return `[${entries.map((entry) => entry.replace(",", ".")).join(", ")}]`;
  return tableText(text, count, 1);
}

/** Return named numbers, as in x = 0,5 and y = 1; an empty list if there is any other text. */
function namedNumbers(text: string): readonly string[] {
  const numbers: string[] = [];
  for (NAMED_NUMBER.lastIndex = 0; NAMED_NUMBER.lastIndex < text.length;) {
    const match = NAMED_NUMBER.exec(text);
    if (!match) return [];
    numbers.push(`${match[1]} = ${match[2]?.replace(",", ".")}`);
  }
  return numbers;
}

/** Return whether an entry is a number, possibly times the factor of its unit. */
function isNumber(entry: string): boolean {
  return UNIT_FACTORS.some(
    (factor) => entry.endsWith(factor) && NUMBER.test(entry.slice(0, entry.length - factor.length)),
  );
}

/** Return a table as the text of a list. */
function listText(cells: Cells): string {
  const rows = cells.map((row) => row.map(strip).join(", "));
  return `[${(cells[0]?.length === 1 ? rows : rows.map((row) => `[${row}]`)).join(", ")}]`;
}

/** Return whether an entry has balanced brackets, and no comma, semicolon, equals sign or two decimal points. */
function isSingleEntry(cell: string): boolean {
  const count = (sign: string): number => cell.split(sign).length - 1;
  return (
    strip(cell) !== "" &&
    !/[,;=]|\.[0-9]{1,18}\./.test(cell) &&
    ["()", "[]", "{}"].every(([open, close]) => count(open as string) === count(close as string))
  );
}
