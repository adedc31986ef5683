// A learning platform that speaks SCORM 1.2 or SCORM 2004: how it is found, and what it is told.
//
// Everything that matters is set and committed with each answer: as a page is left, browsers let go of what it still
// asks for. A platform that fails keeps nobody from going on.

import type { Part } from "../bank.js";
import { message } from "../text/text.js";
import { isComplete, isPassed, type Given, type News, type Recipient } from "./recipient.js";
import { asText, type Round, type Score } from "./round.js";

export type Version = "1.2" | "2004";

/** What a platform puts into a window above the package's: its functions by name. */
export type Api = Readonly<Record<string, (...values: string[]) => unknown>>;

/** Elements of the data model: what a platform is to keep, in the order in which it is told. */
export type Elements = readonly (readonly [name: string, value: string])[];

interface Model {
  readonly api: string;
  readonly prefix: string;
  readonly finish: string;
  readonly learner: string;
  readonly mode: string;
  results(round: Round, score: Score): Elements;
  time(seconds: number): Elements;
  readonly answer: AnswerModel;
  /** When an answer is given. */
  moment(now: Date): readonly [name: string, value: string];
}

// --- what is told ---

/** As many answers are recorded as every platform has room for. */
const MOST_RECORDED = 250;

const SCORM12: Model = {
  api: "API",
  prefix: "LMS",
  finish: "Finish",
  learner: "cmi.core.student_id",
  mode: "cmi.core.lesson_mode",
  results(round, score) {
    const passed = isPassed(round, score);
    const over = passed === null ? "completed" : passed ? "passed" : "failed";
    return [
      ["cmi.core.score.min", "0"], // this version has percent only
      ["cmi.core.score.max", "100"],
      ["cmi.core.score.raw", decimal(score.share * 100, 2)],
      ["cmi.core.lesson_status", isComplete(score) ? over : "incomplete"],
    ];
  },
  time: (seconds) => [
    ["cmi.core.session_time", clock(seconds)],
    ["cmi.core.exit", "suspend"],
  ],
  answer: { type: "fill-in", most: 255, between: ",", pair: ".", name: "student_response", wrong: "wrong" },
  moment: (now) => ["time", clock(now.getHours() * 3600 + now.getMinutes() * 60 + now.getSeconds())],
};

const SCORM2004: Model = {
  api: "API_1484_11",
  prefix: "",
  finish: "Terminate",
  learner: "cmi.learner_id",
  mode: "cmi.mode",
  results(round, score) {
    const passed = isComplete(score) ? isPassed(round, score) : null;
    return [
      ["cmi.score.min", "0"],
      ["cmi.score.max", "100"], // percent here, too: platforms take raw for their grade
      ["cmi.score.raw", decimal(score.share * 100, 2)],
      ["cmi.score.scaled", decimal(score.share, 6)],
      ["cmi.progress_measure", decimal(score.answered / Math.max(score.count, 1), 6)],
      ["cmi.completion_status", isComplete(score) ? "completed" : "incomplete"],
      ["cmi.success_status", passed === null ? "unknown" : passed ? "passed" : "failed"],
    ];
  },
  time: (seconds) => [
    ["cmi.session_time", `PT${decimal(seconds, 2)}S`],
    ["cmi.exit", "suspend"],
  ],
  answer: {
    ...{ type: "long-fill-in", most: 4000, between: "[,]", pair: "[.]" },
    ...{ name: "learner_response", wrong: "incorrect" },
  },
  moment: (now) => ["timestamp", `${now.toISOString().slice(0, "2026-11-25T22:42:51.12".length)}Z`],
};

export const MODELS: Readonly<Record<Version, Model>> = { "1.2": SCORM12, "2004": SCORM2004 };

/** How a data model has answers: what typed ones are called, and how long they may be. */
interface AnswerModel {
  readonly type: string;
  readonly most: number;
  /** What stands between letters, and between the two of a pair. */
  readonly between: string;
  readonly pair: string;
  /** The element of the answer, and what is said of one that is wrong. */
  readonly name: string;
  readonly wrong: string;
}

/** An answer, as the n-th of the platform's record. */
function interaction(model: Model, n: number, { place, part, answer, verdict }: Given, round: Round): Elements {
  const { item, points } = round.asked[place]!;
  const [type, response] = responseOf(part, answer, model.answer);
  const elements: Elements = [
    ["id", `${item.key}.${item.question}`],
    ["type", type],
    model.moment(new Date()),
    ["weighting", decimal(points, 4)],
    [model.answer.name, response],
    ["result", verdict.outcome === "correct" ? "correct" : model.answer.wrong],
  ];
  return elements.map(([name, value]) => [`cmi.interactions.${n}.${name}`, value]);
}

/** The type of an answer and the answer as the data model writes them: letters in lower case, formulas as typed. */
function responseOf({ key }: Part, answer: string, as: AnswerModel): [type: string, response: string] {
  const letters = [...answer.trim().toLowerCase()];
  if (/^[A-H]+$/i.test(answer.trim())) {
    if (key.type === "choice" || key.type === "selection") return ["choice", [...new Set(letters)].join(as.between)];
    if (key.type === "matching")
      return ["matching", letters.map((letter, i) => `${i + 1}${as.pair}${letter}`).join(as.between)];
  }
  return [as.type, answer.replace(/\s+/g, " ").trim().slice(0, as.most)];
}

/** A number as both data models read it: digits and a point. */
export const decimal = (value: number, places: number): string => value.toFixed(places).replace(/\.?0+$/, "");

/** Hours, minutes and seconds as SCORM 1.2 writes them. */
export function clock(seconds: number): string {
  const hundredths = Math.min(Math.round(seconds * 100), 3_599_999_999); // 9999:59:59.99
  const two = (value: number): string => String(value).padStart(2, "0");
  const whole = Math.floor(hundredths / 100);
  const hours = String(Math.floor(whole / 3600)).padStart(2, "0");
  return `${hours}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}.${two(hundredths % 100)}`;
}

// --- how it is found ---

/** Windows above one another are searched so far. */
const MOST_ABOVE = 50;

/** A window as far as it is searched; those of other origins refuse what is asked of them. */
export type Above = { readonly parent: Above | null; readonly opener?: Above | null };

/** The API of a platform in a window above: around this one first, then around the one that opened it. */
export function found(name: string, from: Above): Api | null {
  return (
    foundAbove(name, from) ??
    openers(from)
      .map((each) => foundAbove(name, each))
      .find(Boolean) ??
    null
  );
}

function foundAbove(name: string, from: Above): Api | null {
  let window: Above | null = from;
  for (let i = 0; window && i < MOST_ABOVE; i += 1) {
    const api = allowed(() => (window as unknown as Record<string, unknown>)[name]);
    if (api !== null && (typeof api === "object" || typeof api === "function")) return api as Api;
    const above: Above | null = allowed(() => window!.parent) ?? null;
    window = above === window ? null : above;
  }
  return null;
}

/** The windows that opened this one, or the outermost around it. */
function openers(from: Above): Above[] {
  const outermost = allowed(() => (from as Above & { top?: Above | null }).top);
  return [from, outermost].flatMap((window) => allowed(() => window?.opener) ?? []);
}

/** What a window of another origin may refuse to tell. */
function allowed<T>(asked: () => T): T | null {
  try {
    return asked() ?? null;
  } catch {
    return null;
  }
}

// --- what is done ---

/** A platform that was found and has begun, with whom it has there. */
export type Platform = Recipient & { readonly learner: string };

/** The platform above a window; null where there is none, or it does not begin. */
export function platform(version: Version, from: Above): Platform | null {
  const model = MODELS[version];
  const api = found(model.api, from);
  if (!api) return null;
  const call = (name: string, ...values: string[]): unknown => called(api, model.prefix + name, values);
  const get = (name: string): string => {
    const value = call("GetValue", name);
    return typeof value === "string" || typeof value === "number" ? String(value) : "";
  };
  const set = (name: string, value: string): boolean => isTrue(call("SetValue", name, value));
  if (!isTrue(call("Initialize", ""))) return null;
  const began = Date.now();
  const takes = !["review", "browse"].includes(get(model.mode));
  let over = false;

  /** The record of answers is the platform's to keep or not: what it does not take is no failure. */
  const record = (given: Given, round: Round): void => {
    const count = Number(get("cmi.interactions._count") || NaN);
    if (count < MOST_RECORDED) for (const [name, value] of interaction(model, count, given, round)) set(name, value);
  };
  const tell = (news: News): boolean => {
    if (!takes || over) return true;
    const { round, score, standing, given } = news;
    const all: Elements = [
      ...model.results(round, score),
      ["cmi.suspend_data", asText(round, standing)],
      ...model.time((Date.now() - began) / 1000),
    ];
    const areSet = all.map(([name, value]) => set(name, value)).every(Boolean);
    if (given) record(given, round);
    return isTrue(call("Commit", "")) && areSet;
  };
  return {
    learner: get(model.learner),
    kept: get("cmi.suspend_data"),
    takes,
    says: message(takes ? "round.sent" : "round.review"),
    tell,
    leave(news) {
      if (over) return;
      tell({ ...news, given: null });
      over = true;
      call(model.finish, ""); // where that fails, all of it was told before
    },
  };
}

/** What a function of the platform returns; null where it throws, or is not there. */
function called(api: Api, name: string, values: readonly string[]): unknown {
  try {
    return api[name]!(...values);
  } catch {
    return null;
  }
}

/** Platforms answer "true", and some of them true. */
const isTrue = (answer: unknown): boolean => String(answer) === "true";
