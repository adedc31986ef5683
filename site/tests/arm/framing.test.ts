// The nearer view with which an arm is seen first.
import { describe, expect, it } from "vitest";

import {
  measureCrowding,
  edgesOf,
  bodiesOf,
  withFraming,
  framingOf,
  isSamePose,
  isInView,
  findReadableOrbit,
  reduceToShow,
} from "../../src/arm/framing.js";
import { drawnColumns } from "../../src/arm/marks.js";
import { armOf, reachOf, stateAt } from "../../src/arm/model.js";
import { extentOf, firstPose } from "../../src/arm/ranges.js";
import { add } from "../../src/arm/vector.js";
import { FIRST_ORBIT, planeNormalOf, ellipseOnPage, toPixel, viewOf } from "../../src/arm/view.js";
import { linesOfTool } from "../../src/learn/tools.js";
import { ELBOW, PLAIN, PUMA, ROBOTS, SIX } from "./robots.js";

const ALL = { ...ROBOTS, plain: PLAIN, elbow: ELBOW, six: SIX, puma: PUMA };
const SIZES = [
  [362, 150],
  [362, 286],
  [475, 420],
  [760, 420],
] as const;

describe.each(Object.entries(ALL))("the first view of %s", (_, robot) => {
  const arm = armOf(robot);
  const state = stateAt(arm, firstPose(arm));
  const heads = drawnColumns(arm, state, reachOf(arm)).map((arrow) => add(state.point, arrow));
  const isFlat = planeNormalOf(arm) !== null;

  it.each(SIZES)("shows the arm and its arrows in %i x %i pixels", (width, height) => {
    const whole = viewOf(arm, extentOf(arm), width, height, FIRST_ORBIT);
    const view = withFraming(whole, framingOf(arm, state, heads, whole, { isFlat }));
    expect(isInView(arm, state, view)).toBe(true);
    for (const head of heads) {
      const [x, y] = toPixel(view, head);
      expect(x > 0 && x < width && y > 0 && y < height).toBe(true);
    }
  });
});

it.each([...SIZES, [2000, 1100] as const])(
  "has the bodies of a PUMA 560 in %i x %i pixels, above the words",
  (width, height) => {
    const arm = armOf(PUMA);
    for (const pose of [firstPose(arm), firstPose(arm).map((value, i) => (i === 1 ? 1.5 : value))]) {
      const state = stateAt(arm, pose);
      const heads = drawnColumns(arm, state, reachOf(arm)).map((arrow) => add(state.point, arrow));
      const whole = viewOf(arm, extentOf(arm), width, height, FIRST_ORBIT);
      const view = withFraming(whole, framingOf(arm, state, heads, whole, { isFlat: false }));
      const [[left, right], [top, bottom]] = bodiesOf(arm, state, view);
      expect(bottom).toBeLessThanOrEqual(height - Math.min(28, 0.1 * height) + 1);
      expect(left > 0 && right < width && top > 0).toBe(true);
    }
  },
);

it("shows the whole ellipse, also beyond its arrows", () => {
  const arm = armOf(PUMA);
  const state = stateAt(arm, firstPose(arm));
  const arrows = drawnColumns(arm, state, reachOf(arm));
  const whole = viewOf(arm, extentOf(arm), 760, 420, FIRST_ORBIT);
  const ends = edgesOf(arrows, whole).map((edge) => add(state.point, edge));
  const view = withFraming(whole, framingOf(arm, state, ends, whole, { isFlat: false }));
  const ellipse = ellipseOnPage(view, arrows);
  const [x, y] = toPixel(view, state.point);
  const turn = (ellipse.rotation * Math.PI) / 180;
  const across = Math.hypot(ellipse.major * Math.cos(turn), ellipse.minor * Math.sin(turn));
  const high = Math.hypot(ellipse.major * Math.sin(turn), ellipse.minor * Math.cos(turn));
  expect(x - across > 0 && x + across < 760 && y - high > 0 && y + high < 420).toBe(true);
  const edges = edgesOf(arrows, view).map((edge) => toPixel(view, add(state.point, edge)));
  expect(edges[1]![0]).toBeCloseTo(x - across, 6);
  expect(edges[2]![1]).toBeCloseTo(y - high, 6);
});

it("shows a planar arm 1.5 times as large as the view of its whole reach", () => {
  const arm = armOf(PLAIN);
  const whole = viewOf(arm, extentOf(arm), 760, 420, FIRST_ORBIT);
  const { zoom } = framingOf(arm, stateAt(arm, firstPose(arm)), [], whole, { isFlat: true });
  expect(zoom).toBeGreaterThan(1.5);
});

it.each(SIZES)("shows all that lessons draw over a planar arm, in all poses, in %i x %i pixels", (width, height) => {
  const arm = armOf(PLAIN);
  const reach = reachOf(arm);
  const whole = viewOf(arm, extentOf(arm), width, height, FIRST_ORBIT);
  const angles = [-180, -135, -90, -45, 0, 45, 90, 135].map((angle) => (angle * Math.PI) / 180);
  for (const pose of angles.flatMap((first) => angles.map((second) => [first, second])))
    for (const tool of ["area", "rates", "links", "force"] as const) {
      const state = stateAt(arm, pose);
      const heads = drawnColumns(arm, state, reach).map((arrow) => add(state.point, arrow));
      const points = [...heads, ...linesOfTool(tool, { rates: [1, 1], direction: 30 }, { arm, state, reach }).flat()];
      expect(isInView(arm, state, reduceToShow(whole, points), points), `${tool} at ${pose}`).toBe(true);
    }
});

it("ends when the arm reaches the edge", () => {
  const arm = armOf(PLAIN);
  const state = stateAt(arm, firstPose(arm));
  const whole = viewOf(arm, extentOf(arm), 475, 420, FIRST_ORBIT);
  const view = withFraming(whole, framingOf(arm, state, [], whole, { isFlat: true }));
  const opposite = stateAt(arm, [state.pose[0]! + Math.PI, 0]);
  expect([isInView(arm, opposite, view), isInView(arm, opposite, whole)]).toEqual([false, true]);
  expect([isSamePose(state.pose, [...state.pose]), isSamePose(state.pose, opposite.pose)]).toEqual([true, false]);
});

it("contains the end of a path, and ends when that leaves it", () => {
  const arm = armOf(PLAIN);
  const state = stateAt(arm, firstPose(arm));
  const whole = viewOf(arm, extentOf(arm), 760, 420, FIRST_ORBIT);
  const far = [0, 1.1, 0] as const;
  const alone = withFraming(whole, framingOf(arm, state, [], whole, { isFlat: true }));
  const view = withFraming(whole, framingOf(arm, state, [far], whole, { isFlat: true }));
  expect([isInView(arm, state, alone, [far]), isInView(arm, state, view, [far])]).toEqual([false, true]);
});

describe("an arm that points at the reader", () => {
  const arm = armOf(SIX);
  const turns = (...degrees: number[]) => degrees.map((angle) => (angle * Math.PI) / 180);
  const stretched = stateAt(arm, turns(36, 24, 90, 0, 30, 0));

  it("is shown from the side", () => {
    expect(measureCrowding(arm, stretched, FIRST_ORBIT)).toBeCloseTo(1, 5);
    const orbit = findReadableOrbit(arm, stretched, FIRST_ORBIT);
    expect(measureCrowding(arm, stretched, orbit)).toBeLessThan(0.1);
    const whole = viewOf(arm, extentOf(arm), 560, 420, orbit);
    const view = withFraming(whole, framingOf(arm, stretched, [], whole, { isFlat: false }));
    expect(isInView(arm, stretched, view)).toBe(true);
  });

  it("is shown from the first direction in all other poses", () => {
    for (const pose of [turns(36, -20, 90, 0, 30, 0), turns(-60, 24, 90, 0, 30, 0), firstPose(arm)])
      expect(findReadableOrbit(arm, stateAt(arm, pose), FIRST_ORBIT)).toBe(FIRST_ORBIT);
  });
});

it("the ground of a planar arm is above the text at the foot of a low drawing", () => {
  const arm = armOf(PLAIN);
  const state = stateAt(arm, firstPose(arm));
  const whole = viewOf(arm, extentOf(arm), 362, 168, FIRST_ORBIT);
  const view = withFraming(whole, framingOf(arm, state, [], whole, { isFlat: true }));
  const [, base] = toPixel(view, arm.base.o);
  expect(base + 32).toBeLessThan(168 - 22); // the hatching, and a line of text
});
