// What every page does: it works offline after the first visit.

import { ROOT } from "../load.js";

export function startPage(): void {
  if ("serviceWorker" in navigator && window.isSecureContext) {
    window.addEventListener(
      "load",
      () => void navigator.serviceWorker.register(`${ROOT}sw.js`).catch(() => undefined),
    );
  }
}
