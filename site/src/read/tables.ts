// Convert vectors and matrices without commas: entries in lines or columns, Matlab's [a b; c d], 0,5; 1,25. The rules
// of ../../../exercises/formula/tables.py, for texts that otherwise do not have the expected shape.

import { convertUnits } from "./notation.js";
import { pattern, strip, UNITS, wholePattern } from "./vocabulary.js";

/** The borders of a typeset matrix or table, at both ends of a line, as in "| a | b |" and "⎡a  b⎤". */
const BORDER = pattern("frame_of_table", "g");
/** The line below a table's head, as in "|---|---|". */
const MARKDOWN_RULE = pattern("rule_of_markdown");
/** The bar between two cells, as in "a | b". */
const MARKDOWN_BAR = pattern("bar_of_markdown");
/** The equals sign before a formula in a cell of a spreadsheet, as in "=a1". */
const SPREADSHEET_SIGN = pattern("sign_of_spreadsheet", "g");
/** A tab, or at least two blanks, as in "a  b". */
const TABLE_GAP = pattern("gap_of_table");
/** The blanks between two entries, as in "a -b", but not those around an operator, as in "a - b". */
const MATLAB_GAP = pattern("gap_of_matlab");
/** The beginning of a line that continues the formula of the line before, as in "+ a2". */
const CONTINUATION = pattern("line_goes_on");
/** Rows in brackets, as in "[a b; c d]" (group 1), or rows without brackets, as in "a b; c d" (group 2). */
const MATLAB_ROWS = wholePattern("rows_of_matlab");
/** The name before a table, as in "J = [". */
const NAME_OF_TABLE = pattern("name_of_table");
/** A comma with a blank beside it, as in "a, b". */
const LIST_COMMA = pattern("comma_of_list");
/** A comma between digits, as in "0,5". */
const DECIMAL_COMMA = pattern("comma_of_number", "g");
/** What separates numbers other than by a comma alone, as in "0,5; 1", "0,5 and 1", "0,5, 1" and "1 x 2". */
const BETWEEN_NUMBERS = pattern("between_numbers");
/** A number with a decimal comma or point, as in "-0,5". */
const NUMBER = wholePattern("decimal_with_comma");
/** A number after its name, as in "x = 0,5"; groups: the name, and the number. */
const NAMED_NUMBER = pattern("named_number", "y");
/** The texts to which units after a number are converted, such as "*pi/180" for deg; "" for SI units and none. */
const UNIT_CONVERSIONS = ["", ...new Set(UNITS.values())];
/** Maximum number of characters of a table. */
const MAX_CHARACTERS = 4000;

/** The texts of a table's cells, in rows. */
type Cells = readonly (readonly string[])[];
/** Splits a row into the texts of its entries. */
type Split = (row: string) => readonly string[];

const keepWhole: Split = (row) => [row];
const splitAtBars: Split = (row) => row.split(MARKDOWN_BAR);
const splitAtTableGaps: Split = (row) => row.split(TABLE_GAP);
const splitAtCommas: Split = (row) => row.split(",");
const MATLAB_SPLITS: readonly Split[] = [(row) => row.split(MATLAB_GAP), splitAtCommas, (row) => row.split(LIST_COMMA)];

/** Return a table as the text of a list of rows; null if it has another shape, or is ambiguous. */
export function convertTable(text: string, rowCount: number, columnCount: number): string | null {
  if ([...text].length > MAX_CHARACTERS) return null;
  const isTable = (cells: Cells): boolean =>
    cells.length === rowCount && cells.every((row) => row.length === columnCount && row.every(isSingleEntry));
  const tables = splitIntoTables(text.replace(NAME_OF_TABLE, ""), rowCount, columnCount).filter(isTable);
  const listTexts = [...new Set(tables.map(writeList))];
  // With a decimal comma, 1,2 x is 1.2 and x, or 1 and 2 x. Without one, the first way to split is the likeliest.
  const isAmbiguous = listTexts.length > 1 && text.match(DECIMAL_COMMA) !== null;
  return isAmbiguous ? null : (listTexts[0] ?? null);
}

/** Return the ways to split a text into cells: by lines, by Matlab's semicolons, and by each separator of entries. */
function splitIntoTables(text: string, rowCount: number, columnCount: number): Cells[] {
  const tables: Cells[] = [];
  const typedLines = text.split("\n");
  const isMarkdown = typedLines.some((line) => MARKDOWN_RULE.test(line));
  const contentLines = typedLines
    .filter((line) => !MARKDOWN_RULE.test(line))
    .map((line) => line.replace(BORDER, ""))
    .filter((line) => strip(line.replaceAll("|", "")) !== "");
  const isSpreadsheet = contentLines.every((line) => line.search(SPREADSHEET_SIGN) === 0);
  const lines = isSpreadsheet ? contentLines.map((line) => line.replace(SPREADSHEET_SIGN, "$1")) : contentLines;
  if (rowCount > 1 && !lines.slice(1).some((line) => CONTINUATION.test(line)))
    for (const split of chooseLineSplits(columnCount, isMarkdown))
      tables.push(lines.map((line) => splitEntries(line, split)));
  const matlabMatch = MATLAB_ROWS.exec(strip(text));
  if (!matlabMatch) return tables;
  const [, rowsInBrackets, bareRows = ""] = matlabMatch;
  for (const rowSeparator of [/;/, /[;\n]/]) {
    const rows = (rowsInBrackets ?? bareRows).split(rowSeparator).filter((row) => strip(row) !== "");
    for (const split of columnCount === 1 ? [keepWhole, ...MATLAB_SPLITS] : MATLAB_SPLITS) {
      const cells = rows.map((row) => splitEntries(row, split));
      // A single row is accepted as a column. If it has commas, [a,b] is a list already, which the parser accepts.
      const isColumnInRow = columnCount === 1 && cells.length === 1 && split !== splitAtCommas;
      tables.push(isColumnInRow ? (cells[0] as readonly string[]).map((cell) => [cell]) : cells);
    }
  }
  return tables;
}

/** Return the ways to split the lines of a table into entries. */
function chooseLineSplits(columnCount: number, isMarkdown: boolean): readonly Split[] {
  if (columnCount === 1) return [keepWhole];
  return isMarkdown ? [splitAtBars] : [splitAtTableGaps, ...MATLAB_SPLITS];
}

/** Return the entries of a row, with decimal points; a comma after the last entry is ignored. */
function splitEntries(row: string, split: Split): readonly string[] {
  return split(strip(strip(row).replace(/,$/, ""))).map((cell) => cell.replace(DECIMAL_COMMA, "."));
}

const NO_SYMBOLS: ReadonlySet<string> = new Set();

/**
 * Return numbers as the text of a list. Null for other texts, unless they are a table of one column, and for numbers
 * separated by commas alone, which may be decimal commas: "0,5; 1,25" gives "[0.5, 1.25]", but "0,5,1,25" null.
 */
export function convertNumbers(text: string, count: number): string | null {
  if (count < 2 || [...text].length > MAX_CHARACTERS) return null;
  let content = strip(convertUnits(text, NO_SYMBOLS));
  const brackets = content.slice(0, 1) + content.slice(-1);
  if (brackets === "()" || brackets === "[]" || (brackets === "{}" && content.includes(";")))
    content = content.slice(1, -1);
  const assignments = findNamedNumbers(content);
  if (assignments.length > 0) return assignments.length === count ? `[${assignments.join(", ")}]` : null;
  const entries = content.split(BETWEEN_NUMBERS).map(strip);
  if (entries.length === count && entries.every(isNumber))
    return `[${entries.map((entry) => entry.replace(",", ".")).join(", ")}]`;
  return convertTable(text, count, 1);
}

/** Return named numbers, as in x = 0,5 and y = 1, with decimal points; an empty list if there is any other text. */
function findNamedNumbers(text: string): readonly string[] {
  const assignments: string[] = [];
  for (NAMED_NUMBER.lastIndex = 0; NAMED_NUMBER.lastIndex < text.length;) {
    const match = NAMED_NUMBER.exec(text);
    if (!match) return [];
    const [, name = "", number = ""] = match;
    assignments.push(`${name} = ${number.replace(",", ".")}`);
  }
  return assignments;
}

/** Return whether an entry is a number, perhaps with a converted unit behind it, as in "30*pi/180". */
function isNumber(entry: string): boolean {
  return UNIT_CONVERSIONS.some(
    (conversion) => entry.endsWith(conversion) && NUMBER.test(entry.slice(0, entry.length - conversion.length)),
  );
}

/** Return the text of a list of rows, or of a list of entries if there is one column. */
function writeList(cells: Cells): string {
  const rowTexts = cells.map((row) => row.map(strip).join(", "));
  const isColumn = cells[0]?.length === 1;
  return `[${(isColumn ? rowTexts : rowTexts.map((rowText) => `[${rowText}]`)).join(", ")}]`;
}

/** A sign that separates entries; or two decimal points, with at most 18 digits as in the vocabulary's numbers. */
const BETWEEN_ENTRIES = /[,;=]|\.[0-9]{1,18}\./;

/** Return whether an entry has balanced brackets, and no comma, semicolon, equals sign or two decimal points. */
function isSingleEntry(cell: string): boolean {
  const count = (sign: string): number => cell.split(sign).length - 1;
  const hasBalancedBrackets = ["()", "[]", "{}"].every(([open = "", close = ""]) => count(open) === count(close));
  return strip(cell) !== "" && !BETWEEN_ENTRIES.test(cell) && hasBalancedBrackets;
}
