// Partial credit by the rules of ../../../exercises/credit.py (docs/partial-credit.md).

/** Deduction for wrong signs (of any number), for a wrong common factor, or for rounded joint values. */
const DEDUCTION = 1 / 5;
/** Factors for a condition of which some pieces are forgotten, and for a condition that is missing or false. */
const [FORGOTTEN_FACTOR, MISSING_FACTOR] = [2 / 3, 1 / 2];

/** Return the share if all is right up to signs or a constant factor (`deviations` 1), or both (2). */
export const shareUpToDeviations = (deviations: 1 | 2): number => 1 - DEDUCTION * deviations;

/** Whether each entry has a property. */
type Flags = readonly boolean[];

/** Return the share of nonzero entries that are right; each zero answered with something else cancels a right entry. */
export function shareOfEntries(isRight: Flags, isZero: Flags, isBlank: Flags = []): number {
  const isCounted = isZero.map((zero) => !zero || isZero.every(Boolean));
  const countedEntries = isRight.filter((_, i) => isCounted[i]);
  const wrongZeroCount = isRight.filter((right, i) => !isCounted[i] && !right && !isBlank[i]).length;
  const rightMinusWrong = countedEntries.filter(Boolean).length - wrongZeroCount;
  return Math.max(0, Math.min(rightMinusWrong, countedEntries.length - 1)) / countedEntries.length;
}

/** How many pieces of a condition the answer contains, and how many there are. */
type Coverage = readonly [count: number, expected: number];

/** Return the share of a set from the coverage of each condition, the number of false conditions, and rounding. */
export function shareOfSet(coverage: readonly Coverage[], falseCount: number, isRounded = false): number {
  const foundConditions = coverage.filter(([count]) => count > 0).length;
  if (foundConditions === 0 || falseCount > foundConditions) return 0;
  const share = coverage.reduce(
    (product, [count, expected]) => product * (count === expected ? 1 : count > 0 ? FORGOTTEN_FACTOR : MISSING_FACTOR),
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
