// Partial credit by the rules of ../../../exercises/problem/credit.py (docs/partial-credit.md).

/** Share deducted for wrong signs (of any number), for a wrong common factor, or for rounded joint values. */
const DEDUCTION = 1 / 5;
/** Factors for a condition of which some pieces are forgotten, and for a condition that is missing or false. */
const [FORGOTTEN_FACTOR, MISSING_FACTOR] = [2 / 3, 1 / 2];

/** Return the share if everything is right up to signs or a constant factor (1 deviation), or both (2). */
export const computeShareForDeviations = (deviationCount: 1 | 2): number => 1 - DEDUCTION * deviationCount;

/** For each entry, whether it has a property. */
type Flags = readonly boolean[];

/** Return the share of nonzero entries that are right; each zero answered with something else cancels a right entry. */
export function computeShareOfEntries(rightFlags: Flags, zeroFlags: Flags, blankFlags: Flags = []): number {
  // zeros count only if there is nothing else
  const countedFlags = zeroFlags.map((isZero) => !isZero || zeroFlags.every(Boolean));
  const countedRightFlags = rightFlags.filter((_, i) => countedFlags[i]);
  const wrongZeroCount = rightFlags.filter((isRight, i) => !countedFlags[i] && !isRight && !blankFlags[i]).length;
  const rightMinusWrong = countedRightFlags.filter(Boolean).length - wrongZeroCount;
  const maxRight = countedRightFlags.length - 1; // the caller has found something wrong
  return Math.max(0, Math.min(rightMinusWrong, maxRight)) / countedRightFlags.length;
}

/** How many pieces of a condition the answer contains, and how many the condition has. */
export interface Coverage {
  readonly found: number;
  readonly expected: number;
}

/** Return the factor by which a condition reduces the share: 1 if all of its pieces are found. */
function computeFactorOfCondition({ found, expected }: Coverage): number {
  if (found === expected) return 1;
  return found > 0 ? FORGOTTEN_FACTOR : MISSING_FACTOR;
}

/** Return the share of a set from the coverage of each condition, the number of false conditions, and rounding. */
export function computeShareOfSet(coverages: readonly Coverage[], falseCount: number, isRounded = false): number {
  const foundConditions = coverages.filter(({ found }) => found > 0).length;
  if (foundConditions === 0 || falseCount > foundConditions) return 0;
  const share = coverages.reduce(
    (product, coverage) => product * computeFactorOfCondition(coverage),
    MISSING_FACTOR ** falseCount * (isRounded ? 1 - DEDUCTION : 1),
  );
  return share < 1 ? share : MISSING_FACTOR; // the caller has found something wrong
}

/**
 * Return the number of false conditions. Each is given by the names of its joints; all false values of the same joints
 * count once, unless these joints have true values, too.
 */
export function countFalseConditions(falseJoints: readonly string[], trueJoints: ReadonlySet<string>): number {
  const falseBesideTrue = falseJoints.filter((joints) => trueJoints.has(joints));
  return falseBesideTrue.length + new Set(falseJoints.filter((joints) => !trueJoints.has(joints))).size;
}
