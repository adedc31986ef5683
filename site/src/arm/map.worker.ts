// Compute one map of det J in a worker: first its values and lines, then the kinds of the lines.

import type { Arm, Pose } from "./model.js";
import { type JointPair, type ShownValue, type Terrain, terrainOf, stretchesWithKinds } from "./terrain.js";
import type { Stretch } from "./zeros.js";

/** A request: a map of an arm over two joints, the others as in a pose. */
export type MapRequest = {
  readonly arm: Arm;
  readonly pose: Pose;
  readonly pair: JointPair;
  readonly shownValue: ShownValue;
};

/** A response: the map, or its lines by kind. */
export type MapResponse = { readonly terrain: Terrain } | { readonly stretches: readonly Stretch[] };

const respond = (response: MapResponse): void => globalThis.postMessage(response);

globalThis.addEventListener("message", ({ data: { arm, pose, pair, shownValue } }: MessageEvent<MapRequest>) => {
  const terrain = terrainOf(arm, pose, pair, shownValue);
  respond({ terrain });
  respond({ stretches: stretchesWithKinds(arm, pose, pair, terrain) });
});
