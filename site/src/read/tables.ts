// Vectors and matrices without commas: entries in lines, in columns with tabs or gaps, Matlab's [a b; c d], 0,5; 1,25.
// The rules of ../../../exercises/formula/tables.py, for texts that are not of the expected shape otherwise.

import { withoutUnits } from "./notation.js";
import { compiled, pattern, stripped, VOCABULARY, whole } from "./vocabulary.js";

const FRAME = pattern("frame_of_table", "g");
const RULE = pattern("rule_of_markdown");
const BAR = pattern("bar_of_markdown");
/** What stands before a formula in a cell of a spreadsheet. */
const SIGN = pattern("sign_of_spreadsheet", "g");
const GAP = pattern("gap_of_table");
const BLANK = pattern("gap_of_matlab");
const GOES_ON = compiled(VOCABULARY.patterns.line_goes_on);
const MATLAB = whole("rows_of_matlab");
const NAME = pattern("name_of_table");
/** A comma between entries, by the blank beside it, and one in a number. */
const COMMA = pattern("comma_of_list");
const POINT = pattern("comma_of_number", "g");
const BETWEEN = pattern("between_numbers");
const NUMBER = whole("decimal_with_comma");
const NAMED = pattern("named_number", "y");
const FACTORS = ["", ...new Set(Object.values(VOCABULARY.units))];
/** Characters of a table that is read. */
const MOST = 4000;

type Cells = readonly (readonly string[])[];
type Split = (line: string) => readonly string[];

/** A table as the text of a list of rows; null for what is none of this shape, or of two ways to read one. */
export function tableText(text: string, rows: number, columns: number): string | null {
  if ([...text].length > MOST) return null;
  const isTable = (cells: Cells): boolean =>
    cells.length === rows && cells.every((row) => row.length === columns && row.every(isWhole));
  const found = new Set(tablesIn(text.replace(NAME, ""), rows, columns).filter(isTable).map(listed));
  const isClear = found.size === 1 || !text.match(POINT); // 1,2 x is 1.2 and x, or 1 and 2 x
  return isClear ? ([...found][0] ?? null) : null;
}

/** What a text is by its lines, and by Matlab's semicolons, with each of what separates entries of a row. */
function tablesIn(text: string, rows: number, columns: number): Cells[] {
  const found: Cells[] = [];
  const typed = text.split("\n");
  const isMarkdown = typed.some((line) => RULE.test(line));
  const framed = typed
    .filter((line) => !RULE.test(line))
    .map((line) => line.replace(FRAME, ""))
    .filter((line) => stripped(line.replaceAll("|", "")) !== "");
  const isSheet = framed.every((line) => line.search(SIGN) === 0);
  const lines = isSheet ? framed.map((line) => line.replace(SIGN, "$1")) : framed;
  if (rows > 1 && !lines.slice(1).some((line) => GOES_ON.test(line)))
    for (const split of columns === 1 ? [alone] : isMarkdown ? [byBar] : [byGap, ...SPLITS])
      found.push(lines.map((line) => entriesOf(line, split)));
  const matlab = MATLAB.exec(stripped(text));
  if (!matlab) return found;
  const inner = (matlab[1] ?? matlab[2]) as string;
  for (const between of [/;/, /[;\n]/]) {
    const filled = inner.split(between).filter((row) => stripped(row) !== "");
    for (const split of columns === 1 ? [alone, ...SPLITS] : SPLITS) {
      const cells = filled.map((row) => entriesOf(row, split));
      // a row for the column that is expected, which is a list already where its commas have no blanks
      const isRow = columns === 1 && cells.length === 1 && split !== byComma;
      found.push(isRow ? (cells[0] as readonly string[]).map((cell) => [cell]) : cells);
    }
  }
  return found;
}

const alone: Split = (line) => [line];
const byBar: Split = (line) => line.split(BAR);
const byGap: Split = (line) => line.split(GAP);
const byComma: Split = (line) => line.split(",");
const SPLITS: readonly Split[] = [(line) => line.split(BLANK), byComma, (line) => line.split(COMMA)];

/** The entries of a row, 0,5 among them as a number; behind the last a comma may stand. */
function entriesOf(line: string, split: Split): readonly string[] {
  return split(stripped(stripped(line).replace(/,$/, ""))).map((cell) => cell.replace(POINT, "."));
}

/** Numbers that are separated by anything but commas as the text of a list; null for what is none. */
export function numbersText(text: string, count: number): string | null {
  if (count < 2 || [...text].length > MOST) return null;
  let inner = stripped(withoutUnits(text, new Set()));
  const ends = inner.slice(0, 1) + inner.slice(-1);
  if (ends === "()" || ends === "[]" || (ends === "{}" && inner.includes(";"))) inner = inner.slice(1, -1);
  const named = namedNumbers(inner);
  if (named.length > 0) return named.length === count ? `[${named.join(", ")}]` : null;
  const entries = inner.split(BETWEEN).map(stripped);
  if (entries.length === count && entries.every(isNumber))
    return `[${entries.map((entry) => entry.replace(",", ".")).join(", ")}]`;
  return tableText(text, count, 1);
}

/** Numbers that have names, as in x = 0,5 and y = 1, one by one; nothing where anything else is there. */
function namedNumbers(text: string): readonly string[] {
  const found: string[] = [];
  for (NAMED.lastIndex = 0; NAMED.lastIndex < text.length;) {
    const one = NAMED.exec(text);
    if (!one) return [];
    found.push(`${one[1]} = ${one[2]?.replace(",", ".")}`);
  }
  return found;
}

/** Whether a number stands there, alone or times what its unit is worth. */
function isNumber(entry: string): boolean {
  return FACTORS.some((factor) => entry.endsWith(factor) && NUMBER.test(entry.slice(0, entry.length - factor.length)));
}

function listed(cells: Cells): string {
  const rows = cells.map((row) => row.map(stripped).join(", "));
  return `[${(cells[0]?.length === 1 ? rows : rows.map((row) => `[${row}]`)).join(", ")}]`;
}

/** Whether an entry holds no comma, semicolon or two points of a number, and as many brackets closed as open. */
function isWhole(cell: string): boolean {
  const count = (sign: string): number => cell.split(sign).length - 1;
  return (
    stripped(cell) !== "" &&
    !/[,;=]|\.[0-9]{1,18}\./.test(cell) &&
    ["()", "[]", "{}"].every(([one, other]) => count(one as string) === count(other as string))
  );
}
