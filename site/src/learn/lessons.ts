// The eight lessons of the way through the chapter: an idea to do with the arm, and goals that the page sees reached; what is
// practised then stands in practice/topics.ts. Lengths in metres, rates in rad/s.

import { kindHere } from "../arm/words.js";
import { pStar } from "../arm/model.js";
import { verdictOf } from "../arm/weld.js";
import type { Layers } from "../arm/marks.js";
import type { Pane, Stage } from "../arm/stage.js";
import { dot, norm, type Vec3 } from "../arm/vector.js";
import { type Topic, topicOf } from "../practice/topics.js";
import type { TextKey } from "../text/en.js";
import type { Tool } from "./tools.js";

/** What a goal is judged by: the stage, the rates of the joints (where a tool sets them), and the velocity of P. */
export interface Seen {
  readonly stage: Stage;
  readonly rates: readonly number[];
  readonly velocity: Vec3;
}

export interface Goal {
  readonly text: TextKey;
  readonly reached: (seen: Seen) => boolean;
}

export interface Lesson extends Topic {
  /** The lessons that it builds on, all of which come before it. */
  readonly needs: readonly string[];
  readonly idea: readonly TextKey[];
  readonly arm: "plain" | "elbow";
  readonly tool: Tool | null;
  readonly layers: Partial<Layers>;
  readonly pane: Pane | null;
  readonly goals: readonly Goal[];
}

/** An entry of J: its row and column, counted from 1. */
const entry = ({ state }: Stage, row: number, column: number): number => state.counted[row - 1]![column - 1]!;
const column = (stage: Stage, k: number): Vec3 =>
  [0, 1, 2].map((row) => stage.state.jacobian[row]![k - 1]!) as unknown as Vec3;
/** The cosine of the angle between two vectors; 0 where one of them vanishes. */
const cosine = (a: Vec3, b: Vec3): number => dot(a, b) / (norm(a) * norm(b) || Infinity);
const UP: Vec3 = [0, 1, 0];
const theta2 = ({ pose }: Stage): number => Math.abs(pose[1]!);
const DEGREE = Math.PI / 180;

export const LESSONS: readonly Lesson[] = [
  {
    ...topicOf("rates"),
    needs: [],
    idea: ["lesson.rates.idea-1", "lesson.rates.idea-2"],
    arm: "plain",
    tool: "rates",
    layers: { columns: false, ellipse: false },
    pane: "joints",
    goals: [
      {
        text: "lesson.rates.goal-1",
        reached: ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.3,
      },
      {
        text: "lesson.rates.goal-2",
        reached: ({ velocity }) => norm(velocity) > 0.05 && cosine(velocity, UP) > 0.995,
      },
      {
        text: "lesson.rates.goal-3",
        reached: ({ velocity, stage }) =>
          norm(velocity) > 0.05 && cosine(velocity, stage.state.point) < -0.99,
      },
    ],
  },
  {
    ...topicOf("columns"),
    needs: ["rates"],
    idea: ["lesson.columns.idea-1", "lesson.columns.idea-2"],
    arm: "plain",
    tool: null,
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      { text: "lesson.columns.goal-1", reached: ({ stage }) => cosine(column(stage, 2), UP) > 0.998 },
      { text: "lesson.columns.goal-2", reached: ({ stage }) => norm(column(stage, 1)) < 0.11 * stage.reach },
      {
        text: "lesson.columns.goal-3",
        reached: ({ stage }) => Math.abs(cosine(column(stage, 1), column(stage, 2))) > 0.999,
      },
    ],
  },
  {
    ...topicOf("differentiation"),
    needs: ["columns"],
    idea: ["lesson.differentiation.idea-1", "lesson.differentiation.idea-2"],
    arm: "plain",
    tool: null,
    layers: { ellipse: false },
    pane: "jacobian",
    goals: [
      {
        text: "lesson.differentiation.goal-1",
        reached: ({ stage }) => Math.abs(entry(stage, 1, 1)) < 0.02 * stage.reach,
      },
      {
        text: "lesson.differentiation.goal-2",
        reached: ({ stage }) =>
          Math.abs(entry(stage, 2, 2)) < 0.02 * stage.reach &&
          Math.abs(entry(stage, 2, 1)) > 0.1 * stage.reach,
      },
    ],
  },
  {
    ...topicOf("propagation"),
    needs: ["columns"],
    idea: ["lesson.propagation.idea-1", "lesson.propagation.idea-2"],
    arm: "plain",
    tool: null,
    layers: { ellipse: false, vectors: true },
    pane: "jacobian",
    goals: [
      {
        text: "lesson.propagation.goal-1",
        reached: ({ stage }) => Math.abs(cosine(...twoArms(stage))) < 0.03,
      },
      { text: "lesson.propagation.goal-2", reached: ({ stage }) => cosine(...twoArms(stage)) > 0.9995 },
    ],
  },
  {
    ...topicOf("inverse"),
    needs: ["differentiation", "propagation"],
    idea: ["lesson.inverse.idea-1", "lesson.inverse.idea-2"],
    arm: "plain",
    tool: "wanted",
    layers: { ellipse: false },
    pane: "joints",
    goals: [
      {
        text: "lesson.inverse.goal-1",
        reached: ({ rates }) => Math.abs(rates[0]!) < 0.03 && Math.abs(rates[1]!) > 0.05,
      },
      { text: "lesson.inverse.goal-2", reached: ({ rates }) => Math.max(...rates.map(Math.abs)) > 10 },
    ],
  },
  {
    ...topicOf("singular"),
    needs: ["differentiation"],
    idea: ["lesson.singular.idea-1", "lesson.singular.idea-2"],
    arm: "plain",
    tool: null,
    layers: {},
    pane: "map",
    goals: [
      { text: "lesson.singular.goal-1", reached: ({ stage }) => theta2(stage) < 2 * DEGREE },
      { text: "lesson.singular.goal-2", reached: ({ stage }) => theta2(stage) > 178 * DEGREE },
      { text: "lesson.singular.goal-3", reached: ({ stage }) => Math.abs(Math.sin(theta2(stage))) > 0.995 },
    ],
  },
  {
    ...topicOf("kinds"),
    needs: ["singular"],
    idea: ["lesson.kinds.idea-1", "lesson.kinds.idea-2"],
    arm: "elbow",
    tool: null,
    layers: { frames: false },
    pane: "map",
    goals: [
      {
        text: "lesson.kinds.goal-1",
        reached: ({ stage }) => kindHere(stage.arm, stage.rested) === "boundary",
      },
      {
        text: "lesson.kinds.goal-2",
        reached: ({ stage }) => kindHere(stage.arm, stage.rested) === "internal",
      },
    ],
  },
  {
    ...topicOf("path"),
    needs: ["inverse", "singular"],
    idea: ["lesson.path.idea-1", "lesson.path.idea-2"],
    arm: "plain",
    tool: null,
    layers: { frames: false },
    pane: "weld",
    goals: [
      {
        text: "lesson.path.goal-1",
        reached: ({ stage }) => (stage.welding?.place ?? 0) > 0.95 * endOf(stage),
      },
      {
        text: "lesson.path.goal-2",
        reached: ({ stage }) => verdictOf(stage.arm, stage.welding) === "exceeds",
      },
      { text: "lesson.path.goal-3", reached: ({ stage }) => verdictOf(stage.arm, stage.welding) === "keeps" },
    ],
  },
];

/** p*_0 and p*_1. */
function twoArms({ arm, state }: Stage): [Vec3, Vec3] {
  const [first, second] = pStar(arm, state);
  return [first!, second!];
}

/** How far the path goes that is played (m); no number where none is. */
function endOf({ welding }: Stage): number {
  return welding?.journey.stations.at(-1)?.s || Infinity;
}
