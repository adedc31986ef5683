// The page for students' notebooks: which answers it finds, and how it reads them (notebook.json is written by
// tests.tools.site_corpus).
import { describe, expect, test } from "vitest";

import { checkNotebook, type FoundAnswer, parseOrigin } from "../src/check/notebook.js";
import { listAssignments, parseText } from "../src/check/python.js";
import { readAnswer } from "../src/check/reading.js";
import { ENGLISH, textOf } from "../src/text/text.js";
import stored from "./notebook.json" with { type: "json" };

type Cell = { id: string; cell_type: string; source: string; metadata: object; outputs?: object[] };

const NAME = "velocity.ipynb";

/** Return the text of the notebook with these answers, and with other cells if `change` changes them. */
function write(answers: Readonly<Record<string, string>>, change = (cells: Cell[]): Cell[] => cells): string {
  const cells = stored.notebook.cells.map((cell) =>
    Object.hasOwn(answers, cell.id) ? { ...cell, source: answers[cell.id]! } : cell,
  );
  return JSON.stringify({ ...stored.notebook, cells: change(cells as Cell[]) });
}

function check(text: string, name = NAME, fragment = "") {
  const { problems, notes } = checkNotebook(name, text, parseOrigin(fragment));
  const answers = problems.flatMap((problem) => problem.answers);
  const find = (variable: string): FoundAnswer => answers.find((answer) => answer.variable === `p1_${variable}`)!;
  return {
    problems,
    answers,
    find,
    notes: notes.map(({ key }) => key),
    texts: notes.map((note) => textOf(note, ENGLISH)),
  };
}

const notesOf = ({ notes }: FoundAnswer): string[] => notes.map(({ key }) => key);

describe("a notebook", () => {
  test("has the parts in the order of their cells, with their headings, and nothing is answered", () => {
    const { problems, answers, notes } = check(write({}));
    expect(problems.map(({ title }) => title)).toEqual(["1 Planar 2R arm"]);
    expect(answers.map(({ title }) => title.replace(/ \(.*/, ""))).toEqual([
      "1.1 Position of the point",
      "1.2 Jacobian by differentiation",
      "1.3 Determinant of the Jacobian",
      "1.4 Velocity caused by one joint",
      "1.5 Joint rates at a configuration",
      "1.6 Singular configurations",
    ]);
    expect(answers.map(({ reading }) => reading.kind)).toEqual(answers.map(() => "blank"));
    expect(notes).toEqual([]);
  });

  test("with answers shows how each is read", () => {
    const { find } = check(
      write({
        "p1-position": 'p1_position = "a1*c1 + a2*c12"  # only x',
        "p1-jacobian": 'p1_jacobian = "[-a1*s1 - a2*s12, -a2*s12; a1*c1 + a2*c12, blank]"',
        "p1-determinant": "p1_determinant = r'a_1 a_2 \\sin\\theta_2 b'",
        "p1-joint-effect": "p1_joint_effect = 'b'",
        "p1-joint-rates": 'p1_joint_rates = ("0.5 rad/s, "\n    "-30 deg/s")',
        "p1-singular-angles": 'p1_singular_angles = """theta2 = 0\ntheta2 = pi"""',
      }),
    );
    expect(find("position").reading).toMatchObject({ kind: "refused", why: { key: "read.shape" } });
    expect(find("jacobian").reading).toMatchObject({ kind: "formula", isPartlyBlank: true });
    expect(find("determinant").reading).toMatchObject({ kind: "refused", why: { key: "read.unknown" } });
    expect(find("joint_effect").reading).toEqual({ kind: "letters", chosen: [1] });
    const latex =
      "\\begin{bmatrix} 0.5 \\, \\mathrm{rad/s} \\\\ -\\frac{30 \\, \\pi}{180} \\, \\mathrm{rad/s} \\end{bmatrix}";
    expect(find("joint_rates").reading).toEqual({ kind: "formula", latex, isPartlyBlank: false });
    expect(find("singular_angles").reading).toMatchObject({ kind: "formula" });
  });

  test("with code is not judged; the last value counts, and errors of the last run are shown", () => {
    const { find } = check(
      write(
        {
          "p1-position": 'p1_position = Matrix(["a", "b"])',
          "p1-jacobian": "p1_jacobian = p1_position.jacobian([theta1, theta2])",
          "p1-determinant": 'p1_determinant = "a1"\nif True:\n    p1_determinant = "a2"',
          "p1-joint-rates": "p1_joint_rates = Matrix([1, blank])",
          "p1-singular-angles": 'p1_singular_angles = f"theta2 = {0}"',
        },
        (cells) => [
          ...cells.map((cell) =>
            cell.id === "p1-jacobian"
              ? { ...cell, outputs: [{ output_type: "error", ename: "NameError", evalue: "<b>J</b>" }] }
              : cell,
          ),
          { id: "mine", cell_type: "code", source: "p1_position = '[a1, a2]'", metadata: {} },
        ],
      ),
    );
    expect(find("position").reading.kind).toBe("formula");
    expect(notesOf(find("position"))).toEqual(["check.several"]);
    expect(find("jacobian").notes.map((note) => textOf(note, ENGLISH))).toEqual([
      "When the cell was last run, Python reported an error: NameError: <b>J</b>",
    ]);
    for (const variable of ["jacobian", "determinant", "joint_rates", "singular_angles"])
      expect(find(variable).reading.kind).toBe("code");
    expect(notesOf(find("joint_rates"))).toEqual(["check.some-blank"]);
  });

  test("with deleted, copied, renamed, changed and foreign cells is reported", () => {
    const { find, notes } = check(
      write({ "p1-determinant": 'det = "a1"', "p1-joint-effect": 'p1_joint_effect = "A"' }, (cells) =>
        cells
          .filter(({ id }) => id !== "p1-position")
          .flatMap((cell) => (cell.id === "p1-joint-effect" ? [cell, { ...cell, id: "copy" }] : [cell]))
          .map((cell) => (cell.id === "p1-jacobian" ? { ...cell, cell_type: "markdown" } : cell))
          .concat({ id: "x", cell_type: "code", source: "p2_rank = 1", metadata: { qdot: { part: "p2.rank" } } }),
      ),
    );
    expect(notesOf(find("position"))).toEqual(["check.no-cell"]);
    expect(notesOf(find("jacobian"))).toEqual(["check.text-cell"]);
    expect(notesOf(find("determinant"))).toEqual(["check.not-set"]);
    expect(notesOf(find("joint_effect"))).toEqual(["check.several"]);
    expect(find("position").reading.kind).toBe("missing");
    expect(notes).toEqual(["check.foreign-cells"]);
  });

  test("of another student, assignment or name is reported", () => {
    const text = write({});
    expect(check(text, NAME, "#velocity/501").notes).toEqual([]);
    expect(check(text, NAME, "#velocity/502").notes).toEqual(["check.other-student"]);
    expect(check(text, NAME, "#week%204/501").texts[0]).toContain("you came from week 4");
    expect(check(text, "velocity (1).ipynb", "#%E0%A4%A").notes).toEqual(["check.renamed"]);
  });

  test("without metadata is read without forms", () => {
    const { cells } = JSON.parse(write({ "p1-position": 'p1_position = "[a1, a2, a3]"' })) as { cells: Cell[] };
    const { find, notes } = check(JSON.stringify({ cells, metadata: {} }));
    expect(find("position").reading.kind).toBe("formula");
    expect(notes).toEqual(["check.no-metadata"]);
  });
});

test("a command of LaTeX that Python misreads is reported", () => {
  const keysFor = (code: string) =>
    notesOf(check(write({ "p1-determinant": `p1_determinant = ${code}` })).find("determinant"));
  expect(keysFor('"a1 a2 \\sin \\theta_2"')).toEqual(["check.raw"]);
  expect(keysFor('r"a1 a2 \\sin \\theta_2"')).toEqual([]);
  expect(keysFor('"a1 a2 \\\\sin \\\\theta_2"')).toEqual([]);
});

describe("a file that is no student's notebook", () => {
  const solution = { ...stored.notebook, metadata: { qdot: { ...stored.notebook.metadata.qdot, kind: "solution" } } };
  test.each([
    ["", "check.no-notebook"],
    ["%PDF-1.7", "check.no-notebook"],
    ["[1]", "check.no-notebook"],
    [`{"cells": ${"[".repeat(1e6)}`, "check.no-notebook"],
    ['{"cells": {}}', "check.no-cells"],
    ['{"cells": [null, 1, {"source": 5, "metadata": []}]}', "check.no-answers"],
    [`{"cells": [${"1,".repeat(25_000)}1]}`, "check.many-cells"],
    [JSON.stringify(solution), "check.solution"],
  ])("%.20s is refused with a reason", (text, key) => {
    expect(check(text)).toMatchObject({ problems: [], notes: [key] });
  });

  test("can't disturb the page by its metadata", () => {
    const forms = {
      __proto__x: { type: "matrix", shape: [1e9, 1e9] },
      a: { type: "number", shape: [2, 1], units: ["$"] },
    };
    const qdot = {
      answers: { p1: forms, constructor: { a: 1 }, p2: null },
      symbols: { p1: ["theta1", "\\def"] },
      joints: { p1: [] },
    };
    const hostile = { metadata: { qdot }, cells: [{ cell_type: "code", source: "p1_a = '\\\\input{x}'" }] };
    const { answers } = check(JSON.stringify(hostile));
    expect(answers.map(({ variable }) => variable)).toEqual(["p1_a"]);
    expect(answers[0]!.form).toBeNull();
  });
});

test("the same texts can be read as by qdot check", () => {
  const { answers } = check(JSON.stringify({ cells: [], metadata: { qdot: stored.metadata } }));
  const forms = new Map(answers.map(({ variable, form }) => [variable, form]));
  const cases = stored.answers as unknown as readonly (readonly [part: string, text: string, isReadable: boolean])[];
  const differing = cases.flatMap(([part, text, isReadable]) => {
    const reading = readAnswer(text, forms.get(part.replace(/[.-]/g, "_"))!);
    const isRead = reading.kind === "formula" ? !reading.isPartlyBlank : ["words", "letters"].includes(reading.kind);
    return isRead === isReadable ? [] : [{ part, text: text.slice(0, 80), isReadable, reading }];
  });
  expect(cases.length).toBeGreaterThan(1500);
  expect(differing).toEqual([]);
});

describe("a cell of Python", () => {
  test("that is too long is only code for the names that it sets", () => {
    const source = `a = 1\nprint(b)\n  c = (${"1 + ".repeat(10_000)}1)`;
    expect(listAssignments(source)).toEqual(["a", "c"].map((name) => ({ name, code: null })));
    expect(listAssignments("a=".repeat(10_000) + "1").length).toBeLessThan(20);
  });

  test.each<[string, [string, string | null][]]>([
    [
      "a = 1; b = 2 # c = 3\nd == 4",
      [
        ["a", "1"],
        ["b", "2"],
      ],
    ],
    [
      'a = ("x"\n  "y = 1")\nb=c = """\nd = 1"""',
      [
        ["a", '("x"\n  "y = 1")'],
        ["b", '"""\nd = 1"""'],
        ["c", '"""\nd = 1"""'],
      ],
    ],
    [
      "a: str = 'x'\na += 'y'\nb, c = 1, 2\nfor d in e:\n  f = 1",
      [
        ["a", "'x'"],
        ["a", null],
        ["b", null],
        ["c", null],
        ["f", null],
      ],
    ],
    [
      'a = "open\nb = 1',
      [
        ["a", '"open'],
        ["b", "1"],
      ],
    ],
  ])("%j assigns", (source, expected) => {
    expect(listAssignments(source).map(({ name, code }) => [name, code])).toEqual(expected);
  });

  test.each([
    ['"a"', "a"],
    ["'\\theta \\sin \\\\alpha \\x41\\u00e9\\101'", "\theta \\sin \\alpha AéA"],
    ["r'\\theta'", "\\theta"],
    ["(\"a\"\n 'b')", "ab"],
    ['"""a\nb"""', "a\nb"],
    ['"a', null],
    ['f"a"', null],
    ['"a".strip()', null],
    ['"\\xZ"', null],
    ["a1", null],
    ["", null],
  ])("%j is the text %j", (code, text) => expect(parseText(code)).toBe(text));
});
