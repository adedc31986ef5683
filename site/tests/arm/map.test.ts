// @vitest-environment happy-dom
// The map of det J says what it is still working out: first where J is singular, then the kinds of the lines.

import { h, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, test, vi } from "vitest";

import { SingularMap, ticksOf } from "../../src/arm/map.js";
import type { MapRequest, MapResponse } from "../../src/arm/map.worker.js";
import { armOf, measuresOf, stateAt } from "../../src/arm/model.js";
import { stretchesWithKinds, terrainOf } from "../../src/arm/terrain.js";
import { PLAIN, ROBOTS } from "./robots.js";

afterEach(() => {
  render(null, document.body);
  vi.unstubAllGlobals();
});

test("the legend of the map names no kinds before they are known", () => {
  const worker: { respond?: (response: MapResponse) => void; request?: MapRequest } = {};
  vi.stubGlobal(
    "Worker",
    class {
      addEventListener(_: string, listener: (event: { data: MapResponse }) => void): void {
        worker.respond = (data) => void act(() => listener({ data }));
      }
      postMessage(request: MapRequest): void {
        worker.request = request;
      }
      terminate(): void {}
    },
  );
  HTMLCanvasElement.prototype.getContext = () => null;
  const arm = armOf(PLAIN);
  const pose = [0.5, 1];
  const measures = measuresOf(arm, stateAt(arm, pose));
  void act(() => render(h(SingularMap, { arm, pose, measures, move: () => undefined }), document.body));
  const legend = (): string => document.querySelector(".arm-legend")!.textContent!.trim();
  expect(legend()).toBe("Working out where J is singular …");
  const { pair, shownValue } = worker.request!;
  const terrain = terrainOf(arm, pose, pair, shownValue);
  worker.respond!({ terrain });
  expect(legend()).toContain("Working out which lines are boundary");
  worker.respond!({ stretches: stretchesWithKinds(arm, pose, pair, terrain) });
  expect(legend()).toBe("singular, at the boundary of the workspace");
});

test("ticks of a prismatic joint are round lengths, and those of a revolute one quarter turns", () => {
  const arm = armOf(ROBOTS["scara"]!);
  const [rotating, sliding] = ["R", "P"].map((kind) => arm.joints.findIndex((joint) => joint.kind === kind));
  expect(ticksOf(arm, rotating!, false).map(([, text]) => text)).toEqual(["−180°", "−90°", "0°", "90°", "180°"]);
  const values = ticksOf(arm, sliding!, false).map(([value]) => value);
  expect(values).toContain(0);
  expect(values.length).toBeGreaterThan(2);
  for (const value of values) expect(Math.abs(value * 20 - Math.round(value * 20))).toBeLessThan(1e-9);
});
