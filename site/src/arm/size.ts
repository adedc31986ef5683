// The size of an element in pixels, kept up to date, and whether the system asks for reduced motion.

import { useEffect, useLayoutEffect, useState } from "preact/hooks";

import { listen } from "../scheduling.js";

type Size = readonly [width: number, height: number];

export function useSize(element: { readonly current: Element | null }, first: Size): Size {
  const [size, setSize] = useState(first);
  const update = (width: number, height: number): void => {
    if (width > 0 && height > 0)
      setSize((before) => (before[0] === width && before[1] === height ? before : [width, height]));
  };
  useLayoutEffect(() => {
    if (element.current) update(element.current.clientWidth, element.current.clientHeight); // before it is seen
  }, []);
  useEffect(() => {
    if (!element.current) return;
    const watched = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      update(Math.round(width), Math.round(height));
    });
    watched.observe(element.current);
    return () => watched.disconnect();
  }, []);
  return size;
}

/** Return whether the system asks for reduced motion. */
export function useReducedMotion(): boolean {
  const [isReduced, setStill] = useState(false);
  useEffect(() => {
    const query = matchMedia("(prefers-reduced-motion: reduce)");
    const update = (): void => setStill(query.matches);
    update();
    return listen(query, "change", update);
  }, []);
  return isReduced;
}
