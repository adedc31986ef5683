// The state of a stage, the page's panel with the arm: the arm and its pose, what is pointed at, the layers and panes.

import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";

import type { Factor, NamedPose, Robot } from "../bank.js";
import { type DeterminantSizes, sizesOf } from "./factors.js";
import { useMoveHistory } from "./history.js";
import type { Layers } from "./marks.js";
import type { Arm, Measures, Pose, State } from "./model.js";
import { armOf, measuresOf, namedPose, reachOf, stateAt } from "./model.js";
import { whyNoPath, stationOn } from "./path.js";
import { firstPose, limitPose, widenRanges } from "./ranges.js";
import { useDebounced } from "../scheduling.js";
import { extendTrace, NO_TRACE, type Trace } from "./trace.js";
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
  /** Whether det J and its map would reveal the answer to the question. */
  readonly isDeterminantHidden?: boolean | undefined;
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
  /** Undo or redo a move of the arm; a drag is one move. */
  readonly travel: (way: "undo" | "redo") => void;
  readonly canTravel: Readonly<Record<"undo" | "redo", boolean>>;
  /** Where P was while the arm was moved. */
  readonly trace: Trace;
  /** Change a symbolic length or angle (m or rad); the pose stays. */
  readonly setLength: (name: string, value: number) => void;
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

const FIRST_LAYERS: Layers = {
  ...{ frames: true, lengths: true, vectors: false, columns: true, ellipse: true, trace: false },
};
const NO_LENGTHS: NamedPose = {};

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
  const questionRobot = useMemo(
    () => ({ ...describedRobot, values: Object.fromEntries(lengths) }),
    [describedRobot, JSON.stringify(lengths)],
  );
  const [changedLengths, setLengths] = useState(NO_LENGTHS); // by the reader
  const robot = useMemo(
    () =>
      changedLengths === NO_LENGTHS
        ? questionRobot
        : { ...questionRobot, values: { ...questionRobot.values, ...changedLengths } },
    [questionRobot, changedLengths],
  );
  const armWithRanges = (robotToShow: Robot): Arm => {
    const describedArm = armOf(robotToShow);
    return widenRanges(
      describedArm,
      [firstValues, requestedValues].map((values) => poseToShow(describedArm, values)),
    );
  };
  const questionArm = useMemo(() => armWithRanges(questionRobot), [questionRobot, firstValues, requestKey]);
  const arm = useMemo(
    () => (robot === questionRobot ? questionArm : armWithRanges(robot)),
    [robot, questionRobot, questionArm],
  );
  const reach = useMemo(() => reachOf(arm), [arm]);
  const startPose = useMemo(
    () => (firstValues ? poseFrom(questionArm, firstValues) : firstPose(questionArm)),
    [questionArm, firstValues],
  );
  const sizes = useMemo(() => sizesOf(arm, robot, factors ?? []), [arm, factors]);
  const home = useMemo(
    () => (isDismissed ? startPose : poseFrom(questionArm, requestedValues, startPose)),
    [questionArm, startPose, requestKey, isDismissed],
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

  const history = useMoveHistory();
  const [trace, setTrace] = useState(NO_TRACE);
  useEffect(() => {
    if (!isDismissed) setDismissed("");
  }, [requestKey]);
  useEffect(() => setLengths(NO_LENGTHS), [describedRobot, firstValues, requestKey]);
  useEffect(() => setTrace(NO_TRACE), [arm]);
  useEffect(() => {
    const hasSameJoints = pose.length === arm.joints.length;
    const nextPose =
      isDismissed && hasSameJoints
        ? pose
        : poseFrom(arm, requestedValues, hasSameJoints && requestedValues ? pose : startPose);
    if (nextPose.every((value, i) => Math.abs(value - (pose[i] ?? Infinity)) < 1e-9)) return;
    setWeld(null);
    history.endStep();
    if (hasSameJoints && requestedValues) history.record(pose);
    history.endStep();
    setPose(nextPose);
  }, [questionArm, requestKey]);
  useEffect(() => history.clear(), [describedRobot]);

  const state = useMemo(() => stateAt(arm, pose), [arm, pose]);
  const measures = useMemo(() => measuresOf(arm, state), [state]);
  const settledState = useDebounced(state, 700);
  const journey = useMemo(() => (weld ? journeyOf(arm, weld) : null), [arm, weld?.startPose, weld?.target]);

  // These functions stay the same between renderings, so that what receives them is not drawn again.
  const currentPose = useRef(pose);
  currentPose.current = pose;
  const goToPose = useCallback(
    (next: Pose): void => {
      currentPose.current = next; // several moves may come before the next rendering
      setPose(next);
      onPose?.(namedPose(arm, next));
    },
    [arm, onPose],
  );
  const move = useCallback(
    (next: Pose): void => {
      const before = currentPose.current;
      if (next.some((value, i) => value !== before[i])) history.record(before);
      setTrace((trace) => extendTrace(trace, arm, before, next));
      goToPose(next);
    },
    [arm, goToPose],
  );
  const reset = useCallback(() => {
    setDismissed(requestKey);
    setLengths(NO_LENGTHS);
    history.endStep();
    move(startPose);
    history.endStep();
    setTrace(NO_TRACE);
  }, [move, startPose, requestKey]);
  const travel = useCallback(
    (way: "undo" | "redo"): void => {
      const target = history[way](currentPose.current);
      if (target) goToPose(target);
    },
    [goToPose],
  );
  const canTravel = useMemo(
    () => ({ undo: history.canUndo, redo: history.canRedo }),
    [history.canUndo, history.canRedo],
  );
  const setLength = useCallback(
    (name: string, value: number): void => setLengths((before) => ({ ...before, [name]: value })),
    [],
  );
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
    ...{ travel, canTravel, trace, setLength },
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
