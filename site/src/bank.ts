// The bank of problems as Python writes it (exercises/site/record.py, keys.py and build.py), and how it is loaded.

import type { Level } from "./grade/levels.js";

/** index.json: what there is to choose from. `problems` are the keys of records under bank/FAMILY/. */
export interface Index {
  readonly format: 1;
  /** How much is told of a wrong answer; the bank has solutions at the last level only. */
  readonly feedback: Level;
  readonly families: readonly Family[];
  readonly questions: readonly Question[];
}

export interface Family {
  readonly name: string;
  readonly title: string;
  /** Of the title, where it is not English. */
  readonly lang?: string;
  readonly source: string;
  readonly problems: readonly Listed[];
}

/** A problem of a family: its file's name, its difficulty (0 to 4), how far its arm varies, and what is asked. */
export interface Listed {
  readonly key: string;
  readonly title: string;
  readonly difficulty: number;
  /** A step of exercises/common/variation.py, from "chapter" to "full", or axes of an instructor's own. */
  readonly variation: string;
  /** Of an arm that never leaves a plane. */
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
  /** Of its texts, where they are not English. */
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
  readonly said: readonly (readonly [name: string, title: string, sentence: string, missing?: string])[];
}

/** Values of joint variables by name (rad, m), and of letters of the table if they differ from the robot's. */
export type NamedPose = Readonly<Record<string, number>>;

/** A factor of det J that a pose changes: as HTML, and as it can be typed. */
export type Factor = readonly [html: string, typed: string];

export interface SymbolInfo {
  readonly role: "joint" | "rate" | "velocity" | "force" | "length" | "angle";
  readonly unit: string;
  readonly latex: string;
  readonly value?: number;
}

/** A standard (distal) DH table; entries are text with the letters of `values` and the joint variables in it. */
export interface Robot {
  readonly name: string;
  readonly title: string;
  readonly joints: readonly Row[];
  readonly base: { readonly position: readonly [string, string, string]; readonly yaw: string; readonly tilt: string };
  readonly point: { readonly frame: number; readonly offset: readonly [string, string, string] };
  readonly task: readonly TaskRow[];
  readonly values: Readonly<Record<string, number>>;
  /** How the arm is told to people, where that is not by this standard table. */
  readonly convention?: "modified-dh" | "screws";
  /** The order of its twists, where it is told by its axes and that is not (omega, v). */
  readonly twist_order?: "v-omega";
}

export interface Row {
  readonly kind: "R" | "P";
  readonly theta: string;
  readonly d: string;
  readonly a: string;
  readonly alpha: string;
}

export type TaskRow = "vx" | "vy" | "vz" | "wx" | "wy" | "wz";

export interface Part {
  readonly name: string;
  readonly kind: string;
  readonly title: string;
  readonly type: "expression" | "matrix" | "singular" | "number" | "direction" | "choice" | "selection" | "matching";
  readonly shape: readonly [number, number] | null;
  readonly points: number;
  readonly prompt: string;
  /** Rates, velocities and forces of which the prompt speaks. */
  readonly names: readonly string[];
  /** Under which the entries of a vector may be given, as in {qd1: …, qd2: …}. */
  readonly labels: readonly string[];
  /** Under which the columns of a matrix may be given, as in z0 = …, z1 = …. */
  readonly columns: readonly string[];
  /** LaTeX of what its rows and its columns belong to; none where nothing is told of them. */
  readonly grid: readonly [rows: readonly string[], columns: readonly string[]];
  readonly figure: string;
  readonly alt: string;
  /** The joint values and lengths that it gives; its figure has a pose of its own if all joints are among them. */
  readonly pose: NamedPose | null;
  readonly hints: readonly string[];
  readonly options: readonly string[] | null;
  readonly key: Key;
}

export type Key = ValuesKey | NumbersKey | ConfigurationsKey | LettersKey;

/** Right values of each entry at the points; null where it is not defined there. */
export interface ValuesKey {
  readonly type: "values" | "direction";
  readonly symbols: readonly string[];
  readonly points: readonly (readonly number[])[];
  readonly rows: number;
  readonly columns: number;
  readonly right: readonly (readonly (number | null)[])[];
  /** Symbols that no motion changes, and the entries that depend on others, counted from 0. */
  readonly constants?: readonly string[];
  readonly moving?: readonly number[];
  /** What rates, velocities and forces are multiplied by in each entry, at the first points. */
  readonly linear?: Readonly<Record<string, readonly (readonly number[])[]>>;
  readonly mistakes: readonly (readonly number[])[];
  /** The same slip everywhere in the finished formulas, as mistakes are told. */
  readonly throughout?: readonly (readonly number[])[];
  readonly tolerance?: number | null;
  /** Rates, velocities and forces of which the question speaks. */
  readonly spoken?: readonly string[];
}

export interface NumbersKey {
  readonly type: "numbers";
  readonly units: readonly string[];
  readonly tolerance: number;
  readonly floor: number;
  readonly right: readonly number[];
  readonly mistakes: readonly (readonly number[])[];
  /** What else is looked for behind a single number of many digits. */
  readonly precise?: readonly (readonly number[])[];
}

/** Poses on each piece of a singular set: values of `symbols`, the joints among them. */
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
  readonly told: readonly (readonly number[])[];
}

/** index.LANGUAGE.json: titles of families and questions by name; a family of an instructor's own has none. */
export interface Titles {
  readonly families: Readonly<Record<string, string>>;
  readonly questions: Readonly<Record<string, string>>;
}

/** FAMILY/KEY.LANGUAGE.json: what a problem says, in another language; parts and `said` in the problem's order. */
export interface Texts {
  readonly title: string;
  readonly statement: string;
  readonly parts: readonly Pick<Part, "name" | "title" | "prompt" | "hints" | "options">[];
  readonly said: Problem["said"];
}

/** FAMILY/KEY.solutions.LANGUAGE.json. */
export type SolvedTexts = { readonly parts: readonly Pick<Solutions["parts"][number], "name" | "solution">[] };

/** FAMILY/KEY.solutions.json, loaded when a solution is asked for. */
export interface Solutions {
  /** Of the solutions, where they are not English. */
  readonly lang?: string;
  readonly id: string;
  /** Of det J; empty where J is not square. */
  readonly factors: readonly Factor[];
  readonly parts: readonly {
    readonly name: string;
    readonly solution: string;
    readonly figure: string;
    readonly typed: string;
  }[];
}
