// The questions that were shown, in the browser's history: Back shows the last one again, and a reload the present one,
// with what was typed.

import { useEffect, useRef, useState } from "preact/hooks";

import { loadJson, resultOrNull, storeText } from "../storage.js";
import { listen } from "../scheduling.js";

const tabStorage: Storage | null = resultOrNull(() => window.sessionStorage);

type HistoryState = Readonly<Record<string, unknown>> | null;
const readHistory = (): HistoryState => window.history.state as HistoryState;

const navigation = performance.getEntriesByType("navigation")[0] as PerformanceNavigationTiming | undefined;
/** Whether the page was reloaded or returned to, and not opened by a link or its address. */
const isReturn = navigation?.type !== "navigate";

/** Return the number of the present visit of a question; 0 on pages without visits. */
export const visitNumber = (): number => Number(readHistory()?.visit ?? 0);

interface Visits<T> {
  readonly visit: T;
  /** Show something next; Back returns to the present visit. */
  readonly showNext: (next: T) => void;
  /** Change the present visit. */
  readonly replace: (changed: T) => void;
}

/** Keep what a part of the page shows in the browser's history; `choose` chooses it if nothing valid is there. */
export function useVisits<T>(
  name: string,
  choose: () => T,
  isValid: (visit: T) => boolean,
  onBack?: () => void,
): Visits<T> {
  const number = useRef((isReturn && visitNumber()) || Date.now());
  const readVisit = (): T | null => {
    const stored = readHistory()?.[name] as T | undefined;
    return stored !== undefined && isValid(stored) ? stored : null;
  };
  const write = (changed: T): T => {
    window.history.replaceState({ ...readHistory(), [name]: changed, visit: number.current }, "");
    return changed;
  };
  const [visit, setVisit] = useState(() => write((isReturn ? readVisit() : null) ?? choose()));
  const latestVisit = useRef(visit);
  latestVisit.current = visit;
  const replace = (changed: T): void => {
    if (latestVisit.current === visit) setVisit(write(changed)); // else this visit has ended meanwhile
  };
  const showNext = (next: T): void => {
    number.current = Date.now();
    window.history.pushState({ ...readHistory(), [name]: next, visit: number.current }, "");
    setVisit(next);
  };
  useEffect(() =>
    listen(window, "popstate", () => {
      const storedVisit = readVisit();
      if (storedVisit === null) return void write(visit); // a link within the page leads to the same visit
      number.current = visitNumber();
      setVisit(storedVisit);
      onBack?.();
    }),
  );
  return { visit, showNext, replace };
}

/**
 * Like `useState`, but the value is there again after a reload and after Back. `name` names the field; if it is "", the
 * value is not stored.
 */
export function useDraft<T>(name: string, initialValue: T): [T, (value: T) => void] {
  const usedStorage = name ? tabStorage : null;
  const [key] = useState(() => `qdot-draft ${visitNumber()} ${name}`);
  const [value, setValue] = useState(() =>
    loadJson(usedStorage, key, (stored) => (stored as T | null) ?? initialValue),
  );
  const changeValue = (newValue: T): void => {
    setValue(newValue);
    storeText(usedStorage, key, JSON.stringify(newValue));
  };
  return [value, changeValue];
}
