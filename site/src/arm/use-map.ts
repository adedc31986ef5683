// The map of det J as its worker delivers it: first nothing, then values and lines, then the kinds of the lines.

import { useEffect, useState } from "preact/hooks";

import type { MapRequest, MapResponse } from "./map.worker.js";
import type { Arm, Pose } from "./model.js";
import { type JointPair, type ShownValue, type Terrain, stretchesWithoutKinds } from "./terrain.js";
import type { Stretch } from "./zeros.js";

/** A map with the inputs for which it was computed. */
interface ComputedMap {
  readonly arm: Arm;
  readonly pair: JointPair;
  readonly shownValue: ShownValue;
  readonly terrain: Terrain;
  readonly stretches: readonly Stretch[];
  /** Whether the kinds of the lines are known, as far as they can be decided. */
  readonly hasKinds: boolean;
}

/** Return the map over two joints, computed when `settledKey` changes; until then the last such map, or null. */
export function useMap(
  arm: Arm,
  pose: Pose,
  pair: JointPair,
  shownValue: ShownValue,
  settledKey: string,
): ComputedMap | null {
  const [map, setMap] = useState<ComputedMap | null>(null);
  useEffect(() => {
    if (typeof Worker === "undefined") return; // the page works without the map
    const worker = new Worker(new URL("./map.worker.ts", import.meta.url), { type: "module" });
    worker.addEventListener("message", ({ data }: MessageEvent<MapResponse>) => {
      if ("terrain" in data) {
        const stretches = stretchesWithoutKinds(data.terrain);
        setMap({ arm, pair, shownValue, terrain: data.terrain, stretches, hasKinds: false });
        return;
      }
      setMap((previous) => previous && { ...previous, stretches: data.stretches, hasKinds: true });
      worker.terminate();
    });
    worker.postMessage({ arm, pose, pair, shownValue } satisfies MapRequest);
    return () => worker.terminate();
  }, [arm, pair.join(), shownValue, settledKey]);
  const isCurrent = map?.arm === arm && map.shownValue === shownValue && map.pair.join() === pair.join();
  return isCurrent ? map : null;
}
