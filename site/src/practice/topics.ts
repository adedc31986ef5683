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

const PRACTISED = [
  { id: "rates", questions: ["joint-effect", "speed", "velocity-component", "velocity"], families: FLAT },
  { id: "columns", questions: ["match-columns", "joint-effect", "jacobian-size"], families: FLAT },
  { id: "differentiation", questions: ["position", "jacobian"], families: FLAT },
  {
    id: "propagation",
    questions: ["position-vectors", "link-velocity", "geometric-jacobian", "twist"],
    families: FLAT,
  },
  { id: "inverse", questions: ["joint-rates", "inverse-jacobian", "inverse-velocity"], families: SQUARE },
  { id: "singular", questions: ["determinant", "singular-angles", "rank"], families: SQUARE },
  {
    id: "kinds",
    questions: ["singularity-type", "singularity-meaning", "lost-direction", "lost-motion"],
    families: [...SQUARE, "spherical", "cylindrical"],
  },
  { id: "path", questions: ["path-rates", "path-limit"], families: SQUARE },
] as const;

export const TOPICS: readonly Topic[] = PRACTISED.map((topic) => ({ ...topic, title: `lesson.${topic.id}` }));

/** The topic of a lesson. */
export const topicOf = (lesson: string): Topic => TOPICS.find(({ id }) => id === lesson)!;
