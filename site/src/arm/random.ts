// A small generator of even numbers with a seed: the same configurations are tried on every visit.

/** A function that returns numbers between 0 and 1. */
export function evenNumbers(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1_664_525) + 1_013_904_223) >>> 0;
    let mixed = state ^ (state >>> 15);
    mixed = Math.imul(mixed, 0x2c1b_3c6d) >>> 0;
    mixed = (mixed ^ (mixed >>> 12)) >>> 0;
    return mixed / 4_294_967_296;
  };
}

/** Poses with every joint variable between -pi and pi (rad or m). */
export function randomPoses(count: number, joints: number, seed: number): number[][] {
  const next = evenNumbers(seed);
  return Array.from({ length: count }, () => Array.from({ length: joints }, () => (2 * next() - 1) * Math.PI));
}
