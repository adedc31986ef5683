// @vitest-environment happy-dom
// The pages of `qdot serve`: what a student typed is in the fields, late work is warned of, the staff mark by keys.
import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, test, vi } from "vitest";

import type { AskedPart } from "../../src/bank.js";
import { ExtensionForm, PointsForm, readPoints } from "../../src/serve/points-form.js";
import { writeLocalTime } from "../../src/text/times.js";
import type { ClassResults, ClassStudent, Shown, Work } from "../../src/serve/api.js";
import { ClassPage } from "../../src/serve/class-page.js";
import { ClassTable, listStudents, numberParts } from "../../src/serve/class-table.js";
import { StudentPage } from "../../src/serve/student.js";
import { ToMark } from "../../src/serve/to-mark.js";
import { storage } from "../../src/storage.js";
import { PLAIN } from "../arm/robots.js";
import { type Answer, serve, type Sent } from "./server.js";

// All at once: what is shown is tested here, not when.
vi.mock("../../src/scheduling.js", async (real) => ({
  ...(await real<typeof import("../../src/scheduling.js")>()),
  useSteps: (last: number) => Math.min(last, 2), // without the arm
}));
// Formulas are not typeset, because happy-dom has no mode for them.
vi.mock("../../src/tex.js", () => ({ typeset: async () => undefined, typesetInto: async () => undefined }));

const SHOWN: Shown = {
  ...{ outcome: "missing", points: 0, max_points: 1, sentences: [], entries: null, counterexample: null, pose: null },
  ...{ followed_from: null, answer: null, comment: "", tries_left: null },
};
const PART: AskedPart = {
  ...{ name: "determinant", kind: "determinant", title: "Determinant", type: "expression", shape: null, points: 1 },
  ...{ prompt: "", names: [], labels: [], columns: [], grid: [[], []], figure: "", alt: "", pose: null, hints: [] },
  ...{ options: null, key: { type: "values" } },
} as const;
const PROBLEM = {
  ...{ id: "p1", family: "planar-2r", title: "Arm", difficulty: 1, statement: "", figure: "", alt: "", robot: PLAIN },
  ...{ symbols: {}, pose: {} },
};
const WORK: Work = {
  ...{ title: "Week 3", person: 1, student: { id: "s1", name: "Ada" }, now: "2027-01-15T12:00:00Z", is_late: false },
  ...{ due: "2027-01-15T13:00:00Z", late_rule: "It loses 10 %.", attempts: { left: null, rule: "", tries: null } },
  ...{ score: 0, takes_notebooks: true, practice: null },
  ...{ max_score: 1, notes: [], closed: "", answers: {}, drafts: {}, results: {}, submissions: [] },
  problems: [{ slot: "p1", problem: { ...PROBLEM, parts: [PART] } }],
};
const JUDGED = {
  results: { "p1.determinant": { ...SHOWN, outcome: "correct", points: 1 } },
  score: 1,
  state: "marked",
};

async function showStudent(work: Partial<Work>, part: Partial<AskedPart> = {}): Promise<Sent[]> {
  const problems = [{ slot: "p1", problem: { ...PROBLEM, parts: [{ ...PART, ...part } as AskedPart] } }];
  const shown = { ...WORK, problems, ...work };
  const requests = serve(({ path }): Answer => [200, path.startsWith("work") ? shown : { ...shown, ...JUDGED }]);
  await act(async () => render(h(StudentPage, {}), document.body));
  await vi.waitFor(() => expect(document.querySelector("form")).not.toBeNull());
  return requests;
}
const press = (text: string) =>
  act(async () => [...document.querySelectorAll("button")].find(({ textContent }) => textContent === text)!.click());
const submitted = (requests: Sent[]) => requests.filter(({ path }) => path === "answers").map(({ body }) => body.text);
const typedTexts = () =>
  [...document.querySelectorAll<HTMLInputElement>(".answer input, .answer textarea")].map(({ type, value, checked }) =>
    type === "text" || type === "textarea" ? value : checked,
  );

beforeEach(() => storage?.clear());
afterEach(() => {
  render(null, document.body);
  storage?.clear();
  vi.unstubAllGlobals();
});

const BEGUN = { results: { "p1.determinant": { ...SHOWN, outcome: "wrong" } } } as const;
const OVERDUE = { due: "2027-01-15T11:00:00Z", answers: { "p1.determinant": "1" }, drafts: { "p1.determinant": "2" } };

test.each([
  ["on time", { due: "2027-01-15T13:00:00Z" }, false],
  ["the first answer", { results: {} }, false],
  ["already late", { is_late: true }, false],
  ["attempts that count apart", { attempts: { left: 2, rule: "", tries: null } }, false],
  ["what makes the whole work late", {}, true],
] as const)("before a late answer there is a warning only for %s", async (_, work, isWarned) => {
  const requests = await showStudent({ ...OVERDUE, ...BEGUN, ...work });
  await press("Submit");
  expect(submitted(requests)).toEqual(isWarned ? [] : ["2"]);
  expect(document.body.textContent!.includes("your whole work counts as late")).toBe(isWarned);
  if (!isWarned) return;
  await press("Submit anyway");
  expect(submitted(requests)).toEqual(["2"]);
});

test("where nothing can be submitted any more, the page says why", async () => {
  const requests = await showStudent({ closed: "You have used all attempts.", drafts: { "p1.determinant": "2" } });
  await press("Submit");
  expect(document.querySelector("[role=alert]")!.textContent).toBe("You have used all attempts.");
  expect(submitted(requests)).toEqual([]);
});

const TRIES = { left: null, rule: "", tries: 3 };
test.each([
  [2, "wrong", ["2"], "2 of 3 tries left for this question."],
  [0, "wrong", [], "You have no tries left for this question."],
] as const)("with %j tries left after a %s answer, the page sends %j", async (left, outcome, texts, sentence) => {
  const results = { "p1.determinant": { ...SHOWN, outcome, tries_left: left } };
  const drafts = { "p1.determinant": "2" };
  const requests = await showStudent({ attempts: TRIES, results, drafts, takes_notebooks: false });
  expect(document.querySelector(".notebook-work")).toBeNull();
  await press("Submit");
  expect(submitted(requests)).toEqual(texts);
  if (left === 0) expect(document.querySelector("[role=alert]")!.textContent).toBe(sentence);
  else expect(document.body.textContent).not.toContain("no tries left");
});

test.each([
  [null, []],
  [{ next: "practice/1/", home: "" }, ["practice/1/"]],
  [{ next: "../4/", home: "../../" }, ["../../", "../4/"]],
])("with practice %j, the page links to %j", async (practice, addresses) => {
  await showStudent({ practice, takes_notebooks: false });
  const links = [...document.querySelectorAll("section.choosing a")].map((link) => link.getAttribute("href"));
  expect(links).toEqual(addresses);
  expect(document.body.textContent!.includes("no mark is stored")).toBe(practice?.home === "../../");
});

const MATRIX = { shape: [2, 2], type: "matrix" } as const;
const OPTIONS = { options: ["", "", ""], type: "selection", key: { type: "selection", items: 0 } } as const;
test.each([
  ["sin(theta1)", {}, ["sin(theta1)"]],
  ["[[a, b], [c, d]]", MATRIX, ["a", "b", "c", "d"]],
  ["[[a, blank], [blank, d]]", MATRIX, ["a", "", "", "d"]],
  ["Matrix of zeros", MATRIX, ["Matrix of zeros"]], // as text, because it has no entries
  ["AC", OPTIONS, [true, false, true]],
  ["Two\nlines", { type: "text", key: { type: "text" } }, ["Two\nlines"]],
] as [string, Partial<AskedPart>, unknown[]][])("the text %j is in the fields again", async (text, part, expected) => {
  const requests = await showStudent(
    { answers: { "p1.determinant": "old" }, drafts: { "p1.determinant": text } },
    part,
  );
  expect(typedTexts()).toEqual(expected);
  expect(requests.map(({ path }) => path.split("?")[0])).toEqual(["work"]); // nothing was typed, so nothing is saved
});

const type = (text: string) =>
  act(async () => {
    const input = document.querySelector<HTMLInputElement>(".answer input")!;
    input.value = text;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  });

test("an answer that was submitted before is said to be repeated only at once after the same", async () => {
  const repeated = () => document.body.textContent!.includes("You have submitted this answer already.");
  const requests = await showStudent({ ...BEGUN, due: null, answers: { "p1.determinant": "0" } });
  await press("Submit");
  expect([submitted(requests), repeated()]).toEqual([[], true]);
  await type("theta1");
  await press("Submit");
  await vi.waitFor(() => expect(document.querySelector(".verdict.correct")).not.toBeNull());
  expect([submitted(requests), repeated()]).toEqual([["theta1"], false]);
});

test("an empty field of a vector uses up a try only after a warning", async () => {
  const vector = { shape: [2, 1], type: "matrix" } as const;
  const requests = await showStudent({ attempts: TRIES, drafts: { "p1.determinant": "[[1], [blank]]" } }, vector);
  await press("Submit");
  expect([submitted(requests), document.querySelector("[role=alert]")!.textContent]).toEqual([
    [],
    expect.stringContaining("uses up a try"),
  ]);
  await press("Submit anyway");
  expect(submitted(requests)).toEqual(["[[1], [blank]]"]);
});

test("a notebook replaces answers only after a warning; then the fields have its answers, and the old can return", async () => {
  const result = (outcome: Shown["outcome"]) => ({ "p1.determinant": { ...SHOWN, outcome } });
  const uploaded = {
    kind: "notebook",
    part: "",
    file_name: "a.ipynb",
    received: WORK.now,
    place: null,
    score: 0,
    note: "",
  };
  const answers = { "p1.determinant": "Matrix([[1], [2]])" };
  const vector = { shape: [2, 1], type: "matrix" } as const;
  const old = { due: null, answers: { "p1.determinant": "[[3], [4]]" }, results: result("correct") };
  await showStudent(old, vector);
  const problems = [{ slot: "p1", problem: { ...PROBLEM, parts: [{ ...PART, ...vector }] } }];
  const later = {
    ...WORK,
    ...old,
    problems,
    answers,
    results: result("wrong"),
    submissions: [{ ...uploaded, id: 5, state: "marked" }],
  };
  const requests = serve(({ path }): Answer => {
    if (path === "notebooks") return [202, { submission: 5, place: 0 }];
    if (path.startsWith("work")) return [200, later];
    return [200, path.startsWith("submissions") ? later.submissions[0] : { ...later, ...JUDGED }];
  });
  const input = document.querySelector<HTMLInputElement>("input[type=file]")!;
  Object.defineProperty(input, "files", { value: [new File(["{}"], "a.ipynb")] });
  await act(async () => void input.dispatchEvent(new Event("change", { bubbles: true })));
  expect(requests).toEqual([]);
  expect(document.body.textContent).toContain("it replaces all your submitted answers");
  await press("Submit anyway");
  await vi.waitFor(() => expect(typedTexts()).toEqual(["1", "2"]), { timeout: 5000 });
  await act(async () => undefined); // the fields have reported their text
  await press("Submit");
  expect(document.body.textContent).toContain("You have submitted this answer already.");
  await type("3");
  await press("Submit");
  expect(submitted(requests)).toEqual(["[[3], [2]]"]);
});

const PARTS = ["p1.a", "p1.b", "p2.a"].map((name) => ({ name, title: name, max_points: 3, is_text: true }));
const student = (id: number, changes: Partial<ClassStudent> = {}): ClassStudent => ({
  ...{ id, student_id: `s${id}`, name: `Student ${String(id).padStart(3, "0")}`, begun: null, last: null },
  ...{ is_late: false, due: null, score: null, marks: {}, notes: "", ...changes },
});
const RESULTS: ClassResults = {
  ...{ version: 1, title: "Week 3", due: null, max_score: 9, parts: PARTS, groups: [], actions: [] },
  ...{ refused: [], file_error: "" },
  students: Array.from({ length: 300 }, (_, id) => student(id)),
  to_mark: [1, 2, 3].map((id) => ({ student: id, part: "p1.a", text: `Answer ${id}` })),
};

test("a new mark of one of 300 students changes that student's row alone", async () => {
  const show = (results: ClassResults) =>
    act(() => render(h(ClassTable, { results, onStudent: () => undefined }), document.body));
  await show(RESULTS);
  const rows = [...document.querySelectorAll("tbody tr")];
  expect(rows).toHaveLength(300);
  const changed = new Set<Node>();
  const observer = new MutationObserver((records) => records.forEach(({ target }) => changed.add(target)));
  observer.observe(document.body, { subtree: true, childList: true, characterData: true, attributes: true });
  const mark = { outcome: "correct", points: 3, mistake: "", is_override: false } as const;
  const news = JSON.parse(JSON.stringify(RESULTS)) as ClassResults; // as from the server
  await show({ ...news, students: news.students.with(7, student(7, { score: 3, marks: { "p1.a": mark } })) });
  await Promise.resolve();
  observer.disconnect();
  expect(rows[7]!.textContent).toContain("✓");
  expect(changed.size).toBeGreaterThan(0);
  expect([...changed].filter((node) => !rows[7]!.contains(node))).toEqual([]);
});

test("the changes of grading again have the numbers of the questions, and the total its name", async () => {
  const change = { student: 1, name: "Ada", part: "p2.a", before: null, after: 0 };
  const changes = [change, { ...change, part: "", before: 0.5, after: 1 }, { ...change, part: "p9.gone", before: 1 }];
  serve(({ path }): Answer => [200, path === "regrade" ? { waiting: 0, token: "t", changes } : RESULTS]);
  await act(async () => render(h(ClassPage, {}), document.body));
  await vi.waitFor(() => expect(document.querySelector(".regrading")).not.toBeNull());
  await press("Grade again");
  const rows = () => [...document.querySelectorAll(".regrading tr")].map((row) => row.textContent);
  await vi.waitFor(() => expect(rows()).toEqual(["Ada2.1– → 0", "AdaScore0.5 → 1", "Adap9.gone1 → 0"]));
});

test("students are found by words, filtered and ordered", () => {
  const last = "2027-01-15T12:00:00Z";
  const students = [
    student(1, { name: "Ada Lovelace", score: 1, begun: last, last, is_late: true }),
    student(2, { name: "Zoë Ångström", score: 2, begun: last, last }),
    student(3, { name: "" }),
  ];
  const found = (choice: Partial<Parameters<typeof listStudents>[1]>) =>
    listStudents(students, { filter: "all", search: "", order: "name", ...choice }).map(({ id }) => id);
  expect(found({})).toEqual([1, 3, 2]);
  expect(found({ search: "love ADA" })).toEqual([1]);
  expect(found({ search: "s3" })).toEqual([3]);
  expect(found({ order: "score" })).toEqual([2, 1, 3]);
  expect(found({ filter: "late" })).toEqual([1]);
  expect(found({ filter: "not-begun" })).toEqual([3]);
});

test("parts have the numbers that students see", () => {
  expect(numberParts(PARTS)).toEqual({ "p1.a": "1.1", "p1.b": "1.2", "p2.a": "2.1" });
});

test("texts are marked by keys, also faster than the server answers; what it refuses is named", async () => {
  const requests = serve(({ body }) => (body.student === 2 ? [400, { error: "No." }] : [200, {}]));
  await act(() => render(h(ToMark, { results: RESULTS, onChange: () => undefined }), document.body));
  const key = (name: string, target = document.activeElement!) =>
    act(() => void target.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true })));
  const text = () => document.querySelector("blockquote")!.textContent;
  const keys = ["9", "2", "1", "k", "k", "j", "j", "j", "0"]; // 9 is more than the question has
  for (const name of keys) await key(name);
  expect(text()).toBe("Answer 3");
  await key("3", document.querySelector(".points-form input")!); // typed into a field
  expect(requests.map(({ body }) => [body.student, body.points, body.answer])).toEqual([
    [1, 2, "Answer 1"],
    [2, 1, "Answer 2"],
    [3, 0, "Answer 3"],
  ]);
  await vi.waitFor(() => expect(document.querySelector("[role=alert]")!.textContent).toBe("Student 002: No."));
});

test("an empty form takes points back, and points beyond the most are refused on the page", async () => {
  const requests = serve(() => [200, {}]);
  const props = { target: { student: 1, part: "p1.a" }, max: 2, points: 1.5, onSaved: () => undefined };
  await act(() => render(h(PointsForm, props), document.body));
  const save = async (points: string) => {
    const input = document.querySelector("input")!;
    input.value = points;
    await act(() => void input.dispatchEvent(new Event("input", { bubbles: true })));
    await act(() => void document.querySelector("form")!.dispatchEvent(new Event("submit", { cancelable: true })));
  };
  await save("3");
  expect(document.querySelector("[role=alert]")!.textContent).toContain("from 0 to 2");
  await save("");
  expect(requests.map(({ body }) => body)).toEqual([{ student: 1, part: "p1.a", points: null, comment: "" }]);
});

test.each([
  ["", null],
  ["0,5", 0.5],
  ["2", 2],
  [".5", 0.5],
  ["1e9", NaN],
  ["two", NaN],
  ["-1", NaN],
  ["0x10", NaN],
] as const)("the points %j are read as %j", (text, points) => expect(readPoints(text)).toBe(points));

test("a time is in a field as the field takes it", () => {
  const time = new Date(2027, 0, 5, 7, 3);
  expect(writeLocalTime(time)).toBe("2027-01-05T07:03");
  expect(new Date(writeLocalTime(time))).toEqual(time);
});

test.each([
  ["2027-01-14T12:00:00Z", true],
  ["2027-01-16T12:00:00Z", false],
] as const)("a due date %s gets a warning: %j", async (due, isWarned) => {
  const props = { student: student(1, { due }), classDue: "2027-01-15T12:00:00Z", onSaved: () => undefined };
  await act(async () => render(h(ExtensionForm, props), document.body));
  expect(document.body.textContent!.includes("earlier than the due date of the class")).toBe(isWarned);
});

test("scores that the platform refuses are named, and sent again by a button", async () => {
  const refused = [{ student: 1, error: "refused: HTTP 404" }];
  const requests = serve(({ path }) => [200, path.startsWith("results") ? { ...RESULTS, refused } : {}]);
  await act(async () => render(h(ClassPage, {}), document.body));
  await vi.waitFor(() => expect(document.querySelector("[role=alert]")).not.toBeNull());
  expect(document.querySelector("[role=alert]")!.textContent).toContain("Student 001 (refused: HTTP 404)");
  await press("Send them again");
  expect(requests.filter(({ method }) => method === "POST").map(({ path }) => path)).toEqual(["scores"]);
});
