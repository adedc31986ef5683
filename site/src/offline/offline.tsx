// Show how many problems are stored for offline use, and store the others with a progress bar.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../controls.js";
import { loadSizes } from "../load.js";
import { getLanguage, message, type Message, textOf, say } from "../text/text.js";
import type { BankFile } from "./cache.js";
import { openCache, fetchAll, listFiles, roundToMegabytes, listMissing, countProblems, sumBytes } from "./cache.js";

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
      {isOpen ? <StoredProblems problems={problems} /> : null}
    </details>
  );
}

function StoredProblems({ problems }: { problems: readonly string[] }): JSX.Element {
  const [storageState, setStorageState] = useState<StorageState>(null);
  const [note, setNote] = useState<Message | null>(null);
  const [controller, setController] = useState<AbortController | null>(null);
  const filesLeft = useRef(new Set<BankFile>());
  const refresh = async (): Promise<void> => {
    const cache = await openCache();
    if (!cache) return setStorageState("impossible");
    const files = listFiles(await loadSizes(), problems, getLanguage().code);
    setStorageState({ cache, files, missing: await listMissing(cache, files) });
  };
  useEffect(() => {
    refresh().catch(() => setNote(message("offline.failed")));
    return () => controller?.abort();
  }, [problems]);

  if (storageState === "impossible") return <p>{say("offline.impossible")}</p>;
  if (storageState === null) return <p role="status">{textOf(note ?? message("practice.loading"))}</p>;
  const { cache, files, missing } = storageState;
  const start = async (): Promise<void> => {
    const room = await estimateRoom();
    if (room !== null && room < sumBytes(missing))
      return setNote(
        message("offline.no-room", { room: roundToMegabytes(room), size: roundToMegabytes(sumBytes(missing)) }),
      );
    setNote(null);
    const newController = new AbortController();
    setController(newController);
    filesLeft.current = new Set(missing);
    void navigator.storage?.persist?.().catch(() => false); // keeps the files when space is scarce
    const failed = await fetchAll(
      cache,
      missing,
      (file) => {
        filesLeft.current.delete(file);
        setStorageState({ cache, files, missing: [...filesLeft.current] });
      },
      newController.signal,
    );
    setController(null);
    if (failed > 0) setNote(message("offline.some-failed", { count: failed }));
  };
  const storedFiles = files.filter((file) => !missing.includes(file));
  const storedCount = countProblems(files) - countProblems(missing);
  return (
    <>
      <p role="status">
        {missing.length === 0
          ? say("offline.all", { count: countProblems(files), size: roundToMegabytes(sumBytes(files)) })
          : say("offline.some", {
              count: storedCount,
              all: countProblems(files),
              kept: roundToMegabytes(sumBytes(storedFiles)),
              size: roundToMegabytes(sumBytes(files)),
            })}{" "}
        {note ? textOf(note) : ""}
      </p>
      {controller || (storedFiles.length > 0 && missing.length > 0) ? (
        <progress max={sumBytes(files)} value={sumBytes(storedFiles)} aria-label={say("offline.progress")} />
      ) : null}
      {missing.length > 0 ? (
        <p class="actions">
          {controller ? (
            <Button className="quiet small" text={say("offline.stop")} onClick={() => controller.abort()} />
          ) : (
            <Button
              className="quiet small"
              text={say("offline.keep", { size: roundToMegabytes(sumBytes(missing)) })}
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
async function estimateRoom(): Promise<number | null> {
  try {
    const { quota, usage } = await navigator.storage.estimate();
    return quota === undefined ? null : quota - (usage ?? 0);
  } catch {
    return null;
  }
}
