// The bank of problems as Python writes it (exercises/site/record.py, keys.py and build.py).

import type { Level } from "./grade/levels.js";

/** index.json: the contents of the bank. `problems` are the keys of records under bank/FAMILY/. */
export interface Index {
  readonly format: 1;
  /** How much a wrong answer reveals; the bank has solutions only at the last level. */
  readonly feedback: Level;
  readonly families: readonly Family[];
  readonly questions: readonly Question[];
}

export interface Family {
  readonly name: string;
  readonly title: string;
  /** Language of the title, if it is not English. */
  readonly lang?: string;
  readonly source: string;
  readonly problems: readonly Listed[];
}

/** A problem of a family: its file's name, difficulty (0 to 4), variation of its arm, and questions. */
export interface Listed {
  readonly key: string;
  readonly title: string;
  readonly difficulty: number;
  /** A step of exercises/common/variation.py, from "chapter" to "full", or an instructor's own axes. */
  readonly variation: string;
  /** Whether the arm is planar. */
  readonly flat?: true;
  readonly questions: readonly string[];
}

export interface Question {
  readonly name: string;
  readonly title: string;
  readonly lang?: string;
  readonly source: string;
  readonly form: string;
}

export interface Problem {
  /** Language of the texts, if it is not English. */
  readonly lang?: string;
  readonly id: string;
  readonly family: string;
  readonly title: string;
  readonly difficulty: number;
  readonly statement: string;
  readonly figure: string;
  readonly alt: string;
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  readonly pose: NamedPose;
  readonly parts: readonly Part[];
  /** The texts of known mistakes, to which keys refer by index. */
  readonly said: readonly (readonly [name: string, title: string, sentence: string, missing?: string])[];
}

/** Values of joint variables by name (rad, m), and of symbols of the table if they differ from the robot's. */
export type NamedPose = Readonly<Record<string, number>>;

/** A factor of det J that depends on the pose: as HTML, and as it can be typed. */
export type Factor = readonly [html: string, typed: string];

export interface SymbolInfo {
  readonly role: "joint" | "rate" | "velocity" | "force" | "length" | "angle";
  readonly unit: string;
  readonly latex: string;
  readonly value?: number;
}

/** A standard (distal) DH table; its entries are texts with the symbols of `values` and the joint variables. */
export interface Robot {
  readonly name: string;
  readonly title: string;
  readonly joints: readonly Row[];
  readonly base: { readonly position: readonly [string, string, string]; readonly yaw: string; readonly tilt: string };
  readonly point: { readonly frame: number; readonly offset: readonly [string, string, string] };
  readonly task: readonly TaskRow[];
  readonly values: Readonly<Record<string, number>>;
  /** The convention by which the problem describes the arm, if it is not this standard table. */
  readonly convention?: "modified-dh" | "screws";
}

export type Row = { readonly kind: "R" | "P" } & Readonly<Record<"theta" | "d" | "a" | "alpha", string>>;

export type TaskRow = "vx" | "vy" | "vz" | "wx" | "wy" | "wz";

export interface Part {
  readonly name: string;
  readonly kind: string;
  readonly title: string;
  readonly type: "expression" | "matrix" | "singular" | "number" | "direction" | "choice" | "selection" | "matching";
  readonly shape: readonly [number, number] | null;
  readonly points: number;
  readonly prompt: string;
  /** Rates, velocities and forces that the prompt mentions. */
  readonly names: readonly string[];
  /** Names of a vector's entries in an answer, as in {qd1: …, qd2: …}. */
  readonly labels: readonly string[];
  /** Names of a matrix's columns in an answer, as in z0 = …, z1 = …. */
  readonly columns: readonly string[];
  /** LaTeX of the labels of rows and columns; empty if they have none. */
  readonly grid: readonly [rows: readonly string[], columns: readonly string[]];
  readonly figure: string;
  readonly alt: string;
  /** Joint values and lengths given by the question; its figure has its own pose if all joints are among them. */
  readonly pose: NamedPose | null;
  readonly hints: readonly string[];
  readonly options: readonly string[] | null;
  readonly key: Key;
}

export type Key = ValuesKey | NumbersKey | ConfigurationsKey | LettersKey;

/** Correct values of each entry at the points; null if an entry is undefined there. */
export interface ValuesKey {
  readonly type: "values" | "direction";
  readonly symbols: readonly string[];
  readonly points: readonly (readonly number[])[];
  readonly rows: number;
  readonly columns: number;
  readonly right: readonly (readonly (number | null)[])[];
  /** Symbols that no motion changes, and the entries (from 0) that depend on other symbols. */
  readonly constants?: readonly string[];
  readonly moving?: readonly number[];
  /** The factor of each rate, velocity or force in each entry, at the first points. */
  readonly linear?: Readonly<Record<string, readonly (readonly number[])[]>>;
  readonly mistakes: readonly (readonly number[])[];
  /** The same mistake everywhere in the finished formulas, written like `mistakes`. */
  readonly throughout?: readonly (readonly number[])[];
  readonly tolerance?: number | null;
  /** Rates, velocities and forces that the question mentions. */
  readonly mentioned?: readonly string[];
}

export interface NumbersKey {
  readonly type: "numbers";
  readonly units: readonly string[];
  readonly tolerance: number;
  readonly floor: number;
  readonly right: readonly number[];
  readonly mistakes: readonly (readonly number[])[];
  /** Mistakes considered only for a single number with many digits. */
  readonly precise?: readonly (readonly number[])[];
}

/** Configurations on each piece of a singular set: values of `symbols`, which include the joints. */
export interface ConfigurationsKey {
  readonly type: "configurations";
  readonly joints: readonly string[];
  readonly symbols: readonly string[];
  readonly pieces: readonly (readonly (readonly number[])[])[];
  /** How many of the pieces belong to each condition. */
  readonly conditions?: readonly number[];
  readonly mistakes: readonly (readonly [number, ...(readonly (readonly number[])[])[]])[];
}

export interface LettersKey {
  readonly type: "choice" | "selection" | "matching";
  readonly options: number;
  readonly items: number;
  readonly right: readonly number[];
  /** The mistakes behind each wrong option, or behind each letter at a wrong item: indices into `said`. */
  readonly option_mistakes: readonly (readonly number[])[];
}

/** index.LANGUAGE.json: titles of families and questions by name; an instructor's own family has none. */
export interface Titles {
  readonly families: Readonly<Record<string, string>>;
  readonly questions: Readonly<Record<string, string>>;
}

/** FAMILY/KEY.LANGUAGE.json: a problem's texts in another language; parts and `said` in the problem's order. */
export interface Texts {
  readonly title: string;
  readonly statement: string;
  readonly parts: readonly Pick<Part, "name" | "title" | "prompt" | "hints" | "options">[];
  readonly said: Problem["said"];
}

/** FAMILY/KEY.solutions.LANGUAGE.json. */
export type SolvedTexts = { readonly parts: readonly Pick<Solutions["parts"][number], "name" | "solution">[] };

/** FAMILY/KEY.solutions.json, loaded when a solution is requested. */
export interface Solutions {
  /** Language of the solutions, if it is not English. */
  readonly lang?: string;
  readonly id: string;
  /** The factors of det J; empty if J is not square. */
  readonly factors: readonly Factor[];
  readonly parts: readonly {
    readonly name: string;
    readonly solution: string;
    readonly figure: string;
    readonly typed: string;
  }[];
}
