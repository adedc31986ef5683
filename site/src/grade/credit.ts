// Partial credit by the rules of ../../../exercises/credit.py (docs/partial-credit.md).

/** Deduction for wrong signs (of any number), for a wrong common factor, or for rounded joint values. */
const DEDUCTION = 1 / 5;
/** Factors for a condition of which pieces are forgotten, and for a condition that is missing or false. */
const [SOME_FORGOTTEN, HALF] = [2 / 3, 1 / 2];

/** Return the share if all is right up to signs or a constant factor (`deviations` 1), or both (2). */
export const shareButForFactor = (deviations: 1 | 2): number => 1 - DEDUCTION * deviations;

/** A truth value for each entry. */
type Flags = readonly boolean[];

/** Return the share of nonzero entries that are right, minus one for each zero answered with something else. */
export function shareOfEntries(right: Flags, zeros: Flags, blank: Flags = []): number {
  const isCounted = zeros.every(Boolean) ? zeros.map(() => true) : zeros.map((zero) => !zero);
  const counted = right.filter((_, i) => isCounted[i]);
  const spoiled = right.filter((ok, i) => !isCounted[i] && !ok && !blank[i]).length;
  const share = counted.filter(Boolean).length - spoiled;
  return Math.max(0, Math.min(share, counted.length - 1)) / counted.length;
}

/** How many pieces of a condition the answer contains, and how many there are. */
type Coverage = readonly [count: number, expected: number];

/** Return the share of a set from the coverage of each condition, the number of false conditions, and rounding. */
export function shareOfSet(coverage: readonly Coverage[], falseCount: number, isRounded = false): number {
  const conditions = coverage.filter(([count]) => count > 0).length;
  if (conditions === 0 || falseCount > conditions) return 0;
  const share = coverage.reduce(
    (product, [count, expected]) => product * (count === expected ? 1 : count > 0 ? SOME_FORGOTTEN : HALF),
    HALF ** falseCount * (isRounded ? 1 - DEDUCTION : 1),
  );
  return share < 1 ? share : HALF;
}

/** Return the number of false conditions: all false values of a joint count once, unless it has true ones, too. */
export function falseConditions(isFalse: readonly string[], isTrue: ReadonlySet<string>): number {
  const mixed = isFalse.filter((joints) => isTrue.has(joints));
  return mixed.length + new Set(isFalse.filter((joints) => !isTrue.has(joints))).size;
}
