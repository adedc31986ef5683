// A round: questions in a fixed order, each worth points; its standing; and both as a short text.

import { type Item, makeRandomGenerator } from "../practice/choice.js";

/** A question of a round, its points, and the factor of partial credit. */
export type Asked = { readonly item: Item; readonly points: number; readonly credit: number };

export interface Round {
  readonly name: string;
  readonly seed: string;
  /** How often a question may be answered; 0 means any number of times. */
  readonly tries: number;
  /** The share of all points from which the round is passed; null if there is none. */
  readonly pass: number | null;
  readonly asked: readonly Asked[];
}

/** The state of a question: answers so far, the best share of its points, and whether the solution was shown. */
export type QuestionState = { readonly tries: number; readonly share: number; readonly shown: boolean };

/** The states of a round's questions, in its order. */
export type Standing = readonly QuestionState[];

export interface Score {
  readonly points: number;
  readonly max: number;
  /** Share of all points, from 0 to 1. */
  readonly share: number;
  /** How many questions were answered, or given up for the solution. */
  readonly answered: number;
  /** How many questions have no points left to gain. */
  readonly done: number;
  readonly count: number;
}

const UNTRIED: QuestionState = { tries: 0, share: 0, shown: false };

export const newStanding = (round: Round): Standing => round.asked.map(() => UNTRIED);

/** Return whether a question has no points left to gain. */
export const isDone = ({ tries }: Round, tried: QuestionState): boolean =>
  tried.share === 1 || tried.shown || (tries > 0 && tried.tries >= tries);

/** Return whether the next answer to a question is the last one allowed. */
export const isLastTry = ({ tries }: Round, tried: QuestionState): boolean => tries > 0 && tried.tries + 1 >= tries;

/** Return the standing after an answer; unchanged if the question had no points left to gain. */
export function afterAnswer(round: Round, standing: Standing, place: number, share: number): Standing {
  const tried = standing[place];
  const asked = round.asked[place];
  if (!tried || !asked || isDone(round, tried)) return standing;
  const earned = share >= 1 ? 1 : Math.round(share * asked.credit * SHARE_STEPS) / SHARE_STEPS;
  return standing.with(place, {
    ...tried,
    tries: Math.min(tried.tries + 1, MAX_TRIES),
    share: Math.max(tried.share, earned),
  });
}

/** Return the standing after the solution was shown; the question keeps the points earned before. */
export function afterSolution(standing: Standing, place: number): Standing {
  const tried = standing[place];
  return tried ? standing.with(place, { ...tried, shown: true }) : standing;
}

export function scoreOf(round: Round, standing: Standing): Score {
  const max = sumOf(round.asked.map(({ points }) => points));
  const points = sumOf(round.asked.map((asked, i) => asked.points * (standing[i]?.share ?? 0)));
  return {
    points,
    max,
    share: max > 0 ? points / max : 0,
    answered: standing.filter(({ tries, shown }) => tries > 0 || shown).length,
    done: standing.filter((tried) => isDone(round, tried)).length,
    count: round.asked.length,
  };
}

/** Return a sum without rounding errors of binary fractions. */
const sumOf = (values: readonly number[]): number =>
  Math.round(values.reduce((sum, value) => sum + value, 0) * 1e6) / 1e6;

/** Return the next question that is not done, starting over after the last; null if all are done. */
export function nextPlace(round: Round, standing: Standing, after: number): number | null {
  const count = round.asked.length;
  for (let step = 1; step <= count; step += 1) {
    const place = (after + step + count) % count;
    if (!isDone(round, standing[place] ?? UNTRIED)) return place;
  }
  return null;
}

/** Shares are stored in thousandths. */
const SHARE_STEPS = 1000;
const MAX_TRIES = 63;
const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
/** Digits of a question: 64³ exceeds 1001 shares times 64 numbers of tries times 2 (solution shown or not). */
const DIGITS_EACH = 3;
const FORMAT = "q1";

/**
 * Return the standing as text: "q1.", a fingerprint of the questions, a point, and three characters for each question.
 * It contains only letters, digits, "-", "_" and "."; for 1,000 questions it is shorter than the 4,096 characters that
 * SCORM 1.2 stores.
 */
export function asText(round: Round, standing: Standing): string {
  const codes = standing.map(({ tries, share, shown }) => {
    const number = (Math.round(share * SHARE_STEPS) * (MAX_TRIES + 1) + tries) * 2 + Number(shown);
    return [number >> 12, (number >> 6) & 63, number & 63].map((k) => DIGITS[k]).join("");
  });
  return `${FORMAT}.${fingerprintOf(round)}.${codes.join("").replace(/(?:AAA)+$/, "")}`;
}

/** Return the standing that a text describes; a fresh one if the text is invalid or describes other questions. */
export function fromText(round: Round, text: string): Standing {
  const [format, print, codes = "", ...more] = text.split(".");
  const fits =
    format === FORMAT &&
    print === fingerprintOf(round) &&
    more.length === 0 &&
    codes.length % DIGITS_EACH === 0 &&
    codes.length <= DIGITS_EACH * round.asked.length;
  const states = fits ? round.asked.map((_, i) => triedFrom(codes.slice(i * DIGITS_EACH, (i + 1) * DIGITS_EACH))) : [];
  return fits && states.every((tried) => tried !== null) ? states : newStanding(round);
}

function triedFrom(signs: string): QuestionState | null {
  if (!signs) return UNTRIED;
  const digits = [...signs].map((sign) => DIGITS.indexOf(sign));
  if (digits.some((digit) => digit < 0)) return null;
  const number = digits.reduce((sum, digit) => sum * 64 + digit, 0);
  const tries = (number >> 1) & MAX_TRIES;
  const share = (number >> 7) / SHARE_STEPS;
  return share <= 1 ? { tries, share, shown: (number & 1) === 1 } : null;
}

/** Return a hash of a round's questions and their order. */
function fingerprintOf({ asked }: Round): string {
  const random = makeRandomGenerator(asked.map(({ item }) => `${item.family}/${item.key}/${item.question}`).join(" "));
  return Math.floor(random() * 2 ** 32).toString(36);
}
