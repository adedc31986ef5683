// The state of a stage in one place: the arm, its pose, what is pointed at, what is shown of it, and what is beside it.

import { useCallback, useEffect, useMemo, useState } from "preact/hooks";

import type { Factor, NamedPose, Robot } from "../bank.js";
import { type Sizes, sizesOf } from "./factors.js";
import type { Layers } from "./marks.js";
import {
  type Arm,
  armOf,
  type Measures,
  measuresOf,
  namedPose,
  type Pose,
  reachOf,
  type State,
  stateAt,
} from "./model.js";
import { obstacle, stationOn } from "./path.js";
import { firstPose, poseWithin, withRoom } from "./ranges.js";
import { useRested } from "../later.js";
import { firstWeld, journeyOf, type Weld } from "./weld.js";

/** What is beside the drawing: sliders, J in numbers, the map of det J, the welding path, what the drawing shows. */
export type Pane = "joints" | "jacobian" | "map" | "weld" | "layers";

export interface StageWish {
  readonly robot: Robot;
  /** The first pose and lengths of the arm, as its figure or its question has them; chosen by us if there are none. */
  readonly first?: NamedPose | undefined;
  /** A pose to go to, such as a counterexample: when another is given, the arm goes there. */
  readonly pose?: NamedPose | undefined;
  readonly onPose?: ((pose: NamedPose) => void) | undefined;
  readonly factors?: readonly Factor[] | undefined;
  /** Whether J in numbers, and what is drawn of it, would tell what is asked. */
  readonly concealed?: boolean | undefined;
  /** What is shown first, where that is not as everywhere. */
  readonly layers?: Partial<Layers> | undefined;
}

export interface Stage {
  readonly robot: Robot;
  readonly arm: Arm;
  readonly reach: number;
  readonly pose: Pose;
  /** Where the arm stands before it is moved: as its figure or its question has it, or at the pose to go to. */
  readonly home: Pose;
  /** Whether that is a pose that it was told to go to. */
  readonly isSent: boolean;
  readonly state: State;
  readonly measures: Measures;
  readonly rested: State;
  readonly sizes: () => Sizes;
  readonly move: (pose: Pose) => void;
  readonly reset: () => void;
  /** The joint that keys move, -1 for the point. */
  readonly chosen: number;
  readonly choose: (joint: number) => void;
  /** The joint that is pointed at: its link, its arrow and its column stand out. */
  readonly lit: number | null;
  readonly point: (joint: number | null) => void;
  readonly concealed: boolean;
  readonly layers: Layers;
  readonly toggle: (layer: keyof Layers) => void;
  readonly pane: Pane | null;
  readonly open: (pane: Pane | null) => void;
  readonly welding: Welding | null;
}

export interface Welding {
  readonly weld: Weld;
  readonly journey: ReturnType<typeof journeyOf>;
  readonly place: number;
  readonly change: (weld: Weld) => void;
  readonly goTo: (s: number) => void;
}

export const FIRST_LAYERS: Layers = { frames: true, lengths: true, vectors: false, columns: true, ellipse: true };

export function useStage(wish: StageWish, pane: Pane | null): Stage {
  const { robot: told, first: printed, pose: given, onPose, factors, concealed = false, layers: wished } = wish;
  const asked = JSON.stringify(given ?? null);
  const [left, setLeft] = useState(""); // what was asked for when the first pose, with its lengths, was gone back to
  const isBack = left === asked;
  const numbers = { ...printed, ...(isBack ? {} : given) };
  const letters = JSON.stringify(Object.keys(told.values).map((name) => numbers[name]));
  const robot = useMemo(() => withLetters(told, numbers), [told, letters]);
  const arm = useMemo(() => {
    const arm = armOf(robot);
    return withRoom(arm, [toldIn(arm, printed), toldIn(arm, given)]);
  }, [robot, printed, asked]);
  const reach = useMemo(() => reachOf(arm), [arm]);
  const first = useMemo(() => (printed ? posed(arm, printed) : firstPose(arm)), [arm, printed]);
  const sizes = useMemo(() => sizesOf(arm, robot, factors ?? []), [arm, factors]);
  const home = useMemo(() => (isBack ? first : posed(arm, given, first)), [arm, first, asked, isBack]);
  const isSent = !isBack && given !== undefined;
  const [pose, setPose] = useState<Pose>(home);
  const [chosen, choose] = useState(0);
  const [lit, point] = useState<number | null>(null);
  const [chosenLayers, setLayers] = useState<Layers>({ ...FIRST_LAYERS, ...wished });
  const layers = useMemo(
    () => (concealed ? { ...chosenLayers, columns: false, ellipse: false } : chosenLayers),
    [chosenLayers, concealed],
  );
  const [opened, setOpened] = useState<Pane | null>(pane);
  const [weld, setWeld] = useState<Weld | null>(null);
  const [place, setPlace] = useState(0);

  useEffect(() => {
    if (!isBack) setLeft("");
  }, [asked]);
  useEffect(() => {
    const isSame = pose.length === arm.joints.length;
    const next = isBack && isSame ? pose : posed(arm, given, isSame && given ? pose : first);
    if (next.every((value, i) => Math.abs(value - (pose[i] ?? Infinity)) < 1e-9)) return;
    setWeld(null);
    setPose(next);
  }, [arm, asked]);

  const state = useMemo(() => stateAt(arm, pose), [arm, pose]);
  const measures = useMemo(() => measuresOf(state), [state]);
  const rested = useRested(state, 700);
  const journey = useMemo(() => (weld ? journeyOf(arm, weld) : null), [arm, weld?.from, weld?.target]);

  // What stays the same function is no reason to show anew what it is given to.
  const move = useCallback(
    (next: Pose): void => {
      setPose(next);
      onPose?.(namedPose(arm, next));
    },
    [arm, onPose],
  );
  const reset = useCallback(() => {
    setLeft(asked);
    move(first);
  }, [move, first, asked]);
  const toggle = useCallback(
    (layer: keyof Layers): void => setLayers((before) => ({ ...before, [layer]: !before[layer] })),
    [],
  );
  const change = (next: Weld): void => {
    setWeld(next);
    setPlace(0);
    move(poseWithin(arm, next.from));
  };
  const goTo = (s: number): void => {
    setPlace(s);
    if (journey) move(poseWithin(arm, stationOn(journey, s).pose));
  };
  const open = (next: Pane | null): void => {
    setOpened(next);
    if (next === "weld" && !weld && !obstacle(arm)) {
      setWeld(firstWeld(arm, pose, reach));
      setPlace(0);
    }
  };
  useEffect(() => {
    if (pane === "weld") open("weld");
  }, []);
  return {
    ...{ robot, arm, reach, pose, home, isSent, state, measures, rested, sizes, move, reset },
    ...{ chosen, choose, lit, point, concealed, layers, toggle },
    pane: opened,
    open,
    welding: opened === "weld" && weld && journey ? { weld, journey, place, change, goTo } : null,
  };
}

/** The robot with the lengths and angles that a question or a counterexample tells for the letters of its table. */
function withLetters(robot: Robot, given: NamedPose): Robot {
  const values = Object.entries(robot.values).map(([name, value]) => [name, given[name] ?? value] as const);
  return { ...robot, values: Object.fromEntries(values) };
}

/** What is told of the joints; of the others, where their tables begin. */
const toldIn = (arm: Arm, given: NamedPose | undefined): Pose =>
  arm.joints.map(({ name, kind, offset }) => given?.[name] ?? (kind === "P" ? -offset : 0));

/** A named pose; joints that it leaves out are as in another pose, or 0. */
function posed(arm: Arm, given: NamedPose | undefined, other: Pose = []): Pose {
  const pose = arm.joints.map(({ name }, i) => given?.[name] ?? other[i] ?? 0);
  return poseWithin(arm, pose);
}
