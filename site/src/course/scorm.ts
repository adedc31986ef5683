// A learning platform that supports SCORM 1.2 or SCORM 2004: how it is found, and what is reported to it.
//
// Everything that matters is set and committed with each answer, because browsers drop requests of a page that is being
// left. A platform that fails does not stop the student.

import type { Part } from "../bank.js";
import { resultOrNull } from "../storage.js";
import { message } from "../text/text.js";
import { isComplete, isPassed, type JudgedAnswer, type Report, type Recipient } from "./recipient.js";
import { writeStanding, type Round, type Score } from "./round.js";

export type Version = "1.2" | "2004";

/** The functions that a platform offers in a window above the package, by name. */
export type Api = Readonly<Record<string, (...values: string[]) => unknown>>;

/** Elements of the data model with their values, in the order in which they are set. */
type Elements = readonly (readonly [name: string, value: string])[];

/** What differs between the versions of SCORM: names of functions and of elements, and what is set. */
interface DataModel {
  /** The name of the object with the platform's functions, and a prefix of their names. */
  readonly api: string;
  readonly prefix: string;
  /** The name, without the prefix, of the function that ends a session. */
  readonly finish: string;
  /** The names of the elements with the student's identifier, and with the mode, such as "review". */
  readonly learner: string;
  readonly mode: string;
  listResults(round: Round, score: Score): Elements;
  listTimeElements(seconds: number): Elements;
  readonly answer: AnswerModel;
  /** The time of an answer. */
  makeTimeElement(now: Date): readonly [name: string, value: string];
}

/** Maximum number of answers that are recorded, for which every platform has room. */
const MAX_RECORDED = 250;

const SCORM12: DataModel = {
  api: "API",
  prefix: "LMS",
  finish: "Finish",
  learner: "cmi.core.student_id",
  mode: "cmi.core.lesson_mode",
  listResults(round, score) {
    const passed = isPassed(round, score);
    const status = passed === null ? "completed" : passed ? "passed" : "failed";
    return [
      ["cmi.core.score.min", "0"], // in percent, the only unit of this version
      ["cmi.core.score.max", "100"],
      ["cmi.core.score.raw", formatDecimal(score.share * 100, 2)],
      ["cmi.core.lesson_status", isComplete(score) ? status : "incomplete"],
    ];
  },
  listTimeElements: (seconds) => [
    ["cmi.core.session_time", formatClock(seconds)],
    ["cmi.core.exit", "suspend"],
  ],
  answer: { type: "fill-in", maxLength: 255, between: ",", pair: ".", name: "student_response", wrong: "wrong" },
  makeTimeElement: (now) => ["time", formatClock(now.getHours() * 3600 + now.getMinutes() * 60 + now.getSeconds())],
};

const SCORM2004: DataModel = {
  api: "API_1484_11",
  prefix: "",
  finish: "Terminate",
  learner: "cmi.learner_id",
  mode: "cmi.mode",
  listResults(round, score) {
    const passed = isComplete(score) ? isPassed(round, score) : null;
    return [
      ["cmi.score.min", "0"],
      ["cmi.score.max", "100"], // also in percent: platforms take "raw" as their grade
      ["cmi.score.raw", formatDecimal(score.share * 100, 2)],
      ["cmi.score.scaled", formatDecimal(score.share, 6)],
      ["cmi.progress_measure", formatDecimal(score.answered / Math.max(score.count, 1), 6)],
      ["cmi.completion_status", isComplete(score) ? "completed" : "incomplete"],
      ["cmi.success_status", passed === null ? "unknown" : passed ? "passed" : "failed"],
    ];
  },
  listTimeElements: (seconds) => [
    ["cmi.session_time", `PT${formatDecimal(seconds, 2)}S`],
    ["cmi.exit", "suspend"],
  ],
  answer: {
    ...{ type: "long-fill-in", maxLength: 4000, between: "[,]", pair: "[.]" },
    ...{ name: "learner_response", wrong: "incorrect" },
  },
  makeTimeElement: (now) => ["timestamp", `${now.toISOString().slice(0, "2026-11-25T22:42:51.12".length)}Z`],
};

const MODELS: Readonly<Record<Version, DataModel>> = { "1.2": SCORM12, "2004": SCORM2004 };

/**
 * How a data model records answers: `type` and `maxLength` of typed answers; the separators `between`
 * letters and inside a `pair` of letters; the `name` of the element; and the result of a `wrong` answer.
 */
type AnswerModel = Readonly<Record<"type" | "between" | "pair" | "name" | "wrong", string>> & {
  readonly maxLength: number;
};

/** Return the elements that record an answer as the n-th interaction. */
function listInteractionElements(
  model: DataModel,
  n: number,
  { place, part, answer, verdict }: JudgedAnswer,
  round: Round,
): Elements {
  const { item, points } = round.questions[place]!;
  const [type, response] = formatResponse(part, answer, model.answer);
  const elements: Elements = [
    ["id", `${item.key}.${item.question}`],
    ["type", type],
    model.makeTimeElement(new Date()),
    ["weighting", formatDecimal(points, 4)],
    [model.answer.name, response],
    ["result", verdict.outcome === "correct" ? "correct" : model.answer.wrong],
  ];
  return elements.map(([name, value]) => [`cmi.interactions.${n}.${name}`, value]);
}

/** Return an answer's type and text for the data model: letters in lower case, formulas as typed. */
function formatResponse({ key }: Part, answer: string, model: AnswerModel): [type: string, response: string] {
  const letters = [...answer.trim().toLowerCase()];
  if (/^[A-H]+$/i.test(answer.trim())) {
    if (key.type === "choice" || key.type === "selection") return ["choice", [...new Set(letters)].join(model.between)];
    if (key.type === "matching")
      return ["matching", letters.map((letter, i) => `${i + 1}${model.pair}${letter}`).join(model.between)];
  }
  return [model.type, answer.replace(/\s+/g, " ").trim().slice(0, model.maxLength)];
}

/** Format a number for both data models: digits and a point. */
export const formatDecimal = (value: number, places: number): string => value.toFixed(places).replace(/\.?0+$/, "");

/** Format hours, minutes and seconds for SCORM 1.2. */
export function formatClock(seconds: number): string {
  const hundredths = Math.min(Math.round(seconds * 100), 3_599_999_999); // 9999:59:59.99
  const inTwoDigits = (value: number): string => String(Math.floor(value)).padStart(2, "0");
  const [hours, minutes, wholeSeconds] = [hundredths / 360_000, (hundredths / 6000) % 60, (hundredths / 100) % 60];
  return `${[hours, minutes, wholeSeconds].map(inTwoDigits).join(":")}.${inTwoDigits(hundredths % 100)}`;
}

/** Maximum number of nested windows that are searched. */
const MAX_PARENTS = 50;

/** A window in the search; windows of other origins throw errors if they are accessed. */
export type WindowNode = { readonly parent: WindowNode | null; readonly opener?: WindowNode | null };

/** Return the API of a platform: in the windows around this one, else around the windows that opened them; or null. */
export function findApi(name: string, startWindow: WindowNode): Api | null {
  const outermost = resultOrNull(() => (startWindow as WindowNode & { top?: WindowNode | null }).top);
  const openers = [startWindow, outermost].flatMap((window) => resultOrNull(() => window?.opener) ?? []);
  return [startWindow, ...openers].map((window) => findAbove(name, window)).find(Boolean) ?? null;
}

function findAbove(name: string, startWindow: WindowNode): Api | null {
  let window: WindowNode | null = startWindow;
  for (let i = 0; window && i < MAX_PARENTS; i += 1) {
    const api = resultOrNull(() => (window as unknown as Record<string, unknown>)[name]);
    if (api !== null && (typeof api === "object" || typeof api === "function")) return api as Api;
    const parentWindow: WindowNode | null = resultOrNull(() => window!.parent);
    window = parentWindow === window ? null : parentWindow;
  }
  return null;
}

/** A platform with a started session, and the student's identifier. */
export type Platform = Recipient & { readonly learner: string };

/** Start a session with the platform above a window; null if there is none, or it refuses. */
export function connect(version: Version, startWindow: WindowNode): Platform | null {
  const model = MODELS[version];
  const api = findApi(model.api, startWindow);
  if (!api) return null;
  const call = (name: string, ...values: string[]): unknown => resultOrNull(() => api[model.prefix + name]!(...values));
  const get = (name: string): string => {
    const value = call("GetValue", name);
    return typeof value === "string" || typeof value === "number" ? String(value) : "";
  };
  const set = (name: string, value: string): boolean => isTrue(call("SetValue", name, value));
  if (!isTrue(call("Initialize", ""))) return null;
  const startTime = Date.now();
  const isAccepting = !["review", "browse"].includes(get(model.mode));
  let hasEnded = false;

  /** Record an answer. A platform need not store it, so failures are ignored. */
  const record = (answer: JudgedAnswer, round: Round): void => {
    const count = Number(get("cmi.interactions._count") || NaN);
    if (count < MAX_RECORDED)
      for (const [name, value] of listInteractionElements(model, count, answer, round)) set(name, value);
  };
  const report = (newReport: Report): boolean => {
    if (!isAccepting || hasEnded) return true;
    const { round, score, standing, lastAnswer } = newReport;
    const elements: Elements = [
      ...model.listResults(round, score),
      ["cmi.suspend_data", writeStanding(round, standing)],
      ...model.listTimeElements((Date.now() - startTime) / 1000),
    ];
    const areSet = elements.map(([name, value]) => set(name, value)).every(Boolean);
    if (lastAnswer) record(lastAnswer, round);
    return isTrue(call("Commit", "")) && areSet;
  };
  return {
    learner: get(model.learner),
    stored: get("cmi.suspend_data"),
    isAccepting,
    destination: message(isAccepting ? "round.sent" : "round.review"),
    report,
    leave(lastReport) {
      if (hasEnded) return;
      report({ ...lastReport, lastAnswer: null });
      hasEnded = true;
      call(model.finish, ""); // if this fails, everything was reported before
    },
  };
}

/** Platforms answer "true"; some answer true. */
const isTrue = (answer: unknown): boolean => String(answer) === "true";
