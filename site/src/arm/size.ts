// The size of an element in pixels, kept up to date.

import { useEffect, useLayoutEffect, useState } from "preact/hooks";

type Size = readonly [width: number, height: number];

export function useSize(element: { readonly current: Element | null }, firstSize: Size): Size {
  const [size, setSize] = useState(firstSize);
  const update = (width: number, height: number): void => {
    if (width > 0 && height > 0)
      setSize((previous) => (previous[0] === width && previous[1] === height ? previous : [width, height]));
  };
  useLayoutEffect(() => {
    if (element.current) update(element.current.clientWidth, element.current.clientHeight); // before it is seen
  }, []);
  useEffect(() => {
    if (!element.current) return;
    const observer = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      update(Math.round(width), Math.round(height));
    });
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return size;
}
