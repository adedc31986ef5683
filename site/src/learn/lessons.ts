// The eight lessons: ideas to try on the arm, and goals that the page recognises. Lengths in metres, rates in rad/s.
// The questions that each lesson practises are in practice/topics.ts.

import { kindOfSingularity } from "../arm/descriptions.js";
import { pStar } from "../arm/model.js";
import { verdictOf } from "../arm/weld.js";
import type { Layers } from "../arm/marks.js";
import type { Pane, Stage } from "../arm/stage.js";
import { dot, norm, type Vec3 } from "../arm/vector.js";
import { type Topic, topicOf } from "../practice/topics.js";
import type { TextKey } from "../text/text.js";
import type { Tool } from "./tools.js";

/** What a goal is checked against: the stage, the joint rates (if a tool sets them), and the velocity of P. */
export type GoalState = { readonly stage: Stage; readonly rates: readonly number[]; readonly velocity: Vec3 };

export type Goal = { readonly text: TextKey; readonly reached: (state: GoalState) => boolean };

export interface Lesson extends Topic {
  /** The lessons it builds on; all of them come before it. */
  readonly needs: readonly string[];
  /** Its place on the map of lessons: the layer, and the distance from the layer's middle, so that no lines cross. */
  readonly at: readonly [layer: number, across: number];
  readonly idea: readonly TextKey[];
  readonly arm: "plain" | "elbow";
  readonly tool: Tool | null;
  readonly layers: Partial<Layers>;
  readonly pane: Pane | null;
  readonly goals: readonly Goal[];
}

/** A lesson as it is written below: its id names its texts; by default the arm is plain and there is no tool. */
type LessonData = Pick<Lesson, "needs" | "at" | "layers" | "pane"> &
  Partial<Pick<Lesson, "arm" | "tool">> & {
    readonly id: "rates" | "columns" | "differentiation" | "propagation" | "inverse" | "singular" | "kinds" | "path";
    readonly goals: readonly Goal["reached"][];
  };

/** Return an entry of J; rows and columns count from 1. */
const entryOf = ({ state }: Stage, row: number, column: number): number => state.counted[row - 1]![column - 1]!;
const columnOf = (stage: Stage, k: number): Vec3 =>
  [0, 1, 2].map((row) => stage.state.jacobian[row]![k - 1]!) as unknown as Vec3;
/** Return the cosine of the angle between two vectors; 0 if one of them vanishes. */
const cosine = (a: Vec3, b: Vec3): number => dot(a, b) / (norm(a) * norm(b) || Infinity);
const UP: Vec3 = [0, 1, 0];
const theta2 = ({ pose }: Stage): number => Math.abs(pose[1]!);
const DEGREE = Math.PI / 180;

const LESSON_DATA: readonly LessonData[] = [
  {
    id: "rates",
    needs: [],
    at: [0, 0],
    tool: "rates",
    layers: { columns: false, ellipse: false },
    pane: "joints",
    goals: [
      ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.3,
      ({ velocity }) => norm(velocity) > 0.05 && cosine(velocity, UP) > 0.995,
      ({ velocity, stage }) => norm(velocity) > 0.05 && cosine(velocity, stage.state.point) < -0.99,
    ],
  },
  {
    id: "columns",
    needs: ["rates"],
    at: [1, 0],
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      ({ stage }) => cosine(columnOf(stage, 2), UP) > 0.998,
      ({ stage }) => norm(columnOf(stage, 1)) < 0.11 * stage.reach,
      ({ stage }) => Math.abs(cosine(columnOf(stage, 1), columnOf(stage, 2))) > 0.999,
    ],
  },
  {
    id: "differentiation",
    needs: ["columns"],
    at: [2, -0.5],
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      ({ stage }) => Math.abs(entryOf(stage, 1, 1)) < 0.02 * stage.reach,
      ({ stage }) =>
        Math.abs(entryOf(stage, 2, 2)) < 0.02 * stage.reach && Math.abs(entryOf(stage, 2, 1)) > 0.1 * stage.reach,
    ],
  },
  {
    id: "propagation",
    needs: ["columns"],
    at: [2, 0.5],
    layers: { ellipse: false, vectors: true },
    pane: "jacobian",
    goals: [
      ({ stage }) => Math.abs(cosine(...firstMomentArms(stage))) < 0.03,
      ({ stage }) => cosine(...firstMomentArms(stage)) > 0.9995,
    ],
  },
  {
    id: "inverse",
    needs: ["differentiation", "propagation"],
    at: [3, 0.5],
    tool: "wanted",
    layers: { ellipse: false },
    pane: "joints",
    goals: [
      ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.05,
      ({ rates }) => Math.max(...rates.map(Math.abs)) > 10,
    ],
  },
  {
    id: "singular",
    needs: ["differentiation"],
    at: [3, -0.5],
    layers: {},
    pane: "map",
    goals: [
      ({ stage }) => theta2(stage) < 2 * DEGREE,
      ({ stage }) => theta2(stage) > 178 * DEGREE,
      ({ stage }) => Math.abs(Math.sin(theta2(stage))) > 0.995,
    ],
  },
  {
    id: "kinds",
    needs: ["singular"],
    at: [4, -0.5],
    arm: "elbow",
    layers: { frames: false },
    pane: "map",
    goals: [
      ({ stage }) => kindOfSingularity(stage.arm, stage.settled) === "boundary",
      ({ stage }) => kindOfSingularity(stage.arm, stage.settled) === "internal",
    ],
  },
  {
    id: "path",
    needs: ["inverse", "singular"],
    at: [4, 0.5],
    layers: { frames: false },
    pane: "weld",
    goals: [
      ({ stage: { welding } }) =>
        welding !== null && welding.place > 0.95 * (welding.journey.stations.at(-1)!.s || Infinity),
      ({ stage }) => verdictOf(stage.arm, stage.welding) === "exceeds",
      ({ stage }) => verdictOf(stage.arm, stage.welding) === "keeps",
    ],
  },
];

export const LESSONS: readonly Lesson[] = LESSON_DATA.map(({ id, goals, ...lesson }) => ({
  ...topicOf(id),
  idea: [`lesson.${id}.idea-1`, `lesson.${id}.idea-2`],
  arm: "plain",
  tool: null,
  ...lesson,
  goals: goals.map((reached, i) => ({ text: `lesson.${id}.goal-${i + 1}` as TextKey, reached })),
}));

/** Return p*_0 and p*_1. */
function firstMomentArms({ arm, state }: Stage): [Vec3, Vec3] {
  const [first, second] = pStar(arm, state);
  return [first!, second!];
}
