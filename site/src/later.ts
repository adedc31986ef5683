// Work that can wait until what was changed is painted, or until the browser has done what it waits for.

import { useEffect, useState } from "preact/hooks";

/** Call after the next paint; in a page that is not shown, soon. */
export function afterPaint(work: () => void): void {
  if (document.hidden) setTimeout(work);
  else requestAnimationFrame(() => setTimeout(work));
}

/** How often a part has been painted, up to `last`: what it shows comes piece by piece, so that none takes long. */
export function useSteps(last: number): number {
  const [step, setStep] = useState(0);
  useEffect(() => {
    if (step === last) return;
    let here = true;
    afterPaint(() => here && setStep(step + 1));
    return () => void (here = false);
  }, [step]);
  return step;
}

/** Let the browser do what it waits for. */
export const breath = (): Promise<void> => new Promise((done) => setTimeout(done));
