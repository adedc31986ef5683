// A round: questions in a fixed order, each worth points, the standing in them, and both as a short text.

import { type Item, numbers } from "../practice/choice.js";

/** A question of a round: what it is worth, and by what an answer is multiplied that is right in part. */
export type Asked = { readonly item: Item; readonly points: number; readonly credit: number };

export interface Round {
  readonly name: string;
  readonly seed: string;
  /** How often a question may be answered; 0 is as often as one likes. */
  readonly tries: number;
  /** From what share of the points on it is passed; null where nothing is said of that. */
  readonly pass: number | null;
  readonly asked: readonly Asked[];
}

/** The state of a question: answers so far, the best share of its points, and whether its solution was seen. */
export type Tried = { readonly tries: number; readonly share: number; readonly shown: boolean };

/** How one stands in each question of a round, in its order. */
export type Standing = readonly Tried[];

export interface Score {
  readonly points: number;
  readonly max: number;
  /** Of all points, from 0 to 1. */
  readonly share: number;
  /** How many questions were answered, or given up for their solution. */
  readonly answered: number;
  /** How many have nothing left to gain. */
  readonly done: number;
  readonly count: number;
}

const FRESH: Tried = { tries: 0, share: 0, shown: false };

export const begun = (round: Round): Standing => round.asked.map(() => FRESH);

/** Whether there is nothing left to gain in a question. */
export const isDone = ({ tries }: Round, tried: Tried): boolean =>
  tried.share === 1 || tried.shown || (tries > 0 && tried.tries >= tries);

/** Whether an answer to a question ends it, whatever becomes of it. */
export const isLastTry = ({ tries }: Round, tried: Tried): boolean => tries > 0 && tried.tries + 1 >= tries;

/** How one stands after an answer to a question; where nothing was left to gain, as before. */
export function answered(round: Round, standing: Standing, place: number, share: number): Standing {
  const tried = standing[place];
  const asked = round.asked[place];
  if (!tried || !asked || isDone(round, tried)) return standing;
  const earned = share >= 1 ? 1 : Math.round(share * asked.credit * MILLE) / MILLE;
  return standing.with(place, {
    ...tried,
    tries: Math.min(tried.tries + 1, MOST_TRIES),
    share: Math.max(tried.share, earned),
  });
}

/** How one stands after the solution of a question was seen: it earns what it has by then. */
export function shownIn(standing: Standing, place: number): Standing {
  const tried = standing[place];
  return tried ? standing.with(place, { ...tried, shown: true }) : standing;
}

export function scoreOf(round: Round, standing: Standing): Score {
  const max = total(round.asked.map(({ points }) => points));
  const points = total(round.asked.map((asked, i) => asked.points * (standing[i]?.share ?? 0)));
  return {
    points,
    max,
    share: max > 0 ? points / max : 0,
    answered: standing.filter(({ tries, shown }) => tries > 0 || shown).length,
    done: standing.filter((tried) => isDone(round, tried)).length,
    count: round.asked.length,
  };
}

/** A sum without the dust of binary fractions. */
const total = (values: readonly number[]): number =>
  Math.round(values.reduce((sum, value) => sum + value, 0) * 1e6) / 1e6;

/** The next question that is not done, starting over after the last; null if all are done. */
export function nextPlace(round: Round, standing: Standing, after: number): number | null {
  const count = round.asked.length;
  for (let step = 1; step <= count; step += 1) {
    const place = (after + step + count) % count;
    if (!isDone(round, standing[place] ?? FRESH)) return place;
  }
  return null;
}

// --- what is kept ---

/** Shares are kept in thousandths. */
const MILLE = 1000;
const MOST_TRIES = 63;
const SIGNS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
/** Signs of a question: 64³ is more than the 1001 shares times 64 tries times whether its solution was seen. */
const EACH = 3;
const FORMAT = "q1";

/**
 * How one stands, as text: "q1." with what says which questions they are, a point, and three signs for each question.
 * It has letters, digits, "-", "_" and "." only, and of 1,000 questions less than the 4,096 signs that SCORM 1.2
 * keeps.
 */
export function asText(round: Round, standing: Standing): string {
  const each = standing.map(({ tries, share, shown }) => {
    const number = (Math.round(share * MILLE) * (MOST_TRIES + 1) + tries) * 2 + Number(shown);
    return [number >> 12, (number >> 6) & 63, number & 63].map((k) => SIGNS[k]).join("");
  });
  return `${FORMAT}.${printOf(round)}.${each.join("").replace(/(?:AAA)+$/, "")}`;
}

/** How one stands by such a text; as at the beginning, where it is none, or of other questions. */
export function fromText(round: Round, text: string): Standing {
  const [format, print, each = "", ...more] = text.split(".");
  const fits =
    format === FORMAT &&
    print === printOf(round) &&
    more.length === 0 &&
    each.length % EACH === 0 &&
    each.length <= EACH * round.asked.length;
  const found = fits ? round.asked.map((_, i) => triedFrom(each.slice(i * EACH, (i + 1) * EACH))) : [];
  return fits && found.every((tried) => tried !== null) ? found : begun(round);
}

function triedFrom(signs: string): Tried | null {
  if (!signs) return FRESH;
  const digits = [...signs].map((sign) => SIGNS.indexOf(sign));
  if (digits.some((digit) => digit < 0)) return null;
  const number = digits.reduce((sum, digit) => sum * 64 + digit, 0);
  const tries = (number >> 1) & MOST_TRIES;
  const share = (number >> 7) / MILLE;
  return share <= 1 ? { tries, share, shown: (number & 1) === 1 } : null;
}

/** What says which questions a round has, in which order: another set keeps nothing of this one. */
function printOf({ asked }: Round): string {
  const random = numbers(asked.map(({ item }) => `${item.family}/${item.key}/${item.question}`).join(" "));
  return Math.floor(random() * 2 ** 32).toString(36);
}
