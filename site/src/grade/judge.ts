// An answer to a part of a problem, judged by its key.

import type { Part, Problem, Robot } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { withPoints } from "../read/points.js";
import { read } from "../read/reader.js";
import { message } from "../text/text.js";
import { judgeLetters } from "./letters.js";
import { judgeDirection, judgeNumbers } from "./numbers.js";
import { type IsSingular, judgeSet } from "./sets.js";
import { judgeValues } from "./values.js";
import type { Verdict } from "./verdict.js";

export { ownColumns } from "./own.js";

/**
 * Judge an answer; `isSingular` tells of poses of this problem's arm. A formula that can't be parsed is read once more
 * with its commas between digits as decimal commas. Several numbers stay what they are.
 */
export function judge(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  const first = judged(problem, part, answer, isSingular);
  const pointed = withPoints(answer);
  if (pointed === answer || part.key.type !== "values" || !isUnread(first)) return withRemedy(first, answer);
  const second = judged(problem, part, pointed, isSingular);
  return isUnread(second) ? withRemedy(first, answer) : second;
}

/** A list of which 0,5 makes too many entries: how numbers with a comma are set apart is told. */
function withRemedy(verdict: Verdict, answer: string): Verdict {
  const [reason] = verdict.reasons;
  if (reason?.key !== "read.shape" || !/\p{Nd},\p{Nd}/u.test(answer)) return verdict;
  return { ...verdict, reasons: [message("read.shape-commas", reason.values)] };
}

const isUnread = ({ reasons }: Verdict): boolean => reasons[0]?.key.startsWith("read.") ?? false;

function judged(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  const { key, labels, columns, names } = part;
  if ("told" in key) return judgeLetters(answer, key);
  if (key.type === "numbers") return judgeNumbers(answer, key, labels);
  if (key.type === "configurations") {
    const revolute = problem.robot.joints.flatMap((joint, i) => (joint.kind === "R" ? [`theta${i + 1}`] : []));
    const angles = new Set(revolute);
    const offsets = offsetsOf(problem.robot, angles);
    return perhapsTogether(answer, (text) => judgeSet(text, key, angles, isSingular, offsets));
  }
  const spoken = { ...key, spoken: names };
  return key.type === "values" ? judgeValues(answer, spoken, labels, columns) : judgeDirection(answer, spoken, labels);
}

/** What a standard table adds to the variables of revolute joints, where it adds a constant. */
function offsetsOf({ joints, convention }: Robot, angles: ReadonlySet<string>): Map<string, number> {
  const found = joints.map(({ theta }, i): [string, number] => {
    const joint = `theta${i + 1}`;
    const isAngle = convention === undefined && angles.has(joint);
    return [joint, isAngle ? evaluate(read(theta, angles), { [joint]: 0 }).re : 0];
  });
  return new Map(found.filter(([, offset]) => Number.isFinite(offset) && offset !== 0));
}

const isUnsound = ({ reasons }: Verdict): boolean => reasons.some(({ key }) => key === "verdict.unsound");

/** The verdict on conditions; if values of several joints claim too much, it says if "and" would have been right. */
function perhapsTogether(answer: string, judgeText: (text: string) => Verdict): Verdict {
  const found = judgeText(answer);
  const parted = answer.trim().split(/\s*[,;\n]\s*/);
  const about = new Set(parted.map((one) => /^\w+(?=\s*=[^=]+$)/.exec(one)?.[0]));
  if (!isUnsound(found) || parted.length < 2 || about.size < parted.length || about.has(undefined)) return found;
  const second = judgeText(parted.join(" and "));
  if (isUnread(second) || isUnsound(second) || second.outcome === "missing") return found;
  const slips = (found.slips ?? []).filter((slip) => !("key" in slip) || slip.key !== "slip.and-missing");
  const reasons = [...found.reasons, message("verdict.together")];
  const { slips: _, ...rest } = found;
  return { ...rest, reasons, ...(slips.length > 0 ? { slips } : {}) };
}
