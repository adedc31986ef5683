// What the server of `qdot serve` sends and takes (../../../grader/serve). Times are ISO texts with a time zone.

import type { AskedProblem } from "../bank.js";
import type { EntryState } from "../practice/feedback.js";
import { getLanguageCode } from "../text/languages.js";
import { session } from "./frame.js";

/** GET work: the student's problems, and everything on the state of the student's work. */
export interface Work {
  readonly title: string;
  /** Who is signed in. Requests that change something name this person, in case another one signs in meanwhile. */
  readonly person: number;
  readonly student: { readonly id: string; readonly name: string };
  /** The time on the server, and the due date of this student. */
  readonly now: string;
  readonly due: string | null;
  /** Whether the work that counts was received after the due date. */
  readonly is_late: boolean;
  /** The rule for late work in a sentence, "" if there is none. */
  readonly late_rule: string;
  /** How many submissions may still count (null: any number), and the rule in a sentence. */
  readonly attempts: { readonly left: number | null; readonly rule: string; readonly tries: number | null };
  readonly takes_notebooks: boolean;
  /** The address of (other) problems to practise on, and that of the assignment if these are for practice. */
  readonly practice: { readonly next: string; readonly home: string } | null;
  readonly score: number | null;
  readonly max_score: number;
  /** Sentences on how the score came about, such as a deduction for late work. */
  readonly notes: readonly string[];
  /** Why nothing can be submitted any more, "" if it can. */
  readonly closed: string;
  readonly problems: readonly { readonly slot: string; readonly problem: AskedProblem }[];
  /** By the names of parts, such as "p1.jacobian": the texts submitted last, those only typed, and the results. */
  readonly answers: Readonly<Record<string, string>>;
  readonly drafts: Readonly<Record<string, string>>;
  readonly results: Readonly<Record<string, Shown>>;
  readonly submissions: readonly Submission[];
}

/** The result of a part, with what the assignment's level of feedback shows. */
export interface Shown {
  readonly outcome: "correct" | "partial" | "wrong" | "missing" | "ungraded";
  readonly points: number | null;
  readonly max_points: number;
  /** HTML. */
  readonly sentences: readonly string[];
  readonly entries: readonly (readonly EntryState[])[] | null;
  /** HTML; and the joints of the configuration in which the answer differs. */
  readonly counterexample: string | null;
  readonly pose: Readonly<Record<string, number>> | null;
  /** The part with the wrong answer from which this answer follows. */
  readonly followed_from: string | null;
  /** The answer as it was understood, as HTML. */
  readonly answer: string | null;
  /** What the staff wrote about it. */
  readonly comment: string;
  /** How many more answers the question takes; null if it takes any number. */
  readonly tries_left: number | null;
}

export interface Submission {
  readonly id: number;
  readonly received: string;
  readonly kind: "answer" | "notebook";
  readonly part: string;
  readonly file_name: string;
  readonly state: "waiting" | "marked" | "failed";
  /** Its place in the queue, from 1. */
  readonly place: number | null;
  readonly score: number | null;
  /** Why it could not be graded, or what was noticed. */
  readonly note: string;
}

/** POST answers. If the verdict takes long, the state is "waiting", and the results come later. */
export type Judged = Pick<Work, "results" | "score" | "is_late" | "attempts" | "notes"> & Pick<Submission, "state">;
/** POST notebooks. */
export type Queued = { readonly submission: number; readonly place: number };

/** GET class/results. */
export interface ClassResults {
  /** Why an older version of the assignment's files is in use, "" if none is. */
  readonly file_error: string;
  /** Changes with every change of the results. */
  readonly version: string | number;
  readonly title: string;
  readonly due: string | null;
  readonly max_score: number;
  readonly parts: readonly ClassPart[];
  readonly students: readonly ClassStudent[];
  readonly groups: readonly Group[];
  readonly to_mark: readonly { readonly student: number; readonly part: string; readonly text: string }[];
  /** Scores that the platform refuses, so that they are not sent any more. */
  readonly refused: readonly { readonly student: number; readonly error: string }[];
  readonly actions: readonly { readonly made: string; readonly by: string; readonly summary: string }[];
}

export type ClassPart = Readonly<Record<"name" | "title", string> & { max_points: number; is_text: boolean }>;

export interface ClassStudent {
  readonly id: number;
  readonly student_id: string;
  readonly name: string;
  /** When the student submitted first and last; null if there is no submission. */
  readonly begun: string | null;
  readonly last: string | null;
  readonly is_late: boolean;
  /** The student's own due date. */
  readonly due: string | null;
  readonly score: number | null;
  readonly marks: Readonly<Record<string, Mark>>;
  /** What was noticed about the submission, in lines. */
  readonly notes: string;
}

export type Mark = Pick<Shown, "outcome" | "points"> & { readonly mistake: string; readonly is_override: boolean };

/** Students with the same wrong answer, a text. */
export interface Group extends Pick<Shown, "outcome" | "points"> {
  readonly group: string;
  readonly part: string;
  readonly mistake: string;
  readonly answer: string;
  readonly students: readonly number[];
}

/** GET class/students/ID: the student's work, with solutions. */
export type StudentWork = Work & {
  readonly solutions: Readonly<Record<string, { readonly solution: string; readonly typed: string }>>;
};

/** POST overrides: points (null: none) and a comment for the answer of a student or of a group; "" is the total. */
export type Override = Target & { readonly points: number | null; readonly comment: string };

/** For whom points are set, and the text that was marked by a person. */
export type Target = ({ readonly student: number } | { readonly group: string }) & {
  readonly part: string;
  readonly answer?: string;
};

/** POST regrade: how many submissions are still to be marked again, what would change, and the token that confirms it. */
export type NewMarks = {
  readonly waiting: number;
  readonly token: string;
  readonly changes: readonly {
    readonly student: number;
    readonly name: string;
    readonly part: string;
    readonly before: number | null;
    readonly after: number | null;
  }[];
};

/** An answer of the server that is not a success, with a sentence for the person at the page. */
export class Refused extends Error {
  constructor(
    readonly status: number,
    sentence: string,
  ) {
    super(sentence);
  }
  override toString = (): string => this.message;
  /** Whether the same request can succeed later. */
  get isTemporary(): boolean {
    return this.status >= 500 || this.status === 429 || this.status === 408 || this.isSignedOut;
  }
  get isSignedOut(): boolean {
    return this.status === 401 || this.status === 403;
  }
}

let person = "";

/** Name the person for whom this page sends requests. */
export const setPerson = (id: number): void => void (person = String(id));

const readToken = (): string => document.querySelector<HTMLMetaElement>('meta[name="csrf"]')?.content ?? "";

/** Send a request to an address below that of the page, and return the JSON, null if there is none. Throws Refused. */
export async function request<T>(method: string, path: string, body?: object, isLast = false): Promise<T> {
  const isForm = body instanceof FormData;
  const response = await fetch(path, {
    method,
    credentials: "same-origin",
    cache: "no-store",
    keepalive: isLast,
    headers: {
      ...(method === "GET" ? {} : { "X-CSRFToken": readToken() }),
      ...(session ? { "X-Session": session } : {}),
      ...(person && method !== "GET" ? { "X-Person": person } : {}),
      ...(body && !isForm ? { "Content-Type": "application/json" } : {}),
    },
    ...(body ? { body: isForm ? body : JSON.stringify(body) } : {}),
  });
  const content: unknown = response.status === 204 ? null : await response.json().catch(() => null);
  if (response.ok && (content !== null || response.status === 204)) return content as T;
  const { error } = (content ?? {}) as { readonly error?: unknown };
  throw new Refused(response.ok ? 502 : response.status, typeof error === "string" ? error : "");
}

export const get = <T>(path: string): Promise<T> => request("GET", path);
export const post = <T>(path: string, body: object): Promise<T> => request("POST", path, body);

/** Return the address of something in the page's language. */
export const inLanguage = (path: string): string => `${path}?lang=${getLanguageCode()}`;

/** Return a new number of a request (128 bits), by which the server recognises a request that arrives twice. */
export const makeRequestId = (): string =>
  [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
