// Undo and redo the moves of an arm: a step is everything between one press of a key or the pointer and the next.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import type { Pose } from "./model.js";

/** The poses before and after the present one; the nearest is the last. */
interface Steps {
  readonly past: readonly Pose[];
  readonly future: readonly Pose[];
}

const NO_STEPS: Steps = { past: [], future: [] };
const MAX_STEPS = 200;

export interface MoveHistory {
  readonly canUndo: boolean;
  readonly canRedo: boolean;
  /** Record the pose before a move; moves of one drag are one step. */
  readonly record: (pose: Pose) => void;
  /** Let the next move begin a step of its own. */
  readonly endStep: () => void;
  readonly clear: () => void;
  /** Return the pose one step back or forth, given the present one; null at the end. */
  readonly undo: (pose: Pose) => Pose | null;
  readonly redo: (pose: Pose) => Pose | null;
}

export function useMoveHistory(): MoveHistory {
  const steps = useRef(NO_STEPS);
  const isStepOpen = useRef(false);
  const [{ past, future }, show] = useState(NO_STEPS);
  useEffect(() => {
    const endStep = (event: Event): void => {
      if (!(event as KeyboardEvent).repeat) isStepOpen.current = false; // a key that is held down is one step
    };
    const starts = ["pointerdown", "keydown"] as const;
    for (const start of starts) window.addEventListener(start, endStep, { capture: true, passive: true });
    return () => starts.forEach((start) => window.removeEventListener(start, endStep, { capture: true }));
  }, []);
  const functions = useMemo(() => {
    const change = (next: Steps): void => show((steps.current = next));
    const endStep = (): void => void (isStepOpen.current = false);
    const travel = (pose: Pose, from: keyof Steps, to: keyof Steps): Pose | null => {
      const target = steps.current[from].at(-1);
      endStep();
      if (!target) return null;
      change({ [from]: steps.current[from].slice(0, -1), [to]: [...steps.current[to], pose] } as unknown as Steps);
      return target;
    };
    return {
      record: (pose: Pose): void => {
        if (isStepOpen.current) return;
        isStepOpen.current = true;
        change({ past: [...steps.current.past, pose].slice(-MAX_STEPS), future: [] });
      },
      endStep,
      clear: () => {
        endStep();
        if (steps.current !== NO_STEPS) change(NO_STEPS);
      },
      undo: (pose: Pose) => travel(pose, "past", "future"),
      redo: (pose: Pose) => travel(pose, "future", "past"),
    };
  }, []);
  return { canUndo: past.length > 0, canRedo: future.length > 0, ...functions };
}
