// The eight lessons: ideas to try on the arm, and goals that the page recognises. Lengths in metres, rates in rad/s.
// The questions that each lesson practises are in practice/topics.ts.

import { kindOfSingularity } from "../arm/descriptions.js";
import { pStar } from "../arm/model.js";
import { classifyJourney } from "../arm/weld.js";
import type { Layers } from "../arm/marks.js";
import type { Pane, Stage } from "../arm/stage.js";
import { dot, norm, type Vec3 } from "../arm/vector.js";
import { type Topic, getTopic } from "../practice/topics.js";
import type { TextKey } from "../text/text.js";
import type { Tool } from "./tools.js";

/** What goals are checked against: the stage, the joint rates that a tool sets (if there is one), the velocity of P. */
export type GoalState = { readonly stage: Stage; readonly rates: readonly number[]; readonly velocity: Vec3 };

type Goal = { readonly text: TextKey; readonly isReached: (state: GoalState) => boolean };

export interface Lesson extends Topic {
  /** The ids of the lessons on which it builds; all of them come before it. */
  readonly needs: readonly string[];
  /** Its place on the map, so that no lines cross: the layer (from 0), and the distance from the layer's middle. */
  readonly position: { readonly layer: number; readonly offset: number };
  /** The paragraphs of its explanation. */
  readonly idea: readonly TextKey[];
  /** The name of its arm in the page's data. */
  readonly arm: "plain" | "elbow";
  /** The sliders beside the arm; null if there are none. */
  readonly tool: Tool | null;
  /** What the drawing shows, if it differs from the default. */
  readonly layers: Partial<Layers>;
  /** The pane that is open at first. */
  readonly pane: Pane | null;
  readonly goals: readonly Goal[];
}

/** A lesson as it is written below: its id names its texts; by default the arm is plain and there is no tool. */
type LessonData = Pick<Lesson, "needs" | "position" | "layers" | "pane"> &
  Partial<Pick<Lesson, "arm" | "tool">> & {
    readonly id: "rates" | "columns" | "differentiation" | "propagation" | "inverse" | "singular" | "kinds" | "path";
    readonly goals: readonly Goal["isReached"][];
  };

/** Return an entry of J; rows and columns count from 1. */
const getEntry = ({ state }: Stage, row: number, column: number): number => state.taskJacobian[row - 1]![column - 1]!;
/** Return the linear part of a column of J, counted from 1. */
const getLinearColumn = (stage: Stage, k: number): Vec3 =>
  [0, 1, 2].map((row) => stage.state.jacobian[row]![k - 1]!) as unknown as Vec3;
/** Return the cosine of the angle between two vectors; 0 if one of them vanishes. */
const computeCosine = (a: Vec3, b: Vec3): number => dot(a, b) / (norm(a) * norm(b) || Infinity);
const UP: Vec3 = [0, 1, 0];
/** Return the absolute value of theta2 (rad). */
const getAbsoluteTheta2 = ({ pose }: Stage): number => Math.abs(pose[1]!);
const DEGREE = Math.PI / 180;

const LESSON_DATA: readonly LessonData[] = [
  {
    id: "rates",
    needs: [],
    position: { layer: 0, offset: 0 },
    tool: "rates",
    layers: { columns: false, ellipse: false },
    pane: "joints",
    goals: [
      ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.3,
      ({ velocity }) => norm(velocity) > 0.05 && computeCosine(velocity, UP) > 0.995,
      ({ velocity, stage }) => norm(velocity) > 0.05 && computeCosine(velocity, stage.state.point) < -0.99,
    ],
  },
  {
    id: "columns",
    needs: ["rates"],
    position: { layer: 1, offset: 0 },
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      ({ stage }) => computeCosine(getLinearColumn(stage, 2), UP) > 0.998,
      ({ stage }) => norm(getLinearColumn(stage, 1)) < 0.11 * stage.reach,
      ({ stage }) => Math.abs(computeCosine(getLinearColumn(stage, 1), getLinearColumn(stage, 2))) > 0.999,
    ],
  },
  {
    id: "differentiation",
    needs: ["columns"],
    position: { layer: 2, offset: -0.5 },
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      ({ stage }) => Math.abs(getEntry(stage, 1, 1)) < 0.02 * stage.reach,
      ({ stage }) =>
        Math.abs(getEntry(stage, 2, 2)) < 0.02 * stage.reach && Math.abs(getEntry(stage, 2, 1)) > 0.1 * stage.reach,
    ],
  },
  {
    id: "propagation",
    needs: ["columns"],
    position: { layer: 2, offset: 0.5 },
    layers: { ellipse: false, vectors: true },
    pane: "jacobian",
    goals: [
      ({ stage }) => Math.abs(computeCosine(...computeMomentArms(stage))) < 0.03,
      ({ stage }) => computeCosine(...computeMomentArms(stage)) > 0.9995,
    ],
  },
  {
    id: "inverse",
    needs: ["differentiation", "propagation"],
    position: { layer: 3, offset: 0.5 },
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
    position: { layer: 3, offset: -0.5 },
    layers: {},
    pane: "map",
    goals: [
      ({ stage }) => getAbsoluteTheta2(stage) < 2 * DEGREE,
      ({ stage }) => getAbsoluteTheta2(stage) > 178 * DEGREE,
      ({ stage }) => Math.abs(Math.sin(getAbsoluteTheta2(stage))) > 0.995,
    ],
  },
  {
    id: "kinds",
    needs: ["singular"],
    position: { layer: 4, offset: -0.5 },
    arm: "elbow",
    layers: { frames: false },
    pane: "map",
    goals: [
      ({ stage }) => kindOfSingularity(stage.arm, stage.settledState) === "boundary",
      ({ stage }) => kindOfSingularity(stage.arm, stage.settledState) === "internal",
    ],
  },
  {
    id: "path",
    needs: ["inverse", "singular"],
    position: { layer: 4, offset: 0.5 },
    layers: { frames: false },
    pane: "weld",
    goals: [
      ({ stage: { welding } }) =>
        welding !== null && welding.place > 0.95 * (welding.journey.stations.at(-1)!.s || Infinity),
      ({ stage }) => classifyJourney(stage.arm, stage.welding) === "exceeds",
      ({ stage }) => classifyJourney(stage.arm, stage.welding) === "keeps",
    ],
  },
];

export const LESSONS: readonly Lesson[] = LESSON_DATA.map(({ id, goals, ...lesson }) => ({
  ...getTopic(id),
  idea: [`lesson.${id}.idea-1`, `lesson.${id}.idea-2`],
  arm: "plain",
  tool: null,
  ...lesson,
  goals: goals.map((isReached, i) => ({ text: `lesson.${id}.goal-${i + 1}` as TextKey, isReached })),
}));

/** Return p*_0 and p*_1, the vectors from the first two joint axes to P. */
function computeMomentArms({ arm, state }: Stage): [Vec3, Vec3] {
  const [first, second] = pStar(arm, state);
  return [first!, second!];
}
