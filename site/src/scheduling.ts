// Work that waits until the page is painted, until a value has come to rest, or until something is loaded.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";

import { say } from "./text/text.js";

/** Call a function after the next paint; soon, if the page is hidden. */
export function afterPaint(work: () => void): void {
  if (document.hidden) setTimeout(work);
  else requestAnimationFrame(() => setTimeout(work));
}

/** Call a listener at each event of a target, until the returned function is called. */
export function listen<E extends Event>(target: EventTarget, name: string, listener: (event: E) => void): () => void {
  target.addEventListener(name, listener as (event: Event) => void);
  return () => target.removeEventListener(name, listener as (event: Event) => void);
}

/** Start what runs while a component is shown, again when `inputs` change; `start` returns how each ends. */
export const useRunning = (start: () => readonly (() => void)[], inputs?: readonly unknown[]): void =>
  useEffect(() => {
    const stops = start();
    return () => stops.forEach((stop) => stop());
  }, inputs);

/** Return whether the system asks for reduced motion, also if it can't be asked. */
export const prefersReducedMotion = (): boolean =>
  window.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? true;

/** Return how often a component was painted, up to `last`. It shows its parts step by step, so no step takes long. */
export function useSteps(last: number): number {
  const [step, setStep] = useState(0);
  useEffect(() => {
    if (step === last) return;
    let isMounted = true;
    afterPaint(() => isMounted && setStep(step + 1));
    return () => void (isMounted = false);
  }, [step]);
  return step;
}

/** Return a promise that lets the browser handle waiting events first. */
export const yieldToBrowser = (): Promise<void> => new Promise((done) => setTimeout(done));

/** Return a value that follows another value after it has not changed for some milliseconds. */
export function useDebounced<T>(value: T, milliseconds: number): T {
  const [settledValue, setSettled] = useState(value);
  const lastChange = useRef({ value, since: 0, timer: 0 });
  // One timer is checked and renewed while the value changes: a value may change in every frame.
  useLayoutEffect(() => {
    const current = lastChange.current;
    current.value = value;
    current.since = performance.now();
    const check = (): void => {
      const remaining = current.since + milliseconds - performance.now();
      current.timer = remaining > 0 ? window.setTimeout(check, remaining) : 0;
      if (remaining <= 0) setSettled(current.value);
    };
    if (!current.timer && value !== settledValue) current.timer = window.setTimeout(check, milliseconds);
  }, [value, milliseconds]);
  useEffect(() => () => clearTimeout(lastChange.current.timer), []);
  return settledValue;
}

/** Return in a sentence why something could not be loaded; browsers report a missing connection as a TypeError. */
export const describeLoadError = (error: unknown): string =>
  error instanceof TypeError ? say("practice.no-connection") : say("practice.failed", { why: String(error) });

/** A loaded value, null until it is loaded; the error in a sentence, or ""; and a function that loads the value again. */
type Loaded<T> = { readonly loaded: T | null; readonly error: string; readonly retry: () => void };

/** Load a value, and load it again whenever `inputs` change; the old value is kept until then. */
export function useLoaded<T>(load: () => Promise<T>, inputs: readonly unknown[]): Loaded<T> {
  const [loaded, setLoaded] = useState<T | null>(null);
  const [error, setError] = useState("");
  const lastRequest = useRef(0); // results for earlier inputs are dropped
  const retry = (): void => {
    const request = (lastRequest.current += 1);
    setError("");
    load().then(
      (value) => lastRequest.current === request && setLoaded(value),
      (reason: unknown) => lastRequest.current === request && setError(describeLoadError(reason)),
    );
  };
  useEffect(retry, inputs);
  return { loaded, error, retry };
}

/** Call `work` every so many milliseconds while `isOn`. */
export function useInterval(work: () => unknown, milliseconds: number, isOn = true): void {
  const latest = useRef(work);
  latest.current = work;
  useEffect(() => {
    if (!isOn) return;
    const timer = setInterval(() => latest.current(), milliseconds);
    return () => clearInterval(timer);
  }, [isOn, milliseconds]);
}
