// The state of a stage, the page's panel with the arm: the arm and its pose, what is pointed at, the layers and panes.

import { useCallback, useEffect, useMemo, useState } from "preact/hooks";

import type { Factor, NamedPose, Robot } from "../bank.js";
import { type DeterminantSizes, sizesOf } from "./factors.js";
import type { Layers } from "./marks.js";
import type { Arm, Measures, Pose, State } from "./model.js";
import { armOf, measuresOf, namedPose, reachOf, stateAt } from "./model.js";
import { whyNoPath, stationOn } from "./path.js";
import { firstPose, limitPose, widenRanges } from "./ranges.js";
import { useDebounced } from "../scheduling.js";
import { firstWeld, journeyOf, type Weld } from "./weld.js";

/** What the pane beside the drawing shows: sliders, J in numbers, the map of det J, the welding path, or the layers. */
export type Pane = "joints" | "jacobian" | "map" | "weld" | "layers";

/** What a page passes to its stage. */
export interface StageRequest {
  readonly robot: Robot;
  /** Values of joints and lengths at first, as in the figure or the question; by default the stage chooses a pose. */
  readonly firstPose?: NamedPose | undefined;
  /** A pose to go to, such as a counterexample. Whenever another pose is passed, the arm goes there. */
  readonly pose?: NamedPose | undefined;
  readonly onPose?: ((pose: NamedPose) => void) | undefined;
  readonly factors?: readonly Factor[] | undefined;
  /** Whether J in numbers, and layers that show J, would reveal the answer to the question. */
  readonly isConcealed?: boolean | undefined;
  /** Whether the map of det J would reveal the answer to the question. */
  readonly isMapHidden?: boolean | undefined;
  /** The layers at first, if they differ from the default. */
  readonly layers?: Partial<Layers> | undefined;
}

export interface Stage {
  readonly robot: Robot;
  readonly arm: Arm;
  /** The total length of all links (m). */
  readonly reach: number;
  readonly pose: Pose;
  /** The pose before the arm is moved: that of the figure or question, or the pose to go to. */
  readonly home: Pose;
  /** Whether `home` is a pose that the page asked to go to, such as a counterexample. */
  readonly isRequested: boolean;
  readonly state: State;
  readonly measures: Measures;
  /** The state after the arm has stopped moving: what is slow to compute, or spoken, follows this state. */
  readonly settledState: State;
  readonly sizes: () => DeterminantSizes;
  readonly move: (pose: Pose) => void;
  readonly reset: () => void;
  /** The joint that keys move, or -1 for the point P. */
  readonly chosenJoint: number;
  readonly choose: (joint: number) => void;
  /** The joint that is pointed at: its link, arrow and column are highlighted. */
  readonly highlightedJoint: number | null;
  readonly highlight: (joint: number | null) => void;
  readonly isConcealed: boolean;
  readonly layers: Layers;
  readonly toggle: (layer: keyof Layers) => void;
  readonly pane: Pane | null;
  readonly setPane: (pane: Pane | null) => void;
  readonly welding: Welding | null;
}

/** The welding path, the arm's place on it (distance in m), and how to change both. */
export interface Welding {
  readonly weld: Weld;
  readonly journey: ReturnType<typeof journeyOf>;
  readonly place: number;
  readonly changeWeld: (weld: Weld) => void;
  readonly goTo: (s: number) => void;
}

const FIRST_LAYERS: Layers = { frames: true, lengths: true, vectors: false, columns: true, ellipse: true };

/** With more joints, the names of axes and origins would pile up at the wrist; readers can still show them. */
const MAX_JOINTS_WITH_FRAMES = 4;

export function useStage(request: StageRequest, pane: Pane | null): Stage {
  const {
    robot: describedRobot,
    firstPose: firstValues,
    pose: requestedValues,
    onPose,
    factors,
    isConcealed = false,
  } = request;
  const requestKey = JSON.stringify(requestedValues ?? null);
  const [dismissedRequest, setDismissed] = useState(""); // the request at the time of the last return to the first pose
  const isDismissed = dismissedRequest === requestKey;
  const shownValues = { ...firstValues, ...(isDismissed ? {} : requestedValues) };
  // a question or counterexample may give values of symbolic lengths and angles, too
  const lengths = Object.entries(describedRobot.values).map(
    ([name, value]) => [name, shownValues[name] ?? value] as const,
  );
  const robot = useMemo(
    () => ({ ...describedRobot, values: Object.fromEntries(lengths) }),
    [describedRobot, JSON.stringify(lengths)],
  );
  const arm = useMemo(() => {
    const describedArm = armOf(robot);
    return widenRanges(
      describedArm,
      [firstValues, requestedValues].map((values) => poseToShow(describedArm, values)),
    );
  }, [robot, firstValues, requestKey]);
  const reach = useMemo(() => reachOf(arm), [arm]);
  const startPose = useMemo(() => (firstValues ? poseFrom(arm, firstValues) : firstPose(arm)), [arm, firstValues]);
  const sizes = useMemo(() => sizesOf(arm, robot, factors ?? []), [arm, factors]);
  const home = useMemo(
    () => (isDismissed ? startPose : poseFrom(arm, requestedValues, startPose)),
    [arm, startPose, requestKey, isDismissed],
  );
  const isRequested = !isDismissed && requestedValues !== undefined;
  const [pose, setPose] = useState<Pose>(home);
  const [chosenJoint, choose] = useState(0);
  const [highlightedJoint, highlight] = useState<number | null>(null);
  const [selectedLayers, setLayers] = useState<Layers>({
    ...FIRST_LAYERS,
    frames: arm.joints.length <= MAX_JOINTS_WITH_FRAMES,
    ...request.layers,
  });
  const layers = useMemo(
    () => (isConcealed ? { ...selectedLayers, columns: false, ellipse: false } : selectedLayers),
    [selectedLayers, isConcealed],
  );
  const [openPane, setOpenPane] = useState<Pane | null>(pane);
  const [weld, setWeld] = useState<Weld | null>(null);
  const [place, setPlace] = useState(0);

  useEffect(() => {
    if (!isDismissed) setDismissed("");
  }, [requestKey]);
  useEffect(() => {
    const hasSameJoints = pose.length === arm.joints.length;
    const nextPose =
      isDismissed && hasSameJoints
        ? pose
        : poseFrom(arm, requestedValues, hasSameJoints && requestedValues ? pose : startPose);
    if (nextPose.every((value, i) => Math.abs(value - (pose[i] ?? Infinity)) < 1e-9)) return;
    setWeld(null);
    setPose(nextPose);
  }, [arm, requestKey]);

  const state = useMemo(() => stateAt(arm, pose), [arm, pose]);
  const measures = useMemo(() => measuresOf(arm, state), [state]);
  const settledState = useDebounced(state, 700);
  const journey = useMemo(() => (weld ? journeyOf(arm, weld) : null), [arm, weld?.startPose, weld?.target]);

  // These functions stay the same between renderings, so that what receives them is not drawn again.
  const move = useCallback(
    (next: Pose): void => {
      setPose(next);
      onPose?.(namedPose(arm, next));
    },
    [arm, onPose],
  );
  const reset = useCallback(() => {
    setDismissed(requestKey);
    move(startPose);
  }, [move, startPose, requestKey]);
  const toggle = useCallback(
    (layer: keyof Layers): void => setLayers((before) => ({ ...before, [layer]: !before[layer] })),
    [],
  );
  const changeWeld = (next: Weld): void => {
    setWeld(next);
    setPlace(0);
    move(limitPose(arm, next.startPose));
  };
  const goTo = (s: number): void => {
    setPlace(s);
    if (journey) move(limitPose(arm, stationOn(journey, s).pose));
  };
  const setPane = (next: Pane | null): void => {
    setOpenPane(next);
    if (next === "weld" && !weld && !whyNoPath(arm)) {
      setWeld(firstWeld(arm, pose, reach));
      setPlace(0);
    }
  };
  useEffect(() => {
    if (pane === "weld") setPane("weld");
  }, []);
  return {
    ...{ robot, arm, reach, pose, home, isRequested, state, measures, settledState, sizes, move, reset },
    ...{ chosenJoint, choose, highlightedJoint, highlight, isConcealed, layers, toggle },
    pane: openPane,
    setPane,
    welding: openPane === "weld" && weld && journey ? { weld, journey, place, changeWeld, goTo } : null,
  };
}

/** Return a pose with the given joint values; other joints are where their table begins. */
const poseToShow = (arm: Arm, values: NamedPose | undefined): Pose =>
  arm.joints.map(({ name, kind, offset }) => values?.[name] ?? (kind === "P" ? -offset : 0));

/** Return a named pose within the joints' ranges; other joints are as in `fallback`, or 0. */
function poseFrom(arm: Arm, values: NamedPose | undefined, fallback: Pose = []): Pose {
  return limitPose(
    arm,
    arm.joints.map(({ name }, i) => values?.[name] ?? fallback[i] ?? 0),
  );
}
