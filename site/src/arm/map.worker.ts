// Compute one map of det J in a worker: first its values and lines, then the kinds of the lines.

import type { Arm, Pose } from "./model.js";
import { type Pair, type Shown, sorted, type Terrain, terrainOf } from "./terrain.js";
import type { Stretch } from "./zeros.js";

/** What is wanted: a map of an arm over two joints, the others as in a pose. */
export type Wanted = { readonly arm: Arm; readonly pose: Pose; readonly pair: Pair; readonly shown: Shown };

/** What comes back: the map, then its lines by kind. */
export type Answer = { readonly terrain: Terrain } | { readonly kinds: readonly Stretch[] };

const tell = (answer: Answer): void => globalThis.postMessage(answer);

globalThis.addEventListener("message", ({ data }: MessageEvent<Wanted>) => {
  const { arm, pose, pair, shown } = data;
  const terrain = terrainOf(arm, pose, pair, shown);
  tell({ terrain });
  tell({ kinds: sorted(arm, pose, pair, terrain) });
});
