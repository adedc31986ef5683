// Work that can wait until what was changed is painted, or until the browser has done what it waits for.

import { useEffect, useState } from "preact/hooks";

/** Call after the next paint; in a page that is not shown, soon. */
export function afterPaint(work: () => void): void {
  if (document.hidden) setTimeout(work);
  else requestAnimationFrame(() => setTimeout(work));
}

/** Whether a part has been painted once: what it shows besides can come then, so that neither takes long. */
export function useAfterPaint(): boolean {
  const [painted, setPainted] = useState(false);
  useEffect(() => {
    let here = true;
    afterPaint(() => here && setPainted(true));
    return () => void (here = false);
  }, []);
  return painted;
}

/** Let the browser do what it waits for. */
export const breath = (): Promise<void> => new Promise((done) => setTimeout(done));
