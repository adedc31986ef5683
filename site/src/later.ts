// Work that can wait until what was changed is painted, or until the browser has done what it waits for.

/** Call after the next paint; in a page that is not shown, soon. */
export function afterPaint(work: () => void): void {
  if (document.hidden) setTimeout(work);
  else requestAnimationFrame(() => setTimeout(work));
}

/** Let the browser do what it waits for. */
export const breath = (): Promise<void> => new Promise((done) => setTimeout(done));
