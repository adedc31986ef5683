// The twelve lessons: a prediction, goals to reach on the arm, and the explanation. Lengths in metres, rates in rad/s.
// The questions that each lesson practises are in practice/topics.ts.

import { kindOfSingularity } from "../arm/descriptions.js";
import { pStar } from "../arm/model.js";
import { classifyJourney } from "../arm/weld.js";
import type { Layers } from "../arm/marks.js";
import type { Unknown } from "../arm/panel.js";
import type { Pane, Stage } from "../arm/stage.js";
import { dot, norm, type Vec3 } from "../arm/vector.js";
import { type Topic, type TopicId, getTopic } from "../practice/topics.js";
import type { TextKey } from "../text/text.js";
import { computeJointSpeed, FORCE, type Tool } from "./tools.js";

/**
 * What goals are checked against: the stage, the joint rates (or torques) that a tool sets if there is one, the velocity
 * of P at these rates.
 */
export type GoalState = { readonly stage: Stage; readonly rates: readonly number[]; readonly velocity: Vec3 };

type Goal = { readonly text: TextKey; readonly isReached: (state: GoalState) => boolean };

/** A question answered before anything moves. It is settled, with the text `outcome`, once a goal is reached. */
export interface Prediction {
  readonly question: TextKey;
  readonly options: readonly TextKey[];
  /** The index of the right option. */
  readonly right: number;
  /** The index of the goal that settles it. */
  readonly goal: number;
  readonly outcome: TextKey;
}

export interface Lesson extends Topic {
  /** The ids of the lessons on which it builds; all of them come before it. */
  readonly needs: readonly string[];
  /** Its place on the map, so that no lines cross: the layer (from 0), and the distance from the layer's middle. */
  readonly position: { readonly layer: number; readonly offset: number };
  /** What to look at, without a formula. */
  readonly intro: TextKey;
  readonly prediction: Prediction;
  /** The paragraphs of its explanation, and an example with numbers. */
  readonly idea: readonly TextKey[];
  readonly example: TextKey;
  /** The joint angles (degrees) of the figure in its explanation. */
  readonly sketch: readonly number[];
  /** The joint angles (degrees) at first, if those of the page's arm would give the prediction away; else null. */
  readonly start: readonly number[] | null;
  /** The name of its arm in the page's data. */
  readonly arm: "plain" | "elbow";
  /** The sliders or the chart beside the arm; null if there are none. */
  readonly tool: Tool | null;
  /** What the drawing shows, if it differs from the default. */
  readonly layers: Partial<Layers>;
  /** What no lesson has introduced yet, so that it is not shown; null if nothing is missing. */
  readonly unknown: Unknown | null;
  /** The pane that is open at first. */
  readonly pane: Pane | null;
  readonly goals: readonly Goal[];
}

/** A lesson as it is written below: its id names its texts; by default the arm is plain and there is no tool. */
type LessonData = Pick<Lesson, "needs" | "position" | "layers" | "pane" | "sketch"> &
  Partial<Pick<Lesson, "arm" | "tool" | "unknown" | "start">> & {
    readonly id: TopicId;
    readonly prediction: Pick<Prediction, "right" | "goal">;
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
const [LEFT, DOWN]: readonly Vec3[] = [
  [-1, 0, 0],
  [0, -1, 0],
];
/** Return the absolute value of theta2 (rad). */
const getAbsoluteTheta2 = ({ pose }: Stage): number => Math.abs(pose[1]!);
const DEGREE = Math.PI / 180;

const LESSON_DATA: readonly LessonData[] = [
  {
    id: "rates",
    needs: [],
    position: { layer: 0, offset: 0 },
    tool: "rates",
    layers: { frames: false, columns: false, ellipse: false },
    unknown: "jacobian",
    pane: "joints",
    prediction: { right: 1, goal: 0 },
    sketch: [30, 70],
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
    unknown: "determinant",
    pane: "jacobian",
    prediction: { right: 1, goal: 1 },
    sketch: [30, 90],
    goals: [
      ({ stage }) => computeCosine(getLinearColumn(stage, 2), UP) > 0.998,
      ({ stage }) => norm(getLinearColumn(stage, 1)) < 0.11 * stage.reach,
      ({ stage }) => Math.abs(computeCosine(getLinearColumn(stage, 1), getLinearColumn(stage, 2))) > 0.999,
    ],
  },
  {
    id: "differentiation",
    needs: ["columns"],
    position: { layer: 2, offset: -1 },
    layers: { ellipse: false },
    unknown: "determinant",
    pane: "jacobian",
    prediction: { right: 0, goal: 0 },
    sketch: [30, 60],
    goals: [
      ({ stage }) => Math.abs(getEntry(stage, 1, 1)) < 0.02 * stage.reach,
      ({ stage }) =>
        Math.abs(getEntry(stage, 2, 2)) < 0.02 * stage.reach && Math.abs(getEntry(stage, 2, 1)) > 0.1 * stage.reach,
    ],
  },
  {
    id: "propagation",
    needs: ["columns"],
    position: { layer: 2, offset: 0 },
    layers: { ellipse: false, vectors: true },
    unknown: "determinant",
    pane: "jacobian",
    prediction: { right: 0, goal: 0 },
    sketch: [20, 80],
    goals: [
      ({ stage }) => Math.abs(computeCosine(...computeMomentArms(stage))) < 0.03,
      ({ stage }) => computeCosine(...computeMomentArms(stage)) > 0.9995,
    ],
  },
  {
    id: "links",
    needs: ["columns"],
    position: { layer: 2, offset: 1 },
    tool: "links",
    layers: { frames: false, columns: false, ellipse: false },
    unknown: "determinant",
    pane: "joints",
    prediction: { right: 1, goal: 0 },
    sketch: [40, 60],
    goals: [
      ({ rates }) => Math.abs(rates[0]!) > 0.3 && Math.abs(rates[0]! + rates[1]!) < 0.03,
      ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.3,
      ({ stage, rates, velocity }) => {
        const jointSpeed = computeJointSpeed(stage, rates);
        return jointSpeed > 0.05 && Math.abs(norm(velocity) / jointSpeed - 2) < 0.1;
      },
    ],
  },
  {
    id: "inverse",
    needs: ["differentiation", "propagation"],
    position: { layer: 3, offset: 0 },
    tool: "wanted",
    layers: { ellipse: false },
    pane: "joints",
    prediction: { right: 2, goal: 1 },
    sketch: [40, 15],
    goals: [
      ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.05,
      ({ rates }) => Math.max(...rates.map(Math.abs)) > 10,
    ],
  },
  {
    id: "numbers",
    needs: ["inverse"],
    position: { layer: 4, offset: 1 },
    tool: "wanted",
    layers: { ellipse: false },
    pane: "jacobian",
    prediction: { right: 0, goal: 0 },
    sketch: [20, 110],
    goals: [
      ({ velocity }) => norm(velocity) > 0.05 && computeCosine(velocity, LEFT!) > 0.999,
      ({ rates }) => Math.abs(rates[0]!) > 0.1 && Math.abs(rates[0]! + rates[1]!) < 0.03 * Math.abs(rates[0]!),
      ({ rates, velocity }) => computeCosine(velocity, DOWN!) > 0.999 && Math.max(...rates.map(Math.abs)) < 1.5,
    ],
  },
  {
    id: "singular",
    needs: ["differentiation"],
    position: { layer: 3, offset: -1 },
    tool: "area",
    layers: { ellipse: false },
    pane: "joints", // its map would give the prediction away,
    start: [40, 140],
    prediction: { right: 2, goal: 2 },
    sketch: [35, 4],
    goals: [
      ({ stage }) => getAbsoluteTheta2(stage) < 2 * DEGREE,
      ({ stage }) => getAbsoluteTheta2(stage) > 178 * DEGREE,
      ({ stage }) => Math.abs(Math.sin(getAbsoluteTheta2(stage))) > 0.995,
    ],
  },
  {
    id: "kinds",
    needs: ["singular"],
    position: { layer: 4, offset: -1 },
    arm: "elbow",
    layers: { frames: false },
    pane: "map",
    prediction: { right: 1, goal: 1 },
    sketch: [155, 35, 0],
    goals: [
      ({ stage }) => kindOfSingularity(stage.arm, stage.settledState) === "boundary",
      ({ stage }) => kindOfSingularity(stage.arm, stage.settledState) === "internal",
    ],
  },
  {
    id: "workspace",
    needs: ["kinds"],
    position: { layer: 5, offset: 0 },
    arm: "elbow",
    tool: "workspace",
    layers: { frames: false },
    pane: "map",
    prediction: { right: 0, goal: 0 },
    sketch: [155, -20, 0],
    goals: [
      ({ stage }) => kindOfSingularity(stage.arm, stage.settledState) === "boundary",
      ({ stage }) => Math.abs(stage.pose[2]!) > 178 * DEGREE,
      ({ stage }) => Math.hypot(stage.state.point[0], stage.state.point[1]) < 0.02 * stage.reach,
    ],
  },
  {
    id: "torques",
    needs: ["propagation"],
    position: { layer: 3, offset: 1 },
    tool: "force",
    layers: { ellipse: false },
    pane: "jacobian",
    prediction: { right: 1, goal: 0 },
    sketch: [60, -50],
    goals: [
      ({ rates, stage }) => Math.abs(rates[0]!) < 0.02 * FORCE * stage.reach,
      ({ rates, stage }) => Math.max(...rates.map(Math.abs)) < 0.02 * FORCE * stage.reach,
      ({ rates, stage }) => Math.abs(rates[0]!) > 0.98 * FORCE * stage.reach,
    ],
  },
  {
    id: "path",
    needs: ["inverse", "singular"],
    position: { layer: 4, offset: 0 },
    layers: { frames: false },
    pane: "weld",
    prediction: { right: 0, goal: 1 },
    sketch: [60, 150],
    goals: [
      ({ stage: { welding } }) =>
        welding !== null && welding.place > 0.95 * (welding.journey.stations.at(-1)!.s || Infinity),
      ({ stage }) => classifyJourney(stage.arm, stage.welding) === "exceeds",
      ({ stage }) => classifyJourney(stage.arm, stage.welding) === "keeps",
    ],
  },
];

/** The number of options of each prediction. */
const OPTION_COUNT = 3;

export const LESSONS: readonly Lesson[] = LESSON_DATA.map(({ id, goals, prediction, ...lesson }) => ({
  ...getTopic(id),
  intro: `lesson.${id}.intro`,
  idea: [`lesson.${id}.idea-1`, `lesson.${id}.idea-2`],
  example: `lesson.${id}.example`,
  arm: "plain",
  tool: null,
  unknown: null,
  start: null,
  ...lesson,
  prediction: {
    ...prediction,
    question: `lesson.${id}.predict`,
    options: Array.from({ length: OPTION_COUNT }, (_, k) => `lesson.${id}.option-${k + 1}` as TextKey),
    outcome: `lesson.${id}.outcome`,
  },
  goals: goals.map((isReached, i) => ({ text: `lesson.${id}.goal-${i + 1}` as TextKey, isReached })),
}));

/** Return p*_0 and p*_1, the vectors from the first two joint axes to P. */
function computeMomentArms({ arm, state }: Stage): [Vec3, Vec3] {
  const [first, second] = pStar(arm, state);
  return [first!, second!];
}
