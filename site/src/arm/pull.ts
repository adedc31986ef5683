// A pull up or down at a bar, by a finger or the mouse.

/** A shorter way (pixels) is a tap. */
const LEAST = 24;

/** The listener of a bar that reports which way it is pulled. Its `touch-action: pan-x` prevents scrolling. */
export function onPull(pulled: (way: "up" | "down") => void): (start: PointerEvent) => void {
  return (start) => {
    const over = new AbortController(); // of listeners on the window: the finger may lift anywhere
    const end = ({ type, clientX, clientY }: PointerEvent): void => {
      over.abort();
      const [across, down] = [clientX - start.clientX, clientY - start.clientY];
      if (type === "pointerup" && Math.abs(down) > Math.max(LEAST, Math.abs(across))) pulled(down < 0 ? "up" : "down");
    };
    for (const event of ["pointerup", "pointercancel"] as const) addEventListener(event, end, { signal: over.signal });
  };
}
