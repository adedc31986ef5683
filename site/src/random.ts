// Random numbers that are the same on every machine.

/** Return a generator of numbers from 0 to 1 that a seed determines (mulberry32). */
export function makeRandomNumbers(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Return poses with random joint variables between -pi and pi (rad or m). */
export function makeRandomPoses(count: number, joints: number, seed: number): number[][] {
  const next = makeRandomNumbers(seed);
  return Array.from({ length: count }, () => Array.from({ length: joints }, () => (2 * next() - 1) * Math.PI));
}

/** Return a new seed as a short text. */
export const makeSeed = (): string => crypto.getRandomValues(new Uint32Array(1))[0]!.toString(36);
