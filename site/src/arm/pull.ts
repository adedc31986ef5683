// Detect a pull up or down on a bar, by a finger or the mouse.

/** A shorter pull (pixels) is a tap. */
const MIN_DISTANCE = 24;

/** Return the pointerdown listener of a bar that reports pulls. The bar's `touch-action: pan-x` prevents scrolling. */
export function onPull(report: (way: "up" | "down") => void): (start: PointerEvent) => void {
  return (start) => {
    const controller = new AbortController(); // on the window: the finger may be lifted anywhere
    const endPull = ({ type, clientX, clientY }: PointerEvent): void => {
      controller.abort();
      const [pixelsAcross, pixelsDown] = [clientX - start.clientX, clientY - start.clientY];
      if (type === "pointerup" && Math.abs(pixelsDown) > Math.max(MIN_DISTANCE, Math.abs(pixelsAcross)))
        report(pixelsDown < 0 ? "up" : "down");
    };
    for (const event of ["pointerup", "pointercancel"] as const)
      addEventListener(event, endPull, { signal: controller.signal });
  };
}
