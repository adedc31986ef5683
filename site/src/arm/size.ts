// The size of a drawing in its own pixels, kept up to date. These grow with the font of the page, so that letters, ticks
// and lines are as large as the words beside them, also on the widest screens.

import { useEffect, useLayoutEffect, useState } from "preact/hooks";

/** The root element's font size (pixels) at which a pixel of a drawing is one of the page. */
const BASE_FONT_SIZE = 17;

let knownScale: number | null = null; // to measure it, the browser has to finish all styles, in the middle of a move
globalThis.addEventListener?.("resize", () => (knownScale = null));

/** Return how many pixels of the page a pixel of a drawing has. */
export const drawingScale = (): number =>
  (knownScale ??= parseFloat(getComputedStyle(document.documentElement).fontSize) / BASE_FONT_SIZE || 1);

type Size = readonly [width: number, height: number];

export function useSize(element: { readonly current: Element | null }, firstSize: Size): Size {
  const [size, setSize] = useState(firstSize);
  const update = (pageWidth: number, pageHeight: number): void => {
    const [width, height] = [pageWidth / drawingScale(), pageHeight / drawingScale()];
    if (width > 0 && height > 0)
      setSize((previous) => (previous[0] === width && previous[1] === height ? previous : [width, height]));
  };
  useLayoutEffect(() => {
    if (element.current) update(element.current.clientWidth, element.current.clientHeight); // before it is seen
  }, []);
  useEffect(() => {
    if (!element.current) return;
    const observer = new ResizeObserver(([entry]) => {
      knownScale = null; // a reader's larger font may be why
      const { width, height } = entry!.contentRect;
      update(Math.round(width), Math.round(height));
    });
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return size;
}
