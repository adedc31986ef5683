// Show how many problems are stored for offline use, and store the others with a progress bar.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { loadSizes } from "../load.js";
import { language, message, type Message, textOf, say } from "../text/text.js";
import { cacheOf, fetchAll, filesOf, megabytes, missingOf, problemsIn, totalBytes, type BankFile } from "./keep.js";

/** Null at first; "impossible" if the browser stores nothing; else the cache, all files, and those that are missing. */
type StorageState =
  | null
  | "impossible"
  | { readonly cache: Cache; readonly files: readonly BankFile[]; readonly missing: readonly BankFile[] };

interface OfflineProps {
  readonly title: string;
  /** The problems, as "FAMILY/KEY". */
  readonly problems: readonly string[];
}

export function Offline({ title, problems }: OfflineProps): JSX.Element | null {
  const [isOpen, setOpen] = useState(false);
  return (
    <details class="offline" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {isOpen ? <Storing problems={problems} /> : null}
    </details>
  );
}

function Storing({ problems }: { problems: readonly string[] }): JSX.Element {
  const [known, setKnown] = useState<StorageState>(null);
  const [note, setNote] = useState<Message | null>(null);
  const [controller, setController] = useState<AbortController | null>(null);
  const left = useRef(new Set<BankFile>());
  const refresh = async (): Promise<void> => {
    const cache = await cacheOf();
    if (!cache) return setKnown("impossible");
    const files = filesOf(await loadSizes(), problems, language().code);
    setKnown({ cache, files, missing: await missingOf(cache, files) });
  };
  useEffect(() => {
    refresh().catch(() => setNote(message("offline.failed")));
    return () => controller?.abort();
  }, [problems]);

  if (known === "impossible") return <p>{say("offline.impossible")}</p>;
  if (known === null) return <p role="status">{textOf(note ?? message("practice.loading"))}</p>;
  const { cache, files, missing } = known;
  const start = async (): Promise<void> => {
    const room = await roomLeft();
    if (room !== null && room < totalBytes(missing))
      return setNote(message("offline.no-room", { room: megabytes(room), size: megabytes(totalBytes(missing)) }));
    setNote(null);
    const control = new AbortController();
    setController(control);
    left.current = new Set(missing);
    void navigator.storage?.persist?.().catch(() => false); // keeps the files when space is scarce
    const failed = await fetchAll(
      cache,
      missing,
      (file) => {
        left.current.delete(file);
        setKnown({ cache, files, missing: [...left.current] });
      },
      control.signal,
    );
    setController(null);
    if (failed > 0) setNote(message("offline.some-failed", { count: failed }));
  };
  const here = files.filter((file) => !missing.includes(file));
  const count = problemsIn(files) - problemsIn(missing);
  return (
    <>
      <p role="status">
        {missing.length === 0
          ? say("offline.all", { count: problemsIn(files), size: megabytes(totalBytes(files)) })
          : say("offline.some", {
              count,
              all: problemsIn(files),
              kept: megabytes(totalBytes(here)),
              size: megabytes(totalBytes(files)),
            })}{" "}
        {note ? textOf(note) : ""}
      </p>
      {controller || (here.length > 0 && missing.length > 0) ? (
        <progress max={totalBytes(files)} value={totalBytes(here)} aria-label={say("offline.progress")} />
      ) : null}
      {missing.length > 0 ? (
        <p class="actions">
          {controller ? (
            <Button style="quiet small" text={say("offline.stop")} onClick={() => controller.abort()} />
          ) : (
            <Button
              style="quiet small"
              text={say("offline.keep", { size: megabytes(totalBytes(missing)) })}
              onClick={() => void start()}
            />
          )}
        </p>
      ) : null}
      <p class="muted">{say("offline.until")}</p>
    </>
  );
}

/** Return the space that the browser offers, in bytes; null if unknown. */
async function roomLeft(): Promise<number | null> {
  try {
    const { quota, usage } = await navigator.storage.estimate();
    return quota === undefined ? null : quota - (usage ?? 0);
  } catch {
    return null;
  }
}
