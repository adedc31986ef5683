// Rounds: errors in links, scores, stored and sent results, and platforms that fail.
import { expect, test } from "vitest";

import type { Index, Part } from "../src/bank.js";
import {
  listCandidates,
  asksForRound,
  EMPTY_LINK,
  isOrigin,
  type Link,
  type LinkedLesson,
  parseLink,
  makeRound,
  writeLink,
} from "../src/course/link.js";
import { makePageRecipient, type ResultMessage } from "../src/course/parent.js";
import { type PackageSet, selectRound as roundOfPlaces } from "../src/course/package-set.js";
import { makeBrowserRecipient, type Report } from "../src/course/recipient.js";
import {
  addAnswer,
  writeStanding,
  makeNewStanding,
  parseStanding,
  isDone,
  isLastTry,
  findNextPlace,
  type Round,
  computeScore,
  closeQuestion,
  type Standing,
} from "../src/course/round.js";
import {
  type WindowNode,
  type Api,
  formatClock,
  connect,
  formatDecimal,
  findApi,
  type Version,
} from "../src/course/scorm.js";
import { LESSONS } from "../src/learn/lessons.js";
import { verdictOf } from "../src/grade/verdict.js";
import { message } from "../src/text/text.js";

const LANGUAGES = ["en", "de"];
const INDEX: Index = {
  format: 1,
  feedback: "solutions",
  families: ["planar-2r", "scara"].map((name) => ({
    name,
    title: name,
    source: "",
    problems: ["001", "002", "003"].map((key) => ({
      key,
      title: "A",
      difficulty: 1,
      variation: "chapter",
      questions: name === "scara" ? ["jacobian", "determinant"] : ["position", "jacobian", "joint-effect"],
    })),
  })),
  questions: ["position", "jacobian", "joint-effect", "determinant"].map((name) => ({
    name,
    title: name,
    source: "",
    form: "",
  })),
};
const lessons: readonly LinkedLesson[] = [
  { id: "columns", questions: ["jacobian"], families: ["planar-2r"] },
  { id: "singular", questions: ["singular-angles"], families: ["planar-2r"] },
];

/** The key of a link's error; "" if the link makes a round. */
function errorKeyOf(search: string): string {
  const link = parseLink(search, LANGUAGES);
  if ("key" in link) return link.key;
  const round = makeRound(link, INDEX, lessons);
  return "key" in round ? round.key : "";
}
const roundBy = (search: string): Round => makeRound(parseLink(search, LANGUAGES) as Link, INDEX, lessons) as Round;
const namesIn = ({ questions }: Round) => questions.map(({ item }) => `${item.family}/${item.key}/${item.question}`);

test("a link with embed or a seed asks for a round, and is written as it was parsed", () => {
  expect(["?embed=1", "?seed=a", "?seed="].map(asksForRound)).toEqual([true, true, true]);
  expect(["", "?set=a", "?arm=scara&n=3"].map(asksForRound)).toEqual([false, false, false]);
  const full =
    "?embed=1&lesson=columns&arm=planar-2r&question=jacobian&difficulty=1&variation=chapter&n=3&seed=a+%26+b" +
    "&name=Week+3%3A+%C3%9Cbung&tries=2&origin=https%3A%2F%2Fmoodle.example.org&lang=de";
  expect(writeLink(parseLink(full, LANGUAGES) as Link)).toBe(full);
  expect(writeLink(EMPTY_LINK)).toBe("?n=5");
  expect(roundBy("?seed=x&family=scara").questions.every(({ item }) => item.family === "scara")).toBe(true);
});

test.each([
  ["?embed=1&foo=1", "link.unknown"],
  ["?embed=1&set=a", "link.unknown"],
  ["?embed=1&n=2&n=3", "link.twice"],
  ["?seed=a&arm=scara&family=scara", "link.twice"],
  ["?embed=2", "link.embed"],
  ["?seed=a&n=0", "link.count"],
  ["?seed=a&n=5.5", "link.count"],
  ["?seed=a&n=five", "link.count"],
  ["?seed=a&n=101", "link.count"],
  ["?seed=a&n=16", "link.too-many"],
  ["?seed=a&tries=-1", "link.tries"],
  ["?seed=a&tries=21", "link.tries"],
  ["?seed=a&difficulty=9", "practice.unknown-difficulty"],
  ["?seed=a&difficulty=x", "practice.unknown-difficulty"],
  ["?seed=a&origin=moodle.example.org", "link.origin"],
  ["?seed=a&origin=https://moodle.example.org/", "link.origin"],
  ["?seed=a&origin=*", "link.origin"],
  ["?seed=a&origin=", "link.origin"],
  ["?seed=a&origin=javascript:alert(1)", "link.origin"],
  ["?seed=a&lang=xx", "link.language"],
  [`?seed=${"a".repeat(101)}`, "link.long"],
  ["?seed=a&lesson=foo", "link.lesson"],
  ["?seed=a&lesson=singular", "link.not-in-lesson"],
  ["?seed=a&lesson=columns&arm=planar-2r&question=position", "link.not-in-lesson"],
  ["?seed=a&arm=foo", "practice.unknown-arm"],
  ["?seed=a&question=foo", "practice.unknown-question"],
  ["?seed=a&variation=foo", "practice.unknown-variation"],
  ["?seed=a&arm=scara&question=position", "practice.never-asked"],
  ["?seed=a&n=15", ""],
  ["?embed=1&seed=a&lesson=columns&n=3", ""],
  ["?seed=a&lesson=columns&arm=scara&n=3", ""],
])("%s: %s", (search, key) => {
  expect(errorKeyOf(search)).toBe(key);
});

test("the last try is the last one that can earn points", () => {
  const tried = (tries: number) => ({ tries, share: 0, shown: false });
  const of = (tries: number) => ({ ...roundBy("?seed=a&n=3"), tries });
  expect([0, 1, 2].map((made) => isLastTry(of(2), tried(made)))).toEqual([false, true, true]);
  expect(isLastTry(of(0), tried(5))).toBe(false);
});

test("the same seed selects the same questions, another seed other ones, and a lesson its own", () => {
  expect(namesIn(roundBy("?seed=a&n=6"))).toEqual(namesIn(roundBy("?embed=1&seed=a&n=6&name=x&lang=de")));
  expect(namesIn(roundBy("?seed=a&n=6"))).not.toEqual(namesIn(roundBy("?seed=b&n=6")));
  expect(new Set(namesIn(roundBy("?seed=a&n=15"))).size).toBe(15);
  expect(namesIn(roundBy("?seed=a&n=6")).slice(0, 3)).toEqual(namesIn(roundBy("?seed=a&n=3")));
  const ofLesson = listCandidates({ ...EMPTY_LINK, lesson: "columns" }, INDEX, lessons);
  expect(ofLesson).toHaveLength(3);
  expect(LESSONS.map(({ id }) => id)).toContain("columns"); // by which name links ask for it
});

test("an origin consists of a scheme, a host, and possibly a port", () => {
  expect(["https://a.example", "http://127.0.0.1:8000", "http://lms.example"].every(isOrigin)).toBe(true);
  for (const wrong of ["https://a.example/x", "https://A.example", "a", "file:///x", "null", "data:text/html,x", "//a"])
    expect(isOrigin(wrong), wrong).toBe(false);
});

// --- scores, and how they are stored ---

const roundWith = (count: number, tries = 0, passShare: number | null = null): Round => ({
  name: "R",
  seed: "s",
  tries,
  passShare,
  questions: Array.from({ length: count }, (_, i) => ({
    item: { family: "p1", key: `p1-${i}`, question: "jacobian" },
    points: i + 1,
    credit: 1,
  })),
});
const after = (round: Round, ...given: readonly (readonly [place: number, share: number])[]): Standing =>
  given.reduce((standing, [place, share]) => addAnswer(round, standing, place, share), makeNewStanding(round));

test("the best try counts, until an answer is right, the tries are used up, or the solution is shown", () => {
  const round = roundWith(3, 2);
  const standing = after(round, [0, 0.5], [0, 0.25], [0, 1], [1, 1], [1, 0]);
  expect(standing.map(({ share, tries }) => [share, tries])).toEqual([
    [0.5, 2], // the third came too late
    [1, 1],
    [0, 0],
  ]);
  expect(standing.map((tried) => isDone(round, tried))).toEqual([true, true, false]);
  expect(computeScore(round, standing)).toEqual({
    points: 2.5,
    max: 6,
    share: 2.5 / 6,
    answered: 2,
    done: 2,
    count: 3,
  });
  const seen = addAnswer(round, closeQuestion(standing, 2), 2, 1);
  expect(seen[2]).toEqual({ tries: 0, share: 0, shown: true });
  expect(computeScore(round, seen).answered).toBe(3);
  expect([findNextPlace(round, standing, 0), findNextPlace(round, standing, 2), findNextPlace(round, seen, 0)]).toEqual(
    [2, 2, null],
  );
});

test("a partly right answer earns a share by its question's credit, but never all points", () => {
  const round = { ...roundWith(1), questions: [{ ...roundWith(1).questions[0]!, credit: 0.5 }] };
  expect(after(round, [0, 0.8])[0]!.share).toBe(0.4);
  expect(after({ ...round, questions: [{ ...round.questions[0]!, credit: 0 }] }, [0, 0.8])[0]!.share).toBe(0);
  expect(after(round, [0, 1])[0]!.share).toBe(1);
});

test("a thousand questions fit into the storage of SCORM 1.2, and are restored unchanged", () => {
  const round = roundWith(1000);
  const standing = round.questions.map((_, i) => ({
    tries: i % 64,
    share: ((i * 7) % 1001) / 1000,
    shown: i % 2 === 1,
  }));
  const text = writeStanding(round, standing);
  expect(text).toMatch(/^[\w.-]+$/);
  expect(text.length).toBeLessThan(4096);
  expect(parseStanding(round, text)).toEqual(standing);
  const worst = round.questions.map(() => ({ tries: 63, share: 1, shown: true }));
  expect(writeStanding(round, worst).length).toBeLessThan(4096);
  expect(parseStanding(round, writeStanding(round, worst))).toEqual(worst);
  expect(writeStanding(round, makeNewStanding(round)).length).toBeLessThan(20);
});

test("an invalid text, or one of other questions, starts the round again", () => {
  const round = roundWith(3);
  const text = writeStanding(round, after(round, [0, 1], [2, 0.5]));
  expect(computeScore(round, parseStanding(round, text)).points).toBe(2.5);
  const print = text.split(".")[1];
  const wrong = [
    "",
    "x",
    "null",
    `q2.${print}.AAA`,
    `q1.${print}.AA`,
    `q1.${print}.A?A`,
    `q1.${print}.___`,
    `${text}.x`,
  ];
  for (const each of [...wrong, `q1.${print}.${"AAB".repeat(4)}`])
    expect(parseStanding(round, each), each).toEqual(makeNewStanding(round));
  expect(parseStanding(roundWith(4), text)).toEqual(makeNewStanding(roundWith(4)));
});

// --- each student's own ---

const SET: PackageSet = {
  key: "hw",
  title: "Homework",
  tries: 3,
  pass: null,
  places: [
    {
      name: "planar-2r",
      questions: [
        ["jacobian", 2, 1],
        ["position", 1, 0],
      ],
    },
    { name: "scara", questions: [["determinant", 1, 1]] },
  ],
};

test("each student always gets the same arms, and all arms are equally frequent", () => {
  const keys = (learner: string) => roundOfPlaces(SET, INDEX, learner).questions.map(({ item }) => item.key);
  expect(
    roundOfPlaces(SET, INDEX, "ada").questions.map(({ item, points, credit }) => [item.question, points, credit]),
  ).toEqual([
    ["jacobian", 2, 1],
    ["position", 1, 0],
    ["determinant", 1, 1],
  ]);
  expect(keys("ada")).toEqual(keys("ada"));
  expect(keys("ada")[0]).toBe(keys("ada")[1]); // one arm of a place
  for (const name of [
    (i: number) => String(i),
    (i: number) => `student${i}@example.org`,
    (i: number) => `id=${1000 + 2 * i}`,
  ]) {
    const drawn = Array.from({ length: 900 }, (_, i) => keys(name(i)));
    for (const place of [0, 2])
      for (const key of ["001", "002", "003"]) {
        const count = drawn.filter((each) => each[place] === key).length;
        expect(Math.abs(count - 300), `${key}: ${count} of 900`).toBeLessThan(75); // five standard deviations
      }
    const both = new Set(drawn.map((each) => `${each[0]} ${each[2]}`));
    expect(both.size).toBe(9); // one place says nothing of another
  }
});

// --- the page around ---

const PART = { key: { type: "values" } } as unknown as Part;
const newsOf = (round: Round, standing: Standing, place: number | null = null, answer = "a1"): Report => ({
  round,
  standing,
  score: computeScore(round, standing),
  lastAnswer: place === null ? null : { place, part: PART, answer, verdict: verdictOf(0.5, []) },
});

class Kept {
  private readonly held = new Map<string, string>();
  getItem = (key: string) => this.held.get(key) ?? null;
  setItem = (key: string, value: string) => void this.held.set(key, value);
}

test("scores are sent to the surrounding page at its origin, and to nobody without a frame", () => {
  const round = roundWith(2);
  const sent: [ResultMessage, string][] = [];
  const post = (told: ResultMessage, origin: string) => void sent.push([told, origin]);
  const storage = new Kept() as unknown as Storage;
  const named = { named: "https://lms.example", own: "https://qdot.example" };
  const parent = makePageRecipient({ isFramed: true, post }, named, storage, "k");
  expect(parent.destination).toEqual(message("round.sent-to", { origin: "https://lms.example" }));
  parent.report(newsOf(round, makeNewStanding(round)));
  const standing = after(round, [0, 0.5]);
  parent.report(newsOf(round, standing, 0, "x".repeat(9000)));
  parent.report(newsOf(round, closeQuestion(standing, 1))); // the last question is given up for its solution
  parent.report(newsOf(round, after(round, [0, 0.5], [1, 0]), 1));
  expect(sent.map(([{ event }, origin]) => [event, origin])).toEqual([
    ["opened", "https://lms.example"],
    ["answered", "https://lms.example"],
    ["completed", "https://lms.example"],
    ["completed", "https://lms.example"],
  ]);
  const [told] = sent[1]!;
  expect(told.score).toEqual({ points: 0.5, max: 3, scaled: 0.5 / 3, answered: 1, count: 2 });
  expect(told.answer).toMatchObject({
    question: "p1/p1-0/jacobian",
    number: 1,
    share: 0.5,
    tries: 1,
    outcome: "partial",
  });
  expect(told.answer!.typed).toHaveLength(4000);
  const again = makePageRecipient({ isFramed: true, post }, { ...named, named: "" }, storage, "k");
  expect(parseStanding(round, again.stored)).toEqual(after(round, [0, 0.5], [1, 0]));
  again.report(newsOf(round, standing));
  expect(sent.at(-1)![1]).toBe("https://qdot.example");
  const alone = makePageRecipient({ isFramed: false, post }, named, null, "k");
  expect(alone.destination.key).toBe("round.not-sent");
  expect(alone.report(newsOf(round, standing, 0))).toBe(true);
  expect(sent).toHaveLength(5);
});

test("a round works in a browser that stores nothing, or is full", () => {
  const refusing = {
    getItem: () => {
      throw new Error("refused");
    },
    setItem: () => {
      throw new Error("full");
    },
  } as unknown as Storage;
  for (const storage of [null, refusing]) {
    const nobody = makeBrowserRecipient(storage, "k", message("round.not-sent"));
    expect(nobody.stored).toBe("");
    expect(nobody.report(newsOf(roundWith(1), makeNewStanding(roundWith(1))))).toBe(true);
  }
});

// --- platforms ---

/** A window chain: this one, in one, in one that has the platform. */
function under(platforms: Record<string, Api>): WindowNode {
  const top = { ...platforms } as unknown as WindowNode & { parent: unknown };
  top.parent = top;
  return { parent: { parent: top } as unknown as WindowNode };
}

/** A platform that stores values; calls named in `fails` are refused or throw. */
function keeping(version: Version, fails: Record<string, "false" | "throws"> = {}, first: Record<string, string> = {}) {
  const values = new Map<string, string>(Object.entries(first));
  const calls: string[] = [];
  const prefix = version === "1.2" ? "LMS" : "";
  const call = (name: string, done: (...values: string[]) => string) => [
    prefix + name,
    (...given: string[]) => {
      calls.push(name);
      if (fails[name] === "throws") throw new Error(name);
      return fails[name] ?? done(...given);
    },
  ];
  const api = Object.fromEntries([
    call("Initialize", () => "true"),
    call("GetValue", (name) => values.get(name!) ?? ""),
    call("SetValue", (name, value) => (values.set(name!, value!), "true")),
    call("Commit", () => "true"),
    call(version === "1.2" ? "Finish" : "Terminate", () => "true"),
  ]) as Api;
  return { values, calls, windows: under({ [version === "1.2" ? "API" : "API_1484_11"]: api }) };
}

test.each(["1.2", "2004"] as const)("score, status, time and standing are sent by SCORM %s", (version) => {
  const { values, calls, windows } = keeping(version);
  const there = connect(version, windows)!;
  const round = roundWith(2, 3, 0.6);
  there.report(newsOf(round, makeNewStanding(round)));
  const told = (name12: string, name2004: string) => values.get(version === "1.2" ? name12 : name2004);
  expect(told("cmi.core.lesson_status", "cmi.completion_status")).toBe("incomplete");
  expect(told("cmi.core.score.raw", "cmi.score.scaled")).toBe("0");
  const standing = after(round, [0, 0.5], [1, 1]);
  there.report(newsOf(round, standing, 1));
  expect(told("cmi.core.score.raw", "cmi.score.raw")).toBe("83.33");
  expect(told("cmi.core.score.max", "cmi.score.max")).toBe("100");
  expect(told("cmi.core.score.min", "cmi.score.min")).toBe("0");
  expect(told("cmi.core.lesson_status", "cmi.success_status")).toBe("passed");
  expect(told("cmi.core.exit", "cmi.exit")).toBe("suspend");
  expect(told("cmi.core.session_time", "cmi.session_time")).toMatch(
    version === "1.2" ? /^00:00:\d\d\.\d\d$/ : /^PT\d+(\.\d+)?S$/,
  );
  if (version === "2004") {
    expect(values.get("cmi.score.scaled")).toBe("0.833333");
    expect(values.get("cmi.completion_status")).toBe("completed");
    expect(values.get("cmi.progress_measure")).toBe("1");
  }
  expect(calls.filter((name) => name === "Commit")).toHaveLength(2);
  there.leave(newsOf(round, standing));
  there.leave(newsOf(round, standing)); // a page is left once
  expect(calls.filter((name) => ["Finish", "Terminate"].includes(name))).toHaveLength(1);
  const resumed = connect(version, keeping(version, {}, Object.fromEntries(values)).windows)!;
  expect(parseStanding(round, resumed.stored)).toEqual(standing);
});

test("without a pass mark, no success status is sent; below it, a complete round is failed", () => {
  for (const [version, pass, said] of [
    ["1.2", null, "completed"],
    ["1.2", 0.9, "failed"],
    ["2004", null, "unknown"],
    ["2004", 0.9, "failed"],
  ] as const) {
    const { values, windows } = keeping(version);
    const round = roundWith(1, 1, pass);
    connect(version, windows)!.report(newsOf(round, after(round, [0, 0.5]), 0));
    expect(values.get(version === "1.2" ? "cmi.core.lesson_status" : "cmi.success_status")).toBe(said);
  }
});

test("answers are recorded with their type if the platform records answers, up to its limit", () => {
  const record = (version: Version, part: Part, answer: string, count: string) => {
    const { values, windows } = keeping(version, {}, { "cmi.interactions._count": count });
    const round = roundWith(1);
    connect(version, windows)!.report({
      ...newsOf(round, after(round, [0, 0.5])),
      lastAnswer: { place: 0, part, answer, verdict: verdictOf(0.5, []) },
    });
    return Object.fromEntries([...values].filter(([name]) => /interactions\.\d/.test(name)));
  };
  const of = (type: string) => ({ key: { type } }) as unknown as Part;
  const formula = record("1.2", PART, `a1*\n${"x".repeat(300)}`, "4");
  expect(formula["cmi.interactions.4.type"]).toBe("fill-in");
  expect(formula["cmi.interactions.4.student_response"]).toBe(`a1* ${"x".repeat(251)}`);
  expect(formula["cmi.interactions.4.result"]).toBe("wrong");
  expect(formula["cmi.interactions.4.time"]).toMatch(/^\d\d:\d\d:\d\d\.00$/);
  expect(record("1.2", of("selection"), "BD", "0")["cmi.interactions.0.student_response"]).toBe("b,d");
  expect(record("1.2", of("matching"), "BA", "0")["cmi.interactions.0.student_response"]).toBe("1.b,2.a");
  expect(record("2004", of("selection"), "BD", "0")["cmi.interactions.0.learner_response"]).toBe("b[,]d");
  expect(record("2004", of("matching"), "BA", "0")["cmi.interactions.0.learner_response"]).toBe("1[.]b[,]2[.]a");
  const long = record("2004", PART, "x".repeat(5000), "0");
  expect(long["cmi.interactions.0.type"]).toBe("long-fill-in");
  expect(long["cmi.interactions.0.learner_response"]).toHaveLength(4000);
  expect(long["cmi.interactions.0.timestamp"]).toMatch(/^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d\dZ$/);
  expect(record("2004", PART, "x", "")).toEqual({});
  expect(record("2004", PART, "x", "250")).toEqual({});
});

test("if calls to a platform fail, the round goes on, and the results are sent again", () => {
  const round = roundWith(1);
  const news = newsOf(round, after(round, [0, 1]), 0);
  for (const version of ["1.2", "2004"] as const) {
    for (const how of ["false", "throws"] as const) {
      expect(connect(version, keeping(version, { Initialize: how }).windows)).toBeNull();
      expect(connect(version, keeping(version, { Commit: how }).windows)!.report(news)).toBe(false);
      expect(connect(version, keeping(version, { SetValue: how }).windows)!.report(news)).toBe(false);
      const unread = connect(version, keeping(version, { GetValue: how }).windows)!;
      expect(unread.report(news)).toBe(true);
      const ending = keeping(version, { Finish: how, Terminate: how });
      const there = connect(version, ending.windows)!;
      there.leave(news);
      expect(ending.calls.at(-1)).toBe(version === "1.2" ? "Finish" : "Terminate");
      expect(ending.values.get("cmi.suspend_data")).toBe(writeStanding(round, news.standing));
    }
  }
});

test("in review mode, nothing is sent", () => {
  const mode = { "1.2": "cmi.core.lesson_mode", "2004": "cmi.mode" } as const;
  for (const version of ["1.2", "2004"] as const) {
    const { calls, windows } = keeping(version, {}, { [mode[version]]: "review" });
    const there = connect(version, windows)!;
    expect(there.isAccepting).toBe(false);
    there.report(newsOf(roundWith(1), makeNewStanding(roundWith(1)), 0));
    there.leave(newsOf(roundWith(1), makeNewStanding(roundWith(1))));
    expect(calls.filter((name) => ["SetValue", "Commit"].includes(name))).toEqual([]);
  }
});

test("a platform is searched in parent windows, then in those that opened them; refusing windows are skipped", () => {
  const api = { LMSInitialize: () => "true" } as Api;
  const refusing = new Proxy({} as WindowNode, {
    get: (_, name) => {
      if (name === "parent") return top;
      throw new Error("another origin");
    },
  });
  const top = { API: api } as unknown as WindowNode & { parent: WindowNode };
  top.parent = top;
  expect(findApi("API", { parent: refusing })).toBe(api);
  expect(findApi("API_1484_11", { parent: refusing })).toBeNull();
  const alone = { opener: refusing } as unknown as WindowNode & { parent: WindowNode };
  alone.parent = alone;
  expect(findApi("API", alone)).toBe(api);
  const endless = (): WindowNode => ({
    get parent() {
      return endless();
    },
  });
  expect(findApi("API", endless())).toBeNull();
  expect(findApi("API", { parent: null })).toBeNull();
});

test("numbers and times have the formats of the data models", () => {
  expect([
    formatDecimal(100, 2),
    formatDecimal(0, 2),
    formatDecimal(83.3333, 2),
    formatDecimal(1e-9, 6),
    formatDecimal(2.5, 6),
  ]).toEqual([...["100", "0", "83.33", "0", "2.5"]]);
  expect([formatClock(0), formatClock(3725.456), formatClock(59.999), formatClock(1e9)]).toEqual([
    ...["00:00:00.00", "01:02:05.46", "00:01:00.00", "9999:59:59.99"],
  ]);
});
