// A field on which a file is dropped, or which opens the dialog to choose one.

import type { JSX } from "preact";
import { useState } from "preact/hooks";

import { listen, useRunning } from "../scheduling.js";
import { say } from "../text/text.js";

interface DropFieldProps {
  readonly text: string;
  readonly isDisabled?: boolean;
  readonly onFiles: (files: FileList) => void;
}

export function DropField({ text, isDisabled = false, onFiles }: DropFieldProps): JSX.Element {
  const [isDragging, setDragging] = useState(false);
  // a file that is dropped beside the field would replace the page
  useRunning(() =>
    (["dragover", "dragleave", "drop"] as const).map((kind) =>
      listen(document, kind, (event: DragEvent) => {
        event.preventDefault();
        setDragging(kind === "dragover");
        if (kind === "drop" && event.dataTransfer?.files.length) onFiles(event.dataTransfer.files);
      }),
    ),
  );
  return (
    <label class={`drop ${isDragging ? "dragging" : ""}`}>
      <span>{text}</span> <span class="button">{say("check.choose")}</span>
      <input
        class="visually-hidden"
        type="file"
        disabled={isDisabled}
        onChange={({ currentTarget }) => {
          if (currentTarget.files?.length) onFiles(currentTarget.files);
          currentTarget.value = ""; // to choose the same file again
        }}
      />
    </label>
  );
}
