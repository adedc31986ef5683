// Find the answers in the text of a notebook, and what is wrong with it as a whole. The file is hostile: its values are
// checked before use, and all of its texts are shown as texts.

import { type Message, message } from "../text/text.js";
import { findBlanks, listAssignments, MAX_CELL_CHARACTERS, parseText } from "./python.js";
import { type Form, readAnswer, type Reading } from "./reading.js";

/** What a notebook has as the answer to a part. */
export interface FoundAnswer {
  /** The part's variable, such as p1_jacobian. */
  readonly variable: string;
  /** The heading above the answer's cell, "" if it is gone. */
  readonly title: string;
  /** The text in quotes, or the code, that is assigned to the variable. */
  readonly typed: string;
  readonly reading: Reading | { readonly kind: "code" | "missing" };
  readonly form: Form | null;
  readonly notes: readonly Message[];
}

export interface CheckedProblem {
  readonly slot: string;
  /** The heading of the problem, "" if it is gone. */
  readonly title: string;
  readonly answers: readonly FoundAnswer[];
}

/** The answers in a notebook, or the only reason why there are none; `notes` are about the whole notebook. */
export interface CheckedNotebook {
  readonly problems: readonly CheckedProblem[];
  readonly notes: readonly Message[];
}

/** The assignment and the student in the notebook's link to this page, "" if unknown. */
export interface Origin {
  readonly assignment: string;
  readonly student: string;
}

/** Return the origin in a fragment such as #velocity/501, which a browser sends to no server. */
export function parseOrigin(fragment: string): Origin {
  const [assignment = "", student = ""] = fragment
    .replace(/^#/, "")
    .split("/")
    .map((text) => {
      try {
        return decodeURIComponent(text);
      } catch {
        return "";
      }
    });
  return { assignment, student };
}

/** Return the answers in the text of a file with this name. */
export function checkNotebook(fileName: string, fileText: string, origin: Origin): CheckedNotebook {
  const shownName = shorten(fileName, MAX_NAME_LENGTH);
  const refuse = (note: Message): CheckedNotebook => ({ problems: [], notes: [note] });
  const content = parseJson(fileText);
  if (content === null) return refuse(message("check.no-notebook", { name: shownName }));
  const cells = listCells(content["cells"]);
  if (!cells) return refuse(message("check.no-cells", { name: shownName }));
  if (cells.length > MAX_CELLS) return refuse(message("check.many-cells", { name: shownName, limit: MAX_CELLS }));
  const metadata = asRecord(asRecord(content["metadata"])["qdot"]);
  if (metadata["kind"] === "solution") return refuse(message("check.solution", { name: shownName }));
  const forms = listForms(metadata);
  const parts = listParts(cells, forms);
  if (parts.length === 0) return refuse(message("check.no-answers", { name: shownName }));
  let remaining = MAX_PARSED_CHARACTERS;
  const assignmentsByCell = cells.map(({ isCode, source }) => {
    if (!isCode) return [];
    const assignments = listAssignments(source, Math.min(remaining, MAX_CELL_CHARACTERS));
    remaining -= source.length;
    return assignments;
  });
  const statements = cells.flatMap((cell, i) =>
    assignmentsByCell[i]!.map((assignment) => ({ ...assignment, cell, i })),
  );
  const answers = parts.map((part) => findAnswer(part, forms.get(part) ?? null, cells, statements));
  const slots = [...new Set(parts.map(slotOf))];
  const problems = slots.map((slot) => ({
    slot,
    title: findTitle(cells, `${slot}-statement`),
    answers: answers.filter((_, i) => slotOf(parts[i]!) === slot),
  }));
  const foreignCells = cells.flatMap(({ part }, i) =>
    part !== null && forms.size > 0 && !forms.has(part) ? [i + 1] : [],
  );
  const notes = [
    ...compareNames(fileName, metadata, origin),
    ...(forms.size === 0 ? [message("check.no-metadata")] : []),
    ...(foreignCells.length > 0 ? [message("check.foreign-cells", { cells: listNumbers(foreignCells) })] : []),
  ];
  return { problems, notes };
}

/** As in ../../../grader/submissions/cells.py. */
const MAX_CELLS = 25_000;
const MAX_NAME_LENGTH = 80;
/** The code of all cells together that is searched for texts, so that a hostile file doesn't block the page for long. */
const MAX_PARSED_CHARACTERS = 500_000;
const MAX_PARTS = 500;
const MAX_SYMBOLS = 100;
/** Rows and columns are fewer. */
const SIZE_BOUND = 100;

interface Cell {
  readonly id: string;
  readonly source: string;
  /** The part named in the cell's metadata, such as "p1.jacobian". */
  readonly part: string | null;
  readonly isCode: boolean;
  /** The error in the cell's output, "" for none. */
  readonly error: string;
}

type Json = Readonly<Record<string, unknown>>;
type Statement = ReturnType<typeof listAssignments>[number] & { readonly cell: Cell; readonly i: number };

function parseJson(text: string): Json | null {
  try {
    const content: unknown = JSON.parse(text);
    return typeof content === "object" && content !== null && !Array.isArray(content) ? (content as Json) : null;
  } catch {
    return null; // no JSON, or nested too deeply
  }
}

const asRecord = (value: unknown): Json =>
  typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Json) : {};
const asText = (value: unknown): string => (typeof value === "string" ? value : "");
const asTexts = (value: unknown): readonly string[] | null =>
  Array.isArray(value) && value.every((item) => typeof item === "string") ? value : null;
const getOwn = (record: Json, key: string): unknown => (Object.hasOwn(record, key) ? record[key] : undefined);

export function shorten(text: string, length: number): string {
  const signs = [...text.slice(0, 2 * length)];
  return signs.length > length ? `${signs.slice(0, length).join("")}…` : text;
}

const listNumbers = (numbers: readonly number[]): string =>
  numbers.slice(0, 10).join(", ") + (numbers.length > 10 ? ", …" : "");

function listCells(value: unknown): readonly Cell[] | null {
  if (!Array.isArray(value)) return null;
  return value.map((item): Cell => {
    const cell = asRecord(item);
    const { source } = cell;
    const part = asText(asRecord(asRecord(cell["metadata"])["qdot"])["part"]);
    return {
      id: asText(cell["id"]),
      source: (asTexts(source)?.join("") ?? asText(source)).replace(/\r\n?/g, "\n"),
      part: PART.test(part) ? part : null,
      isCode: cell["cell_type"] === "code",
      error: findError(cell["outputs"]),
    };
  });
}

function findError(outputs: unknown): string {
  const error = (Array.isArray(outputs) ? outputs : [])
    .map(asRecord)
    .find((output) => output["output_type"] === "error");
  return error ? shorten(`${asText(error["ename"])}: ${asText(error["evalue"])}`, 200) : "";
}

const PART = /^p\d{1,4}\.[a-z0-9-]{1,100}$/;
const slotOf = (part: string): string => part.split(".")[0]!;
const nameVariable = (part: string): string => part.replace(/[.-]/g, "_");

/** Return the forms of the answers by part, from the notebook's metadata; empty if they are gone. */
function listForms(metadata: Json): ReadonlyMap<string, Form | null> {
  const forms = new Map<string, Form | null>();
  for (const [slot, claim] of Object.entries(asRecord(metadata["answers"]))) {
    const [symbols, joints] = ["symbols", "joints"].map((key) => asTexts(getOwn(asRecord(metadata[key]), slot)));
    const names = symbols?.filter((name) => /^[A-Za-z]\w{0,20}$/.test(name)).slice(0, MAX_SYMBOLS);
    for (const [name, form] of Object.entries(asRecord(claim))) {
      const part = `${slot}.${name}`;
      if (PART.test(part) && forms.size < MAX_PARTS)
        forms.set(part, names?.length && joints ? parseForm(asRecord(form), names, joints) : null);
    }
  }
  return forms;
}

const MATRIX_TYPES = ["matrix", "direction", "number"];
const OPTION_TYPES = ["choice", "selection", "matching"];

/** Return a form in the metadata; null if it is invalid. */
function parseForm(claim: Json, symbols: readonly string[], joints: readonly string[]): Form | null {
  const type = asText(claim["type"]);
  const names = (key: string): readonly string[] | null => (claim[key] === undefined ? [] : asTexts(claim[key]));
  const [labels, columnNames, units, options, items] = ["labels", "columns", "units", "options", "items"].map(names);
  const shape: readonly unknown[] = Array.isArray(claim["shape"]) ? claim["shape"] : [];
  const isSize = (size: unknown): boolean =>
    Number.isInteger(size) && (size as number) > 0 && (size as number) < SIZE_BOUND;
  if (![...MATRIX_TYPES, ...OPTION_TYPES, "expression", "singular", "text"].includes(type)) return null;
  if (!labels || !columnNames || !units || !options || !items) return null;
  if (MATRIX_TYPES.includes(type) && !(shape.length === 2 && shape.every(isSize))) return null;
  const [rows, columns] = (MATRIX_TYPES.includes(type) ? shape : [1, 1]) as readonly [number, number];
  if (type === "number" && units.length !== rows * columns) return null;
  if (OPTION_TYPES.includes(type) && (options.length === 0 || options.length > 8)) return null;
  const metres = claim["metres"];
  return {
    ...{ type: type as Form["type"], symbols, joints, rows, columns, units, labels, columnNames, options, items },
    metres: typeof metres === "number" ? metres : null,
  };
}

/** Return the parts in the order of their cells, then those without a cell; without metadata, those that cells name. */
function listParts(cells: readonly Cell[], forms: ReadonlyMap<string, Form | null>): readonly string[] {
  const byOrder = (a: string, b: string): number => a.localeCompare(b, "en", { numeric: true });
  const named = cells.flatMap(
    ({ id, part }) => part ?? (id.endsWith("-question") ? id.replace("-question", "").replace("-", ".") : []),
  );
  const known = named.filter((part) => forms.has(part));
  const guessed = named.filter((part) => PART.test(part));
  const parts = forms.size > 0 ? [...known, ...[...forms.keys()].sort(byOrder)] : guessed;
  return [...new Set(parts)].slice(0, MAX_PARTS);
}

/** Return the heading in the cell with this id, or else in the last text above another cell, without Markdown. */
function findTitle(cells: readonly Cell[], id: string, cellBelow?: Cell): string {
  const textsAbove = cellBelow ? cells.slice(0, cells.indexOf(cellBelow)).filter(({ isCode }) => !isCode) : [];
  const [line = ""] = (cells.find((cell) => cell.id === id) ?? textsAbove.at(-1))?.source.split("\n", 1) ?? [];
  return shorten(line.replace(/^#+\s*/, "").replace(/\\(?=[^\w\s])|[$`]/g, ""), 120);
}

/** Return what the notebook has as the answer to a part: the last value that its cells give to the variable. */
function findAnswer(
  part: string,
  form: Form | null,
  cells: readonly Cell[],
  statements: readonly Statement[],
): FoundAnswer {
  const variable = nameVariable(part);
  const marked = cells.flatMap((cell, i) => (cell.part === part ? [{ cell, number: i + 1 }] : []));
  const setters = statements.filter(({ name }) => name === variable);
  const last = setters.at(-1);
  const notes: Message[] = [];
  const setterNumbers = [...new Set(setters.map(({ i }) => i + 1))];
  if (setterNumbers.length > 1)
    notes.push(
      message("check.several", { name: variable, cells: listNumbers(setterNumbers), last: setterNumbers.at(-1)! }),
    );
  else if (marked.length > 1)
    notes.push(
      message("check.copied", {
        name: variable,
        count: marked.length,
        cells: listNumbers(marked.map(({ number }) => number)),
      }),
    );
  const onlyCell = marked.at(-1)?.cell;
  const title = findTitle(cells, `${part.replace(".", "-")}-question`, onlyCell);
  const answer = { variable, title, form, notes };
  if (!last) {
    if (onlyCell && form?.type === "text")
      return { ...answer, typed: onlyCell.source, reading: readAnswer(onlyCell.source, form) };
    const key = !onlyCell ? "check.no-cell" : onlyCell.isCode ? "check.not-set" : "check.text-cell";
    notes.push(message(key, { name: variable, cell: marked.at(-1)?.number ?? 0 }));
    return { ...answer, typed: "", reading: { kind: "missing" } };
  }
  const text = last.code === null ? null : parseText(last.code);
  if (text !== null) {
    const [command = ""] = MISREAD_COMMAND.exec(last.code ?? "") ?? [];
    if (!text.includes(command)) notes.push(message("check.raw"));
    return { ...answer, typed: text, reading: readAnswer(text, form) };
  }
  const blanks = findBlanks(last.code ?? "");
  if (blanks === "all") return { ...answer, typed: "", reading: { kind: "blank" } };
  if (blanks === "some") notes.push(message("check.some-blank"));
  if (last.cell.error) notes.push(message("check.error", { error: last.cell.error }));
  return { ...answer, typed: last.code ?? "", reading: { kind: "code" } };
}

/** A LaTeX command that begins with an escape sequence of Python: \\t of \\theta is a tab. */
const MISREAD_COMMAND = /\\(?:theta|tau|tan|text|times|frac|beta|begin|right|alpha)/;

/** Return notes if the notebook belongs to a different assignment or student from the link, or the file was renamed. */
function compareNames(fileName: string, metadata: Json, origin: Origin): readonly Message[] {
  const [assignment, student] = ["assignment", "student"].map((key) => shorten(asText(metadata[key]), MAX_NAME_LENGTH));
  const notes: Message[] = [];
  if (origin.assignment && assignment && origin.assignment !== assignment)
    notes.push(
      message("check.other-assignment", { found: assignment, expected: shorten(origin.assignment, MAX_NAME_LENGTH) }),
    );
  else if (origin.student && student && origin.student !== student)
    notes.push(message("check.other-student", { found: student, expected: shorten(origin.student, MAX_NAME_LENGTH) }));
  if (assignment && fileName !== `${assignment}.ipynb`)
    notes.push(message("check.renamed", { name: shorten(fileName, MAX_NAME_LENGTH), expected: `${assignment}.ipynb` }));
  return notes;
}
