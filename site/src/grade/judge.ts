// An answer to a part of a problem, judged by its key.

import type { Part, Problem } from "../bank.js";
import { withPoints } from "../read/points.js";
import { judgeLetters } from "./letters.js";
import { judgeDirection, judgeNumbers } from "./numbers.js";
import { type IsSingular, judgeSet } from "./sets.js";
import { judgeValues } from "./values.js";
import type { Verdict } from "./verdict.js";

export { ownColumns } from "./own.js";

/**
 * Judge an answer; `isSingular` tells of poses of this problem's arm. A formula that can't be read is read once more with
 * its commas between digits as decimal ones, as pages of many languages print them; several numbers stay what they are.
 */
export function judge(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  const first = judged(problem, part, answer, isSingular);
  const pointed = withPoints(answer);
  if (pointed === answer || part.key.type !== "values" || !isUnread(first)) return first;
  const second = judged(problem, part, pointed, isSingular);
  return isUnread(second) ? first : second;
}

const isUnread = ({ reasons }: Verdict): boolean => reasons[0]?.key.startsWith("read.") ?? false;

function judged(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  const { key, labels, columns } = part;
  switch (key.type) {
    case "values":
      return judgeValues(answer, key, labels, columns);
    case "direction":
      return judgeDirection(answer, key, labels);
    case "numbers":
      return judgeNumbers(answer, key, labels);
    case "configurations": {
      const angles = new Set(
        problem.robot.joints.flatMap((joint, i) => (joint.kind === "R" ? [`theta${i + 1}`] : [])),
      );
      return judgeSet(answer, key, angles, isSingular);
    }
    default:
      return judgeLetters(answer, key);
  }
}
