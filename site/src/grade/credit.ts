// Partial credit, by the rules of ../../../exercises/credit.py (docs/partial-credit.md).

/** What wrong signs cost, however many there are, a common factor that is wrong, and rounded values of joints. */
const AMISS = 1 / 5;
const FORGOTTEN = 2 / 3;
const HALF = 1 / 2;

/** Of what is right but for signs, or for a constant factor (`amiss` 1), or for both (2). */
export const shareButForFactor = (amiss: 1 | 2): number => 1 - AMISS * amiss;

/** A truth value for each entry. */
type Flags = readonly boolean[];

/** Of the entries that are not zero, those that are right, less the zeros that were answered with something else. */
export function shareOfEntries(right: Flags, zeros: Flags, blank: Flags = []): number {
  const isCounted = zeros.every(Boolean) ? zeros.map(() => true) : zeros.map((zero) => !zero);
  const counted = right.filter((_, i) => isCounted[i]);
  const spoiled = right.filter((ok, i) => !isCounted[i] && !ok && !blank[i]).length;
  const share = counted.filter(Boolean).length - spoiled;
  return Math.max(0, Math.min(share, counted.length - 1)) / counted.length;
}

/** How many of the pieces of a condition were found. */
type Found = readonly [some: number, due: number];

/** Of a set: of each condition, how many pieces of how many are found; how many conditions are false; rounding. */
export function shareOfSet(found: readonly Found[], unsound: number, isRounded = false): number {
  const conditions = found.filter(([some]) => some > 0).length;
  if (conditions === 0 || unsound > conditions) return 0;
  const share = found.reduce(
    (product, [some, due]) => product * (some === due ? 1 : some > 0 ? FORGOTTEN : HALF),
    HALF ** unsound * (isRounded ? 1 - AMISS : 1),
  );
  return share < 1 ? share : HALF;
}

/** How many conditions are false: all false values of a joint are one, unless true ones are claimed beside them. */
export function falseConditions(isFalse: readonly string[], isTrue: ReadonlySet<string>): number {
  const beside = isFalse.filter((joints) => isTrue.has(joints));
  return beside.length + new Set(isFalse.filter((joints) => !isTrue.has(joints))).size;
}
