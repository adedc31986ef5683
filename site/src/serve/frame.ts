// A session in the frame of a platform if the browser stores no cookies there: pages have its key, and send it.

import { listen } from "../scheduling.js";
import { loadText, resultOrNull, storeText } from "../storage.js";

const KEY = "qdot-session";
const tabStorage = resultOrNull(() => window.sessionStorage);
const field = document.querySelector<HTMLInputElement>("#session [name=session]");

/** The key of the session; "" if it is in a cookie. */
export const session = field?.value ?? "";

/** Open a page of the service, or download a file, as a link does. */
function open(address: string): void {
  field!.form!.action = address;
  field!.form!.submit();
}

/** Take the session along when the person follows a link, goes back, or loads the page again. */
export function keepSession(): void {
  const stored = loadText(tabStorage, KEY);
  if (session) {
    storeText(tabStorage, KEY, session);
    listen(document, "click", (event: MouseEvent) => {
      const link = (event.target as Element).closest("a");
      if (!link?.href.startsWith(`${window.location.origin}/`) || link.getAttribute("href")!.startsWith("#")) return;
      event.preventDefault();
      open(link.href);
    });
    // else the browser asks whether to send the form again
    if (loadText(tabStorage, KEY)) window.history.replaceState(window.history.state, "", window.location.href);
  } else if (stored && document.querySelector("#get-in")) {
    tabStorage?.removeItem(KEY); // it is tried once
    field!.value = stored;
    open(window.location.href);
  }
}
