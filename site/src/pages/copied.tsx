// Texts that are taken along: a button that copies one, and says so, and a file.

import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";

import { Button } from "../button.js";
import { say } from "../text/text.js";

/** How long it is said that a text was copied, in milliseconds. */
const SHOWN = 3000;

export function Copied({ text, label }: { text: string; label: string }): JSX.Element {
  const [told, setTold] = useState<"" | "page.copied" | "page.not-copied">("");
  useEffect(() => {
    if (!told) return;
    const timer = setTimeout(() => setTold(""), SHOWN);
    return () => clearTimeout(timer);
  }, [told]);
  const copy = (): void => {
    const done = navigator.clipboard?.writeText(text) ?? Promise.reject(new Error("no clipboard"));
    done.then(
      () => setTold("page.copied"),
      () => setTold("page.not-copied"),
    );
  };
  return (
    <span class="copied">
      <Button style="quiet small" text={label} onClick={copy} />{" "}
      <span role="status" class="muted">
        {told ? say(told) : ""}
      </span>
    </span>
  );
}

/** Give the reader a text as a file. */
export function saveFile(name: string, type: string, text: string): void {
  const address = URL.createObjectURL(new Blob([text], { type }));
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}
