// The topics of the lessons: the questions and families that each lesson practises. learn/lessons.ts introduces them.

import type { TextKey } from "../text/text.js";

export interface Topic {
  /** The lesson's name in links and in stored progress. */
  readonly id: string;
  readonly title: TextKey;
  /** Names of the questions that are practised, easier ones first. */
  readonly questions: readonly string[];
  /** Names of the families that are practised, easier ones first. */
  readonly families: readonly string[];
}

/** Families for topics in which J need not be square, easier ones first. */
const MAIN_FAMILIES = ["planar-2r", "polar-rp", "planar-pr", "planar-3r", "scara", "elbow-3r", "elbow"];
/** Families whose task Jacobian is square, easier ones first. */
const SQUARE_FAMILIES = ["planar-2r", "polar-rp", "planar-pr", "elbow-3r", "scara", "elbow", "planar-3r-pose"];

const TOPIC_DATA = [
  { id: "rates", questions: ["joint-effect", "speed", "velocity-component", "velocity"], families: MAIN_FAMILIES },
  { id: "columns", questions: ["match-columns", "joint-effect", "jacobian-size"], families: MAIN_FAMILIES },
  { id: "differentiation", questions: ["position", "joint-effect", "jacobian"], families: MAIN_FAMILIES },
  { id: "propagation", questions: ["position-vectors", "geometric-jacobian"], families: MAIN_FAMILIES },
  { id: "links", questions: ["link-velocity", "own-frame-velocity", "twist"], families: MAIN_FAMILIES },
  { id: "inverse", questions: ["inverse-jacobian", "inverse-velocity"], families: SQUARE_FAMILIES },
  { id: "numbers", questions: ["joint-rates", "determinant-value"], families: SQUARE_FAMILIES },
  { id: "singular", questions: ["determinant", "singular-angles", "rank"], families: SQUARE_FAMILIES },
  {
    id: "kinds",
    questions: ["singularity-type", "singularity-meaning"],
    families: [...SQUARE_FAMILIES, "spherical", "cylindrical"],
  },
  {
    id: "workspace",
    questions: ["rank", "lost-direction"],
    families: [...SQUARE_FAMILIES, "spherical", "cylindrical"],
  },
  { id: "torques", questions: ["joint-torques"], families: SQUARE_FAMILIES },
  { id: "path", questions: ["path-rates"], families: SQUARE_FAMILIES },
] as const;

export type TopicId = (typeof TOPIC_DATA)[number]["id"];

export const TOPICS: readonly Topic[] = TOPIC_DATA.map((topic) => ({ ...topic, title: `lesson.${topic.id}` }));

/** Return the topic of a lesson, by the lesson's id. */
export const getTopic = (lesson: string): Topic => TOPICS.find(({ id }) => id === lesson)!;
