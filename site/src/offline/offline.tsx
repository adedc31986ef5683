// Show how many problems are stored for offline use, and store the rest with a progress bar.

import type { JSX } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { Button } from "../button.js";
import { loadSizes } from "../load.js";
import { language, message, type Message, said, say } from "../text/text.js";
import { cacheOf, fetchAll, filesOf, megabytes, missingOf, problemsIn, sum, type Wanted } from "./keep.js";

/** What is known: nothing yet, that nothing can be kept, or the cache with all files and those that are missing. */
type Known =
  null | "impossible" | { readonly cache: Cache; readonly all: readonly Wanted[]; readonly missing: readonly Wanted[] };

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
      {isOpen ? <Keeping problems={problems} /> : null}
    </details>
  );
}

function Keeping({ problems }: { problems: readonly string[] }): JSX.Element {
  const [known, setKnown] = useState<Known>(null);
  const [told, setTold] = useState<Message | null>(null);
  const [going, setGoing] = useState<AbortController | null>(null);
  const left = useRef(new Set<Wanted>());
  const look = async (): Promise<void> => {
    const cache = await cacheOf();
    if (!cache) return setKnown("impossible");
    const all = filesOf(await loadSizes(), problems, language().code);
    setKnown({ cache, all, missing: await missingOf(cache, all) });
  };
  useEffect(() => {
    look().catch(() => setTold(message("offline.failed")));
    return () => going?.abort();
  }, [problems]);

  if (known === "impossible") return <p>{say("offline.impossible")}</p>;
  if (known === null) return <p role="status">{said(told ?? message("practice.loading"))}</p>;
  const { cache, all, missing } = known;
  const start = async (): Promise<void> => {
    const room = await roomLeft();
    if (room !== null && room < sum(missing))
      return setTold(message("offline.no-room", { room: megabytes(room), size: megabytes(sum(missing)) }));
    setTold(null);
    const control = new AbortController();
    setGoing(control);
    left.current = new Set(missing);
    void navigator.storage?.persist?.().catch(() => false); // that it stays when room gets scarce
    const failed = await fetchAll(
      cache,
      missing,
      (file) => {
        left.current.delete(file);
        setKnown({ cache, all, missing: [...left.current] });
      },
      control.signal,
    );
    setGoing(null);
    if (failed > 0) setTold(message("offline.some-failed", { count: failed }));
  };
  const here = all.filter((file) => !missing.includes(file));
  const count = problemsIn(all) - problemsIn(missing);
  return (
    <>
      <p role="status">
        {missing.length === 0
          ? say("offline.all", { count: problemsIn(all), size: megabytes(sum(all)) })
          : say("offline.some", {
              count,
              all: problemsIn(all),
              kept: megabytes(sum(here)),
              size: megabytes(sum(all)),
            })}{" "}
        {told ? said(told) : ""}
      </p>
      {going || (here.length > 0 && missing.length > 0) ? (
        <progress max={sum(all)} value={sum(here)} aria-label={say("offline.progress")} />
      ) : null}
      {missing.length > 0 ? (
        <p class="actions">
          {going ? (
            <Button style="quiet small" text={say("offline.stop")} onClick={() => going.abort()} />
          ) : (
            <Button
              style="quiet small"
              text={say("offline.keep", { size: megabytes(sum(missing)) })}
              onClick={() => void start()}
            />
          )}
        </p>
      ) : null}
      <p class="muted">{say("offline.until")}</p>
    </>
  );
}

/** The room that the browser still gives, in bytes; null where it does not tell. */
async function roomLeft(): Promise<number | null> {
  try {
    const { quota, usage } = await navigator.storage.estimate();
    return quota === undefined ? null : quota - (usage ?? 0);
  } catch {
    return null;
  }
}
