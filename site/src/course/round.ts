// A round: questions in a fixed order, each worth points; its standing; and both as a short text.

import { type Item, makeRandomGenerator } from "../practice/choice.js";

/** A question of a round: its maximum points, and the factor (0 to 1) by which partial credit is multiplied. */
type RoundQuestion = { readonly item: Item; readonly points: number; readonly credit: number };

export interface Round {
  /** A title from the instructor, or "". */
  readonly name: string;
  /** The seed that determines the questions; "" for a package. */
  readonly seed: string;
  /** How often a question may be answered; 0 means any number of times. */
  readonly tries: number;
  /** The share of all points from which the round is passed; null if there is none. */
  readonly passShare: number | null;
  readonly questions: readonly RoundQuestion[];
}

/** The state of a question: answers so far, the best share (0 to 1) of its points, whether the solution was shown. */
export type QuestionState = { readonly tries: number; readonly share: number; readonly shown: boolean };

/** The states of a round's questions, in their order. */
export type Standing = readonly QuestionState[];

export interface Score {
  readonly points: number;
  /** The maximum of `points`. */
  readonly max: number;
  /** Share of all points, from 0 to 1. */
  readonly share: number;
  /** How many questions were answered, or given up for the solution. */
  readonly answered: number;
  /** How many questions have no points left to gain. */
  readonly done: number;
  /** How many questions the round has. */
  readonly count: number;
}

const UNTRIED: QuestionState = { tries: 0, share: 0, shown: false };

export const makeNewStanding = (round: Round): Standing => round.questions.map(() => UNTRIED);

/** Return whether a question has no points left to gain. */
export const isDone = ({ tries }: Round, state: QuestionState): boolean =>
  state.share === 1 || state.shown || (tries > 0 && state.tries >= tries);

/** Return whether the next answer to a question is the last one allowed. */
export const isLastTry = ({ tries }: Round, state: QuestionState): boolean => tries > 0 && state.tries + 1 >= tries;

/** Return the standing after an answer with this share (0 to 1); unchanged if no points were left to gain. */
export function addAnswer(round: Round, standing: Standing, place: number, share: number): Standing {
  const state = standing[place];
  const question = round.questions[place];
  if (!state || !question || isDone(round, state)) return standing;
  const earnedShare = share >= 1 ? 1 : Math.round(share * question.credit * SHARE_STEPS) / SHARE_STEPS;
  return standing.with(place, {
    ...state,
    tries: Math.min(state.tries + 1, MAX_TRIES),
    share: Math.max(state.share, earnedShare),
  });
}

/** Return the standing after the solution was shown; the question keeps the points earned before. */
export function closeQuestion(standing: Standing, place: number): Standing {
  const state = standing[place];
  return state ? standing.with(place, { ...state, shown: true }) : standing;
}

export function computeScore(round: Round, standing: Standing): Score {
  const max = addExactly(round.questions.map(({ points }) => points));
  const points = addExactly(round.questions.map((question, i) => question.points * (standing[i]?.share ?? 0)));
  return {
    points,
    max,
    share: max > 0 ? points / max : 0,
    answered: standing.filter(({ tries, shown }) => tries > 0 || shown).length,
    done: standing.filter((state) => isDone(round, state)).length,
    count: round.questions.length,
  };
}

/** Return a sum, rounded to six decimals, so that 0.1 + 0.2 is 0.3. */
const addExactly = (values: readonly number[]): number =>
  Math.round(values.reduce((sum, value) => sum + value, 0) * 1e6) / 1e6;

/** Return the next question that is not done, starting over after the last; null if all are done. */
export function findNextPlace(round: Round, standing: Standing, lastPlace: number): number | null {
  const count = round.questions.length;
  for (let step = 1; step <= count; step += 1) {
    const place = (lastPlace + step + count) % count;
    if (!isDone(round, standing[place] ?? UNTRIED)) return place;
  }
  return null;
}

/** Shares are stored in thousandths. */
const SHARE_STEPS = 1000;
/** Larger numbers of answers are stored as this one. */
const MAX_TRIES = 63;
const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
/** Digits of a question: 64³ exceeds 1001 shares times 64 numbers of tries times 2 (solution shown or not). */
const DIGITS_PER_QUESTION = 3;
const FORMAT = "q1";

/**
 * Return the standing as text: "q1.", a fingerprint of the questions, a point, and three characters for each question.
 * It contains only letters, digits, "-", "_" and "."; for 1,000 questions it is shorter than the 4,096 characters that
 * SCORM 1.2 stores.
 */
export function writeStanding(round: Round, standing: Standing): string {
  const codes = standing.map(({ tries, share, shown }) => {
    const number = (Math.round(share * SHARE_STEPS) * (MAX_TRIES + 1) + tries) * 2 + Number(shown);
    return [number >> 12, (number >> 6) & 63, number & 63].map((k) => DIGITS[k]).join("");
  });
  return `${FORMAT}.${computeFingerprint(round)}.${codes.join("").replace(/(?:AAA)+$/, "")}`;
}

/** Return the standing that a text describes; a fresh one if the text is invalid or describes other questions. */
export function parseStanding(round: Round, text: string): Standing {
  const [format, fingerprint, codes = "", ...extraParts] = text.split(".");
  const isValid =
    format === FORMAT &&
    fingerprint === computeFingerprint(round) &&
    extraParts.length === 0 &&
    codes.length % DIGITS_PER_QUESTION === 0 &&
    codes.length <= DIGITS_PER_QUESTION * round.questions.length;
  const states = isValid
    ? round.questions.map((_, i) =>
        parseQuestionState(codes.slice(i * DIGITS_PER_QUESTION, (i + 1) * DIGITS_PER_QUESTION)),
      )
    : [];
  return isValid && states.every((state) => state !== null) ? states : makeNewStanding(round);
}

function parseQuestionState(code: string): QuestionState | null {
  if (!code) return UNTRIED;
  const digits = [...code].map((sign) => DIGITS.indexOf(sign));
  if (digits.some((digit) => digit < 0)) return null;
  const number = digits.reduce((sum, digit) => sum * 64 + digit, 0);
  const tries = (number >> 1) & MAX_TRIES;
  const share = (number >> 7) / SHARE_STEPS;
  return share <= 1 ? { tries, share, shown: (number & 1) === 1 } : null;
}

/** Return a hash of a round's questions and their order. */
function computeFingerprint({ questions }: Round): string {
  const random = makeRandomGenerator(
    questions.map(({ item }) => `${item.family}/${item.key}/${item.question}`).join(" "),
  );
  return Math.floor(random() * 2 ** 32).toString(36);
}
