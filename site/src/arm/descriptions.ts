// The arm in sentences: pose, position of P, determinant, and how near to a singularity the arm is.

import { say } from "../text/text.js";
import { canDecideKind, type SingularityKind, kindAt } from "./classify.js";
import { plainLetters } from "./letters.js";
import { lostDirection } from "./lost-direction.js";
import { type Arm, isMixed, type Measures, measuresOf, mixesUnits, type State } from "./model.js";
import { convertAngle, roundToDecimals, roundToDigits } from "./number-format.js";

type Nearness = "regular" | "near" | "singular";

/** The arm counts as singular, or as near a singularity, if the ratio of the singular values is smaller. */
const [SINGULAR_RATIO, NEAR_RATIO] = [0.004, 0.08];
/** The same as `NEAR_RATIO` for a J of linear and angular rows: its ratio depends on the unit of length. */
const NEAR_RATIO_IF_MIXED = 0.02;

/** Return how near a singularity is: "singular" if the least singular value is negligible beside the largest. */
export function classifyNearness(arm: Arm, { ratio }: Measures): Nearness {
  if (ratio < SINGULAR_RATIO) return "singular";
  return ratio < (isMixed(arm) ? NEAR_RATIO_IF_MIXED : NEAR_RATIO) ? "near" : "regular";
}

/** Return the kind of a nearly singular pose; null if it is regular or the kind can't be decided. */
export function kindOfSingularity(arm: Arm, state: State): Exclude<SingularityKind, "regular"> | null {
  if (classifyNearness(arm, measuresOf(arm, state)) !== "singular" || !canDecideKind(arm)) return null;
  const kind = kindAt(arm, state.pose, 0.005);
  return kind === "regular" ? null : kind;
}

/** Return pose, position, determinant and nearness in sentences. */
export function describeArm(arm: Arm, state: State, inRadians: boolean): string {
  return `${describePose(arm, state, inRadians)} ${describeSingularity(arm, state)}`;
}

/** Return the pose and the position of P in sentences. */
export function describePose(arm: Arm, { pose, point }: State, inRadians: boolean): string {
  const rotatedKey = inRadians ? "arm.words.turned-radians" : "arm.words.turned";
  const joints = arm.joints.map(({ kind, name }, i) =>
    say(kind === "R" ? rotatedKey : "arm.words.slid", {
      joint: plainLetters(name),
      value: kind === "R" ? convertAngle(inRadians, pose[i]!) : roundToDecimals(pose[i]!, 3),
    }),
  );
  const [x, y, z] = point.map((value) => roundToDecimals(value, 3)) as [number, number, number];
  return `${say("arm.words.pose", { joints: joints.join(", ") })} ${say("arm.words.point", { x, y, z })}`;
}

function describeSingularity(arm: Arm, state: State): string {
  const measures = measuresOf(arm, state);
  const { det, volume, minSigma, ratio } = measures;
  const nearness = classifyNearness(arm, measures);
  const sentences = [
    say(det === null ? "arm.words.volume" : "arm.words.det", { value: roundToDigits(det ?? volume) }),
    say(mixesUnits(arm) ? "arm.words.sigma-shares" : "arm.words.sigma", {
      least: roundToDigits(minSigma),
      percent: roundToDecimals(100 * ratio, 1),
    }),
    say(`arm.words.${nearness}`),
  ];
  const kind = kindOfSingularity(arm, state);
  if (kind) sentences.push(say(`arm.words.${kind}`));
  const direction = nearness === "regular" ? null : lostDirection(arm, state);
  if (direction) {
    const [x, y, z] = direction.map((value) => roundToDecimals(value, 2)) as [number, number, number];
    sentences.push(say(nearness === "near" ? "arm.words.slow" : "arm.words.lost", { x, y, z }));
  }
  return sentences.join(" ");
}

/** Return the text key of what measures J: its determinant, or what replaces it if J is not square. */
export function sizeKey(arm: Arm): "arm.figures.det" | "arm.figures.volume" | "arm.figures.tall" {
  const [rows, columns] = [arm.task.length, arm.joints.length];
  return rows === columns ? "arm.figures.det" : rows < columns ? "arm.figures.volume" : "arm.figures.tall";
}
