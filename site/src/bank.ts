// The bank of problems as Python writes it (exercises/site/bank.py, record.py and keys.py).
//
// Prompts, options, hints and solutions are HTML, figures are SVG, other texts are plain. Symbols have the names by
// which students type them, such as theta1 or l2.

import type { Level } from "./grade/levels.js";

/** index.json: the contents of the bank. */
export interface Index {
  readonly format: 1;
  /** How much the page reveals about a wrong answer; the bank has solutions only at the last level. */
  readonly feedback: Level;
  readonly families: readonly Family[];
  readonly questions: readonly Question[];
}

interface Family {
  /** The name of the family's folder in the bank. */
  readonly name: string;
  readonly title: string;
  /** Code of the title's language, if it is not English. */
  readonly lang?: string;
  /** The example or the equations of the chapter to which the family belongs. */
  readonly source: string;
  readonly problems: readonly ProblemEntry[];
}

/** A problem in the list of its family. */
export interface ProblemEntry {
  /** The stem of the name of the problem's file, bank/FAMILY/KEY.json; this is not the key of an answer. */
  readonly key: string;
  readonly title: string;
  /** From 0 to 4. */
  readonly difficulty: number;
  /**
   * What may differ from the chapter's arm: a step from "chapter" (nothing) to "full" (everything), or properties that
   * an instructor chose, such as "lengths+base". See exercises/common/variation.py.
   */
  readonly variation: string;
  /** Whether the arm's figure is planar. */
  readonly flat?: true;
  /** Names of the questions about the arm. */
  readonly questions: readonly string[];
}

export interface Question {
  readonly name: string;
  readonly title: string;
  /** Code of the title's language, if it is not English. */
  readonly lang?: string;
  /** Section of the chapter, such as "6.3". */
  readonly source: string;
  /** How a short question is answered, such as "choice", "matching" or "number"; "" for a long question. */
  readonly form: string;
}

/** A problem without the keys of its answers: an arm, and parts, the questions about the arm. */
export interface AskedProblem {
  /** Code of the texts' language, if it is not English. */
  readonly lang?: string;
  readonly id: string;
  readonly family: string;
  readonly title: string;
  /** From 0 to 4. */
  readonly difficulty: number;
  /** The description of the arm, as HTML. */
  readonly statement: string;
  readonly figure: string;
  /** The figure in words. */
  readonly alt: string;
  readonly robot: Robot;
  /** The symbols that answers may contain, by name. */
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  /** The pose in the figure. */
  readonly pose: NamedPose;
  readonly parts: readonly AskedPart[];
}

/** FAMILY/KEY.json: the arm of a problem. */
export interface ProblemArm extends Omit<AskedProblem, "parts"> {
  /** The factors of det J, if students may see them; empty if J is not square, or if det J is too long. */
  readonly factors?: readonly Factor[];
}

/** FAMILY/KEY/QUESTION.json: a question about an arm. */
export interface ProblemQuestion extends Part {
  readonly said: Sentences;
}

/** Sentences on known mistakes by their numbers in answer keys. `missing` lists the names of missing symbols. */
export type Sentences = Readonly<
  Record<number, readonly [name: string, title: string, sentence: string, missing?: string]>
>;

/** An arm with the question that the page shows, and the key by which a browser judges answers. */
export interface Problem extends ProblemArm {
  readonly parts: readonly Part[];
  readonly said: Sentences;
}

/** Values of joint variables by name (rad or m), and of symbols in the table whose values differ from the robot's. */
export type NamedPose = Readonly<Record<string, number>>;

/** A factor of det J that depends on the pose: as HTML, and in the notation in which students type formulas. */
export type Factor = readonly [html: string, typed: string];

export interface SymbolInfo {
  readonly role: "joint" | "rate" | "velocity" | "force" | "length" | "angle";
  /** Such as "rad/s". */
  readonly unit: string;
  readonly latex: string;
  /** The value in this unit, if the problem states it. */
  readonly value?: number;
}

/**
 * An arm as a standard (distal) DH table. All texts in it are formulas as typed, in metres or radians, with the symbols
 * in `values` and, in the rows of the table, the joint variables.
 */
export interface Robot {
  readonly name: string;
  readonly title: string;
  readonly joints: readonly JointRow[];
  /** The pose of frame 0 in the world: its position, and its rotation by `yaw` about z_w, then by `tilt` about x_0. */
  readonly base: { readonly position: readonly [string, string, string]; readonly yaw: string; readonly tilt: string };
  /** The point P whose velocity is considered: the number of a frame (from 0), and the coordinates of P in it. */
  readonly point: { readonly frame: number; readonly offset: readonly [string, string, string] };
  /** The rows of J that count. */
  readonly task: readonly TaskRow[];
  /** Values of the symbolic lengths and angles, by name (m or rad). */
  readonly values: Readonly<Record<string, number>>;
  /** The convention by which the problem describes the arm, if it is not this standard table. */
  readonly convention?: "modified-dh" | "screws";
}

/** A row of the table, for a revolute (R) or prismatic (P) joint. */
export type JointRow = { readonly kind: "R" | "P" } & Readonly<Record<"theta" | "d" | "a" | "alpha", string>>;

/** Return the name of the variable of a joint, given its index (from 0): theta1 or d1. */
export const nameJoint = ({ kind }: Pick<JointRow, "kind">, index: number): string =>
  `${kind === "R" ? "theta" : "d"}${index + 1}`;

/** The rows of J: the components of the linear velocity (v) and of the angular velocity (w), in the world frame. */
export const ROWS = ["vx", "vy", "vz", "wx", "wy", "wz"] as const;
export type TaskRow = (typeof ROWS)[number];

/** A question of a problem, with the form of its answer. */
export interface AskedPart {
  /** The name of the part in its problem. */
  readonly name: string;
  /** The name of the question that it asks (`Question.name`). */
  readonly kind: string;
  readonly title: string;
  /** The type of the answer. */
  readonly type:
    "expression" | "matrix" | "singular" | "number" | "direction" | "choice" | "selection" | "matching" | "text";
  /** The shape of a vector or matrix; null for other answers. */
  readonly shape: readonly [rows: number, columns: number] | null;
  /** The maximum score. */
  readonly points: number;
  readonly prompt: string;
  /** Names of rates, velocities and forces that the prompt mentions. */
  readonly names: readonly string[];
  /** Names of a vector's entries in an answer, as in {qd1: …, qd2: …}. */
  readonly labels: readonly string[];
  /** Names of a matrix's columns in an answer, as in z0 = …, z1 = …. */
  readonly columns: readonly string[];
  /** LaTeX of the labels of rows and columns; empty if they have none. */
  readonly grid: readonly [rows: readonly string[], columns: readonly string[]];
  /** "" if the part has no figure of its own. */
  readonly figure: string;
  /** This figure in words. */
  readonly alt: string;
  /** Joint values and lengths that the prompt gives. If it gives all joints, the part's figure shows this pose. */
  readonly pose: NamedPose | null;
  readonly hints: readonly string[];
  /** The lettered options, from A; null for other answers. */
  readonly options: readonly string[] | null;
  readonly key: AnswerForm;
}

/** A question of a problem, with its answer key. */
export interface Part extends AskedPart {
  readonly key: AnswerKey;
  /** The worked solution, if students may see it. */
  readonly solved?: SolvedPart;
}

/** The worked solution of a question. */
interface SolvedPart {
  readonly solution: string;
  /** Drawings of singular configurations; "" for other answers. */
  readonly figure: string;
  /** The correct answer as a student can type it. */
  readonly typed: string;
}

/** The form of an answer: of its key, what the fields for the answer depend on. "text" is marked by a person. */
export type AnswerForm =
  | { readonly type: "values" | "direction" | "configurations" | "text" }
  | Pick<NumbersKey, "type" | "units">
  | LettersForm;
type LettersForm = Pick<LettersKey, "type" | "items">;

/** Return whether an answer consists of letters of options. */
export const isByLetters = (form: AnswerForm): form is LettersForm =>
  form.type === "choice" || form.type === "selection" || form.type === "matching";

/** The correct answer and known mistakes, as values at some configurations or as letters, without formulas. */
type AnswerKey = ValuesKey | NumbersKey | ConfigurationsKey | LettersKey;

/**
 * A known mistake: its number in `Problem.said`, then numbers of the wrong answer that it leads to. In a NumbersKey they
 * are the answer itself. In a ValuesKey they are fingerprints (keys.py) of the answer at the first points, or, if the
 * key has a tolerance, the components of a unit vector.
 */
export type KnownMistake = readonly number[];

/** Return the number, in `Problem.said`, of the first mistake whose numbers match; undefined if there is none. */
export const findMistakeIndex = (
  mistakes: readonly KnownMistake[],
  matches: (numbers: readonly number[]) => boolean,
): number | undefined => mistakes.find(([, ...numbers]) => matches(numbers))?.[0];

/** The key of formulas, or of a direction: a vector whose length does not count. Entries are numbered row by row. */
export interface ValuesKey {
  readonly type: "values" | "direction";
  /** Names of the symbols that have values at the points. */
  readonly symbols: readonly string[];
  /** The configurations at which answers are evaluated; each lists the values of `symbols`. */
  readonly points: readonly (readonly number[])[];
  /** The number of the answer's rows and columns. */
  readonly rows: number;
  readonly columns: number;
  /** Correct values of each entry at the points; null if an entry is undefined there. */
  readonly right: readonly (readonly (number | null)[])[];
  /** Names of symbols that no motion changes, such as lengths. */
  readonly constants?: readonly string[];
  /** Indices (from 0) of the entries that depend on symbols other than these constants. */
  readonly moving?: readonly number[];
  /** By the name of a rate, velocity or force: its coefficient in each entry, at each of the first points. */
  readonly linear?: Readonly<Record<string, readonly (readonly number[])[]>>;
  readonly mistakes: readonly KnownMistake[];
  /** Mistakes made everywhere in the finished formulas, such as leaving out all lengths. */
  readonly throughout?: readonly KnownMistake[];
  /** Relative tolerance of a numeric direction; null for a direction in formulas. */
  readonly tolerance?: number | null;
  /** Names of rates, velocities and forces that the prompt mentions. The page copies them from `Part.names`. */
  readonly mentioned?: readonly string[];
}

/** The key of one or several numbers. */
export interface NumbersKey {
  readonly type: "numbers";
  /** The unit of each number; "" if it has none. */
  readonly units: readonly string[];
  /** Relative tolerance. */
  readonly tolerance: number;
  /** Absolute tolerance, which applies to numbers near 0. */
  readonly floor: number;
  /** The absolute tolerance of each number, if they differ; `floor` is the smallest of them. */
  readonly floors?: readonly number[];
  /** The correct numbers, in SI units. */
  readonly right: readonly number[];
  readonly mistakes: readonly KnownMistake[];
  /** Mistakes considered only if the answer is a single number with many digits. */
  readonly precise?: readonly KnownMistake[];
}

/** The key of a set of configurations. It consists of pieces, from each of which some configurations are sampled. */
export interface ConfigurationsKey {
  readonly type: "configurations";
  /** Names of the joint variables. */
  readonly joints: readonly string[];
  /** Names of the symbols that have values in each configuration; they include the joints. */
  readonly symbols: readonly string[];
  /** Of each piece, some configurations: the values of `symbols`. */
  readonly pieces: readonly (readonly (readonly number[])[])[];
  /** How many of the pieces belong to each condition, in their order. */
  readonly conditions?: readonly number[];
  /** The formulas that are zero in the set; without them, it is the set of singular configurations. */
  readonly zeros?: readonly string[];
  /** Always empty, because the page itself finds mistakes in conditions (grade/set-slips.ts). */
  readonly mistakes: readonly [];
}

/** The key of an answer by letters. Options and items are counted from 0. */
export interface LettersKey {
  readonly type: "choice" | "selection" | "matching";
  /** The number of options. */
  readonly options: number;
  /** The number of items to match with options; 0 unless the type is "matching". */
  readonly items: number;
  /** The correct options; for "matching", the correct option of each item. */
  readonly right: readonly number[];
  /** For each option, the mistakes that explain why it was chosen wrongly: numbers in `Problem.said`. */
  readonly option_mistakes: readonly (readonly number[])[];
}

/** index.LANGUAGE.json: titles of families and questions, by name. An instructor's own family has none. */
export interface TranslatedTitles {
  readonly families: Readonly<Record<string, string>>;
  readonly questions: Readonly<Record<string, string>>;
}

/** FAMILY/KEY.LANGUAGE.json: the texts about an arm in another language. */
export type TranslatedArm = Pick<ProblemArm, "title" | "statement">;

/** FAMILY/KEY/QUESTION.LANGUAGE.json: the texts of a question in another language. */
export interface TranslatedQuestion extends Pick<
  ProblemQuestion,
  "name" | "title" | "prompt" | "hints" | "options" | "said"
> {
  readonly solved?: Pick<SolvedPart, "solution">;
}
