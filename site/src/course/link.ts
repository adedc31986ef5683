// Links to a round of practice, as an instructor makes them: parsed, explained if they are wrong, and written.

import type { Index } from "../bank.js";
import { ANY_WISH, findFault as faultOfWish, type Item, listItems, shuffle, type Wish } from "../practice/choice.js";
import type { Topic } from "../practice/topics.js";
import { resultOrNull } from "../storage.js";
import { message, type Message } from "../text/text.js";
import type { Round } from "./round.js";

/** What a link asks for; a field is empty if the link does not contain it. */
export interface Link {
  /** Whether the page is shown in a frame, without the site's header. */
  readonly embed: boolean;
  /** The id of a lesson. */
  readonly lesson: string;
  readonly wish: Wish;
  /** The title of the round. */
  readonly name: string;
  readonly seed: string;
  /** How often a question may be answered; 0 means any number of times. */
  readonly tries: number;
  /** The origin of the page that receives the results. */
  readonly origin: string;
  /** The code of the page's language. */
  readonly language: string;
}

/** A lesson as a link names it, with its questions and families. */
export type LinkedLesson = Omit<Topic, "title">;

const DEFAULT_COUNT = 5;
export const MAX_QUESTIONS = 100;
export const MAX_TRIES = 20;
const MAX_VALUE_LENGTH = 100;
/** Alternative names of a parameter. */
const SYNONYMS: Readonly<Record<string, string>> = { family: "arm" };

export const EMPTY_LINK: Link = {
  embed: false,
  lesson: "",
  wish: { ...ANY_WISH, count: DEFAULT_COUNT },
  name: "",
  seed: "",
  tries: 0,
  origin: "",
  language: "",
};

/** Return whether an address asks for a round rather than free practice. */
export function asksForRound(search: string): boolean {
  const parameters = new URLSearchParams(search);
  return parameters.has("embed") || parameters.has("seed");
}

/** Return what a link asks for, or what is wrong with the link itself. */
export function parseLink(search: string, languages: readonly string[]): Link | Message {
  const values = new Map<string, string>();
  for (const [typedName, value] of new URLSearchParams(search)) {
    const name = SYNONYMS[typedName] ?? typedName;
    if (!PARAMETER_NAMES.includes(name))
      return message("link.unknown", { name: shorten(typedName), known: PARAMETER_NAMES.join(", ") });
    if (values.has(name)) return message("link.twice", { name: typedName });
    if (value.length > MAX_VALUE_LENGTH) return message("link.long", { name: typedName, limit: MAX_VALUE_LENGTH });
    values.set(name, value);
  }
  const valueOf = (name: string): string => values.get(name) ?? "";
  const count = parseCount(valueOf("n"), DEFAULT_COUNT);
  const tries = parseCount(valueOf("tries"), 0);
  const difficulty = parseCount(valueOf("difficulty"), -1);
  const fault =
    [
      !["", "0", "1"].includes(valueOf("embed")) && message("link.embed", { value: valueOf("embed") }),
      !(count >= 1 && count <= MAX_QUESTIONS) && message("link.count", { value: valueOf("n"), limit: MAX_QUESTIONS }),
      !(tries >= 0 && tries <= MAX_TRIES) && message("link.tries", { value: valueOf("tries"), limit: MAX_TRIES }),
      !(difficulty <= 4) && message("practice.unknown-difficulty", { name: valueOf("difficulty") }),
      values.has("origin") && !isOrigin(valueOf("origin")) && message("link.origin", { value: valueOf("origin") }),
      valueOf("lang") !== "" &&
        !languages.includes(valueOf("lang")) &&
        message("link.language", { value: valueOf("lang"), known: languages.join(", ") }),
    ].find((message) => message) || null;
  if (fault) return fault;
  return {
    embed: valueOf("embed") === "1",
    lesson: valueOf("lesson"),
    wish: {
      family: valueOf("arm"),
      question: valueOf("question"),
      difficulty: difficulty < 0 ? null : difficulty,
      variation: valueOf("variation"),
      set: valueOf("seed"),
      count,
    },
    name: valueOf("name").trim(),
    seed: valueOf("seed"),
    tries,
    origin: valueOf("origin"),
    language: valueOf("lang"),
  };
}

/** Return the parameters of a link in their order; "" stands for a default value. */
const listParameters = ({ wish, ...link }: Link): Readonly<Record<string, string>> => ({
  embed: link.embed ? "1" : "",
  lesson: link.lesson,
  arm: wish.family,
  question: wish.question,
  difficulty: String(wish.difficulty ?? ""),
  variation: wish.variation,
  n: String(wish.count),
  seed: link.seed,
  name: link.name,
  tries: link.tries > 0 ? String(link.tries) : "",
  origin: link.origin,
  lang: link.language,
});

const PARAMETER_NAMES = Object.keys(listParameters(EMPTY_LINK));

/** Write a link as the end of an address, without its default values. */
export const writeLink = (link: Link): string =>
  `?${new URLSearchParams(Object.entries(listParameters(link)).filter(([, value]) => value !== ""))}`;

/** Return every question that a link may ask, or why there is none. */
export function listCandidates(link: Link, index: Index, lessons: readonly LinkedLesson[]): readonly Item[] | Message {
  const lesson = lessons.find(({ id }) => id === link.lesson);
  if (link.lesson && !lesson)
    return message("link.lesson", { name: link.lesson, known: lessons.map(({ id }) => id).join(", ") });
  const fault = faultOfWish(index, link.wish, "");
  if (fault) return fault;
  const matchingItems = listItems(index, link.wish);
  if (!lesson) return matchingItems;
  const itemsInLesson = matchingItems.filter(({ question }) => lesson.questions.includes(question));
  const itemsOnLessonArms = itemsInLesson.filter(({ family }) => lesson.families.includes(family));
  // a link that names an arm is not restricted to the lesson's arms
  const candidates = link.wish.family || itemsOnLessonArms.length === 0 ? itemsInLesson : itemsOnLessonArms;
  return candidates.length > 0 ? candidates : message("link.not-in-lesson", { name: lesson.id });
}

/** Return the round of a link, the same for the same seed on every machine; or what is wrong with the link. */
export function makeRound(link: Link, index: Index, lessons: readonly LinkedLesson[]): Round | Message {
  const candidates = listCandidates(link, index, lessons);
  if (!("length" in candidates)) return candidates;
  const { count } = link.wish;
  if (count > candidates.length) return message("link.too-many", { count, there: candidates.length });
  const questions = shuffle(candidates, link.seed)
    .slice(0, count)
    .map((item) => ({ item, points: 1, credit: 1 }));
  return { name: link.name, seed: link.seed, tries: link.tries, passShare: null, questions };
}

/** Parse a whole number of a link; NaN if it is none, `fallback` if the text is empty. */
function parseCount(value: string, fallback: number): number {
  if (value === "") return fallback;
  return /^\d{1,6}$/.test(value) ? Number(value) : NaN;
}

/** Return whether a text is the origin of a web page: https or http, a host, and possibly a port. */
export function isOrigin(value: string): boolean {
  const url = resultOrNull(() => new URL(value));
  return url?.origin === value && ["https:", "http:"].includes(url.protocol);
}

const shorten = (text: string): string => (text.length > 40 ? `${text.slice(0, 40)}…` : text);
