// Links to a round of practice, as an instructor makes them: read, explained where they are wrong, and written.

import type { Index } from "../bank.js";
import { ANYTHING, faultOf as faultOfWish, type Item, items, shuffled, type Wish } from "../practice/choice.js";
import type { Topic } from "../practice/topics.js";
import { message, type Message } from "../text/text.js";
import type { Round } from "./round.js";

/** What a link asks for; empty where it says nothing. */
export interface Link {
  readonly embed: boolean;
  readonly lesson: string;
  readonly wish: Wish;
  readonly name: string;
  readonly seed: string;
  readonly tries: number;
  /** The origin of the page that is told the results. */
  readonly origin: string;
  readonly language: string;
}

/** A lesson as a link asks for it: its name, and which questions about which arms are practised in it. */
export type Practised = Omit<Topic, "title">;

export const COUNT = 5;
export const MOST = 100;
export const MOST_TRIES = 20;
const LONGEST = 100;
const KNOWN = [
  ...["embed", "lesson", "arm", "question", "difficulty", "variation", "n", "seed", "name", "tries"],
  ...["origin", "lang"],
];
/** Other names of a parameter. */
const ALSO: Readonly<Record<string, string>> = { family: "arm" };

export const EMPTY: Link = {
  embed: false,
  lesson: "",
  wish: { ...ANYTHING, count: COUNT },
  name: "",
  seed: "",
  tries: 0,
  origin: "",
  language: "",
};

/** Whether an address asks for a round, and not for practice as one likes. */
export function asksForRound(search: string): boolean {
  const found = new URLSearchParams(search);
  return found.has("embed") || found.has("seed");
}

/** What a link asks for, or what is wrong with it by itself. */
export function readLink(search: string, languages: readonly string[]): Link | Message {
  const found = new Map<string, string>();
  for (const [given, value] of new URLSearchParams(search)) {
    const name = ALSO[given] ?? given;
    if (!KNOWN.includes(name)) return message("link.unknown", { name: short(given), known: KNOWN.join(", ") });
    if (found.has(name)) return message("link.twice", { name: given });
    if (value.length > LONGEST) return message("link.long", { name: given, most: LONGEST });
    found.set(name, value);
  }
  const told = (name: string): string => found.get(name) ?? "";
  const count = whole(told("n"), COUNT);
  const tries = whole(told("tries"), 0);
  const difficulty = whole(told("difficulty"), -1);
  const fault =
    [
      !["", "0", "1"].includes(told("embed")) && message("link.embed", { value: told("embed") }),
      !(count >= 1 && count <= MOST) && message("link.count", { value: told("n"), most: MOST }),
      !(tries >= 0 && tries <= MOST_TRIES) && message("link.tries", { value: told("tries"), most: MOST_TRIES }),
      !(difficulty <= 4) && message("practice.unknown-difficulty", { name: told("difficulty") }),
      found.has("origin") && !isOrigin(told("origin")) && message("link.origin", { value: told("origin") }),
      told("lang") !== "" &&
        !languages.includes(told("lang")) &&
        message("link.language", { value: told("lang"), known: languages.join(", ") }),
    ].find((each) => each) || null;
  if (fault) return fault;
  return {
    embed: told("embed") === "1",
    lesson: told("lesson"),
    wish: {
      family: told("arm"),
      question: told("question"),
      difficulty: difficulty < 0 ? null : difficulty,
      variation: told("variation"),
      set: told("seed"),
      count,
    },
    name: told("name").trim(),
    seed: told("seed"),
    tries,
    origin: told("origin"),
    language: told("lang"),
  };
}

/** A link as the end of an address; what is as it is anyhow is left out. */
export function writeLink(link: Link): string {
  const { wish } = link;
  const all: readonly (readonly [string, string])[] = [
    ["embed", link.embed ? "1" : ""],
    ["lesson", link.lesson],
    ["arm", wish.family],
    ["question", wish.question],
    ["difficulty", wish.difficulty === null ? "" : String(wish.difficulty)],
    ["variation", wish.variation],
    ["n", String(wish.count)],
    ["seed", link.seed],
    ["name", link.name],
    ["tries", link.tries > 0 ? String(link.tries) : ""],
    ["origin", link.origin],
    ["lang", link.language],
  ];
  return `?${new URLSearchParams(all.filter(([, value]) => value !== "").map((each) => [...each]))}`;
}

/** Every question that a link may ask; or why there is none. */
export function askedBy(link: Link, index: Index, lessons: readonly Practised[]): readonly Item[] | Message {
  const lesson = lessons.find(({ id }) => id === link.lesson);
  if (link.lesson && !lesson)
    return message("link.lesson", { name: link.lesson, known: lessons.map(({ id }) => id).join(", ") });
  const fault = faultOfWish(index, link.wish, "");
  if (fault) return fault;
  const wished = items(index, link.wish);
  if (!lesson) return wished;
  const inLesson = wished.filter(({ question }) => lesson.questions.includes(question));
  const ofLesson = inLesson.filter(({ family }) => lesson.families.includes(family));
  const found = link.wish.family || ofLesson.length === 0 ? inLesson : ofLesson; // the named arm or the lesson's
  return found.length > 0 ? found : message("link.not-in-lesson", { name: lesson.id });
}

/** The round of a link: the same for the same seed, on every machine; or what is wrong with it. */
export function roundOf(link: Link, index: Index, lessons: readonly Practised[]): Round | Message {
  const all = askedBy(link, index, lessons);
  if (!("length" in all)) return all;
  const { count } = link.wish;
  if (count > all.length) return message("link.too-many", { count, there: all.length });
  const asked = shuffled(all, link.seed)
    .slice(0, count)
    .map((item) => ({ item, points: 1, credit: 1 }));
  return { name: link.name, seed: link.seed, tries: link.tries, pass: null, asked };
}

/** A whole number as a link has it; NaN for what is none. */
function whole(value: string, otherwise: number): number {
  if (value === "") return otherwise;
  return /^\d{1,6}$/.test(value) ? Number(value) : NaN;
}

/** Whether a text is the origin of a web page: https, a host, and a port where it has one of its own. */
export function isOrigin(value: string): boolean {
  try {
    const { origin, protocol } = new URL(value);
    return origin === value && (protocol === "https:" || protocol === "http:");
  } catch {
    return false;
  }
}

const short = (text: string): string => (text.length > 40 ? `${text.slice(0, 40)}…` : text);
