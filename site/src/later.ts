// Work that can wait: until what was changed is painted, or until the browser has nothing else to do.

/** Call after the next paint; in a page that is not shown, soon. */
export function afterPaint(work: () => void): void {
  if (document.hidden) setTimeout(work);
  else requestAnimationFrame(() => setTimeout(work));
}

/** Call when the browser is idle; what is returned calls it off. */
export function whenIdle(work: () => void): () => void {
  if (typeof requestIdleCallback === "undefined") {
    const timer = setTimeout(work, 300); // Safari
    return () => clearTimeout(timer);
  }
  const handle = requestIdleCallback(work, { timeout: 5000 });
  return () => cancelIdleCallback(handle);
}

/** Let the browser do what it waits for. */
export const breath = (): Promise<void> => new Promise((done) => setTimeout(done));
