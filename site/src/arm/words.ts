// The arm in words: pose, where the point is, the determinant, and how near to a singularity it is.

import { say } from "../text/text.js";
import { type Kind, kindAt, kindIsSure } from "./classify.js";
import { plainLetters } from "./letters.js";
import { lostDirection } from "./lost.js";
import { type Arm, isMixed, type Measures, measuresOf, type State } from "./model.js";
import { angleIn, decimals, digits } from "./speech.js";

export type Nearness = "regular" | "near" | "singular";

/** How near to a singularity: singular where the least singular value is next to nothing beside the largest. */
export function nearness(arm: Arm, { ratio }: Measures): Nearness {
  return ratio < 0.004 ? "singular" : ratio < (isMixed(arm) ? 0.02 : 0.08) ? "near" : "regular";
}

/** The kind of a pose that is all but singular; null where it is regular or the kind can't be established. */
export function kindHere(arm: Arm, state: State): Exclude<Kind, "regular"> | null {
  if (nearness(arm, measuresOf(state)) !== "singular" || !kindIsSure(arm)) return null;
  const kind = kindAt(arm, state.pose, 0.005);
  return kind === "regular" ? null : kind;
}

/** Pose, point, determinant and nearness, in sentences. */
export function inWords(arm: Arm, state: State, radians: boolean): string {
  return `${poseAndPoint(arm, state, radians)} ${singularityInWords(arm, state)}`;
}

export function poseAndPoint(arm: Arm, state: State, radians: boolean): string {
  return `${poseInWords(arm, state, radians)} ${pointInWords(state)}`;
}

export function poseInWords(arm: Arm, { pose }: State, radians: boolean): string {
  const turned = radians ? "arm.words.turned-radians" : "arm.words.turned";
  const joints = arm.joints.map(({ kind, name }, i) =>
    say(kind === "R" ? turned : "arm.words.slid", {
      joint: plainLetters(name),
      value: kind === "R" ? angleIn(radians, pose[i]!) : decimals(pose[i]!, 3),
    }),
  );
  return say("arm.words.pose", { joints: joints.join(", ") });
}

export function pointInWords({ point }: State): string {
  const [x, y, z] = point.map((value) => decimals(value, 3)) as [number, number, number];
  return say("arm.words.point", { x, y, z });
}

export function singularityInWords(arm: Arm, state: State): string {
  const measures = measuresOf(state);
  const { det, volume, least, ratio } = measures;
  const percent = decimals(100 * ratio, 1);
  const size =
    det === null ? say("arm.words.volume", { value: digits(volume) }) : say("arm.words.det", { value: digits(det) });
  const how = nearness(arm, measures);
  const said = [size, say("arm.words.sigma", { least: digits(least), percent }), say(`arm.words.${how}`)];
  if (how === "singular") {
    const kind = kindHere(arm, state);
    if (kind) said.push(say(`arm.words.${kind}`));
  }
  const lost = how === "regular" ? null : lostDirection(arm, state);
  if (lost) {
    const [x, y, z] = lost.map((value) => decimals(value, 2)) as [number, number, number];
    said.push(say(how === "near" ? "arm.words.slow" : "arm.words.lost", { x, y, z }));
  }
  return said.join(" ");
}

/** What the size of J is called: its determinant, or what stands for it where J is not square. */
export function sizeName(arm: Arm): "arm.figures.det" | "arm.figures.volume" | "arm.figures.tall" {
  const [rows, columns] = [arm.task.length, arm.joints.length];
  return rows === columns ? "arm.figures.det" : rows < columns ? "arm.figures.volume" : "arm.figures.tall";
}
