// Work that can wait until what was changed is painted, or until the browser has done what it waits for.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";

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

/** A value that follows another once that has rested for some milliseconds. */
export function useRested<T>(value: T, milliseconds: number): T {
  const [rested, setRested] = useState(value);
  const last = useRef({ value, since: 0, timer: 0 });
  // One timer for as long as it changes, which is asked again when it is over: a value may change in every frame.
  useLayoutEffect(() => {
    const now = last.current;
    now.value = value;
    now.since = performance.now();
    const look = (): void => {
      const left = now.since + milliseconds - performance.now();
      now.timer = left > 0 ? window.setTimeout(look, left) : 0;
      if (left <= 0) setRested(now.value);
    };
    if (!now.timer && value !== rested) now.timer = window.setTimeout(look, milliseconds);
  }, [value, milliseconds]);
  useEffect(() => () => clearTimeout(last.current.timer), []);
  return rested;
}

/** What is loaded, null until it is there; why it could not be loaded; and a way to try once more. */
export type Loaded<T> = { readonly found: T | null; readonly failed: string; readonly again: () => void };

/** Load something, and load it anew whenever `inputs` change; what came before stays until then. */
export function useLoaded<T>(load: () => Promise<T>, inputs: readonly unknown[]): Loaded<T> {
  const [found, setFound] = useState<T | null>(null);
  const [failed, setFailed] = useState("");
  const wanted = useRef(0); // what comes for earlier inputs is dropped
  const again = (): void => {
    const mine = (wanted.current += 1);
    setFailed("");
    load().then(
      (value) => wanted.current === mine && setFound(value),
      (error: unknown) => wanted.current === mine && setFailed(String(error)),
    );
  };
  useEffect(again, inputs);
  return { found, failed, again };
}
