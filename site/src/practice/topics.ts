// The questions and families of the bank that each lesson practises. learn/lessons.ts has what introduces them.

import type { TextKey } from "../text/text.js";

export interface Topic {
  /** The lesson's name in links, and in what is kept. */
  readonly id: string;
  readonly title: TextKey;
  /** Questions and families of the bank that are practised, in this order. */
  readonly questions: readonly string[];
  readonly families: readonly string[];
}

const FLAT = ["planar-2r", "polar-rp", "planar-pr", "planar-3r", "scara", "elbow-3r", "elbow"];
const SQUARE = ["planar-2r", "polar-rp", "planar-pr", "elbow-3r", "scara", "elbow", "planar-3r-pose"];

export const TOPICS: readonly Topic[] = [
  {
    id: "rates",
    title: "lesson.rates",
    questions: ["joint-effect", "speed", "velocity-component", "velocity"],
    families: FLAT,
  },
  {
    id: "columns",
    title: "lesson.columns",
    questions: ["match-columns", "joint-effect", "jacobian-size"],
    families: FLAT,
  },
  { id: "differentiation", title: "lesson.differentiation", questions: ["position", "jacobian"], families: FLAT },
  {
    id: "propagation",
    title: "lesson.propagation",
    questions: ["position-vectors", "link-velocity", "geometric-jacobian", "twist"],
    families: FLAT,
  },
  {
    id: "inverse",
    title: "lesson.inverse",
    questions: ["joint-rates", "inverse-jacobian", "inverse-velocity"],
    families: SQUARE,
  },
  { id: "singular", title: "lesson.singular", questions: ["determinant", "singular-angles", "rank"], families: SQUARE },
  {
    id: "kinds",
    title: "lesson.kinds",
    questions: ["singularity-type", "singularity-meaning", "lost-direction", "lost-motion"],
    families: [...SQUARE, "spherical", "cylindrical"],
  },
  { id: "path", title: "lesson.path", questions: ["path-rates", "path-limit"], families: SQUARE },
];

/** The topic of a lesson. */
export const topicOf = (lesson: string): Topic => TOPICS.find(({ id }) => id === lesson)!;
