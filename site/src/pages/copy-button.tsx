// A button that copies a text and confirms it, and the download of a text as a file.

import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { say } from "../text/text.js";

/** How long the confirmation is shown (milliseconds). */
const CONFIRMATION_TIME = 3000;

export function CopyButton({ text, label }: { text: string; label: string }): JSX.Element {
  const [confirmation, setConfirmation] = useState<"" | "page.copied" | "page.not-copied">("");
  useEffect(() => {
    if (!confirmation) return;
    const timer = setTimeout(() => setConfirmation(""), CONFIRMATION_TIME);
    return () => clearTimeout(timer);
  }, [confirmation]);
  const copy = (): void => {
    const copying = navigator.clipboard?.writeText(text) ?? Promise.reject(new Error("no clipboard"));
    copying.then(
      () => setConfirmation("page.copied"),
      () => setConfirmation("page.not-copied"),
    );
  };
  return (
    <span class="copied">
      <Button className="quiet small" text={label} onClick={copy} />{" "}
      <span role="status" class="muted">
        {confirmation ? say(confirmation) : ""}
      </span>
    </span>
  );
}

/** Download a text as a file. */
export function saveFile(name: string, type: string, text: string): void {
  const address = URL.createObjectURL(new Blob([text], { type }));
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}
