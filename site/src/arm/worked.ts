// The map of det J as it comes from its worker: nothing, then values and lines, then the kinds of these.

import { useEffect, useMemo, useState } from "preact/hooks";

import type { Answer, Wanted } from "./map.worker.js";
import type { Arm, Pose } from "./model.js";
import { type Pair, type Shown, type Terrain, unsorted } from "./terrain.js";
import type { Stretch } from "./zeros.js";

/** A map with what it was worked out for. */
interface Worked {
  readonly arm: Arm;
  readonly pair: Pair;
  readonly shown: Shown;
  readonly terrain: Terrain;
  readonly kinds: readonly Stretch[];
}

/** The map over two joints once `settled` rests; until it is there, the last one over the same joints, else null. */
export function useMap(arm: Arm, rest: Pose, pair: Pair, shown: Shown, settled: string): Worked | null {
  const [worked, setWorked] = useState<Worked | null>(null);
  useEffect(() => {
    if (typeof Worker === "undefined") return; // a page without the map is still a page
    const worker = new Worker(new URL("./map.worker.ts", import.meta.url), { type: "module" });
    worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => {
      if ("terrain" in data) {
        setWorked({ arm, pair, shown, terrain: data.terrain, kinds: unsorted(data.terrain) });
        return;
      }
      setWorked((before) => before && { ...before, kinds: data.kinds });
      worker.terminate();
    });
    worker.postMessage({ arm, pose: rest, pair, shown } satisfies Wanted);
    return () => worker.terminate();
  }, [arm, pair.join(), shown, settled]);
  return useMemo(
    () =>
      worked && worked.arm === arm && worked.shown === shown && worked.pair.join() === pair.join() ? worked : null,
    [worked, arm, pair.join(), shown],
  );
}
