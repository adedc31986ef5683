// Judge an answer to a part of a problem by its key.

import { nameJoint, type Part, type Problem, type Robot } from "../bank.js";
import { evaluate } from "../read/evaluate.js";
import { readCommasAsPoints } from "../read/points.js";
import { parse } from "../read/reader.js";
import { message } from "../text/text.js";
import { judgeLetters } from "./letters.js";
import { judgeDirection, judgeNumbers } from "./numbers.js";
import { createZeroTest, type IsSingular, judgeSet } from "./sets.js";
import { judgeValues } from "./values.js";
import { isVerdict, type Verdict } from "./verdict.js";

export { parseTypedColumns } from "./typed-jacobian.js";

/** Judge an answer; `isSingular` decides whether a configuration of this problem's arm is singular. */
export function judge(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  return readWithCommas(answer, part.key.type === "values", (text) => judgeByKey(problem, part, text, isSingular));
}

/**
 * Return what `read` returns for an answer. If formulas can't be parsed, they are read once more with commas between
 * digits as decimal commas, but several numbers stay separate.
 */
export function readWithCommas<T extends object>(
  answer: string,
  hasFormulas: boolean,
  read: (text: string) => T | Verdict,
): T | Verdict {
  const result = read(answer);
  if (!isVerdict(result) || !isUnparsed(result)) return result;
  const withDecimalPoints = readCommasAsPoints(answer);
  const secondResult = hasFormulas && withDecimalPoints !== answer ? read(withDecimalPoints) : result;
  return isVerdict(secondResult) && isUnparsed(secondResult) ? addRemedy(result, answer) : secondResult;
}

/** If decimal commas made too many entries of a list, say how to separate numbers with commas. */
function addRemedy(verdict: Verdict, answer: string): Verdict {
  const [reason] = verdict.reasons;
  if (reason?.key !== "read.shape" || !/\p{Nd},\p{Nd}/u.test(answer)) return verdict;
  return { ...verdict, reasons: [message("read.shape-commas", reason.values)] };
}

const isUnparsed = ({ reasons }: Verdict): boolean => reasons[0]?.key.startsWith("read.") ?? false;

function judgeByKey(problem: Problem, part: Part, answer: string, isSingular: IsSingular): Verdict {
  const { key, labels, columns, names } = part;
  if ("option_mistakes" in key) return judgeLetters(answer, key);
  if (key.type === "numbers") return judgeNumbers(answer, key, labels);
  if (key.type === "configurations") {
    const angles = new Set(problem.robot.joints.flatMap((row, i) => (row.kind === "R" ? [nameJoint(row, i)] : [])));
    const offsets = findOffsets(problem.robot, angles);
    const isInSet = key.zeros ? createZeroTest(key.zeros, key.symbols) : isSingular;
    const verdict = suggestAnd(answer, (text) => judgeSet(text, key, angles, isInSet, offsets));
    return key.zeros ? { ...verdict, ofOwnSet: true } : verdict;
  }
  const keyWithNames = { ...key, mentioned: names };
  return key.type === "values"
    ? judgeValues(answer, keyWithNames, labels, columns)
    : judgeDirection(answer, keyWithNames, labels);
}

/** Return the constants that a standard table adds to variables of revolute joints. */
function findOffsets({ joints, convention }: Robot, angles: ReadonlySet<string>): Map<string, number> {
  const offsets = joints.map((row, i): [string, number] => {
    const joint = nameJoint(row, i);
    const isAngle = convention === undefined && row.kind === "R";
    return [joint, isAngle ? evaluate(parse(row.theta, angles), { [joint]: 0 }).re : 0];
  });
  return new Map(offsets.filter(([, offset]) => Number.isFinite(offset) && offset !== 0));
}

const isUnsound = ({ reasons }: Verdict): boolean => reasons.some(({ key }) => key === "verdict.unsound");

/** Return the verdict on conditions. If separate values claim too much, but "and" is right, the verdict says so. */
function suggestAnd(answer: string, judgeText: (text: string) => Verdict): Verdict {
  const verdict = judgeText(answer);
  const values = answer.trim().split(/\s*[,;\n]\s*/);
  const joints = new Set(values.map((value) => /^\w+(?=\s*=[^=]+$)/.exec(value)?.[0]));
  if (!isUnsound(verdict) || values.length < 2 || joints.size < values.length || joints.has(undefined)) return verdict;
  const verdictWithAnd = judgeText(values.join(" and "));
  if (isUnparsed(verdictWithAnd) || isUnsound(verdictWithAnd) || verdictWithAnd.outcome === "missing") return verdict;
  const slips = (verdict.slips ?? []).filter((slip) => !("key" in slip) || slip.key !== "slip.and-missing");
  const reasons = [...verdict.reasons, message("verdict.together")];
  return { ...verdict, reasons, slips: slips.length > 0 ? slips : undefined };
}
