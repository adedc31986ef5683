// The manipulator on the page: its drawing, sliders and numbers, the map of det J, and the welding task, in one piece.

import "./arm.css";

import type { JSX } from "preact";
import { useEffect, useId, useMemo, useState } from "preact/hooks";

import type { Robot, SymbolInfo } from "../bank.js";
import { ENGLISH, type Language } from "../text/text.js";
import { Drawing } from "./drawing.js";
import { Figures } from "./figures.js";
import { Joints } from "./joints.js";
import { Lengths } from "./lengths.js";
import { SingularMap } from "./map.js";
import { LAYERS, type Layers } from "./marks.js";
import { type Arm as Model, armOf, measuresOf, type Pose, reachOf, stateAt } from "./model.js";
import { obstacle, stationOn } from "./path.js";
import { firstPose, poseWithin } from "./ranges.js";
import { Route } from "./route.js";
import { useRested } from "./size.js";
import { sayIn, Spoken, useSay } from "./speech.js";
import { firstWeld, journeyOf, type Weld, Welding } from "./weld.js";
import { inWords } from "./words.js";

/** Values of joint variables, and of letters of the table if they differ from the robot's, as counterexamples have them. */
export type NamedPose = Readonly<Record<string, number>>;

export interface ArmProps {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  /** A pose to draw, such as a counterexample; when another is given, the arm goes there. */
  readonly pose?: NamedPose | undefined;
  readonly onPose?: ((pose: NamedPose) => void) | undefined;
  readonly language?: Language | undefined;
}

export function Arm(props: ArmProps): JSX.Element {
  return (
    <Spoken.Provider value={props.language ?? ENGLISH}>
      <Panel {...props} />
    </Spoken.Provider>
  );
}

type Sheet = "map" | "weld";

function Panel({ robot: drawn, symbols, pose: given, onPose, language = ENGLISH }: ArmProps): JSX.Element {
  const say = useSay();
  const letters = JSON.stringify(Object.keys(drawn.values).map((name) => given?.[name]));
  const robot = useMemo(() => withLetters(drawn, given), [drawn, letters]);
  const arm = useMemo(() => armOf(robot), [robot]);
  const reach = useMemo(() => reachOf(arm), [arm]);
  const first = useMemo(() => firstPose(arm), [arm]);
  const [pose, setPose] = useState<Pose>(() => told(arm, given, first));
  const [chosen, setChosen] = useState(0);
  const [layers, setLayers] = useState<Layers>({
    frames: true,
    vectors: false,
    columns: true,
    ellipse: true,
  });
  const [sheet, setSheet] = useState<Sheet | null>("map");
  const [weld, setWeld] = useState<Weld | null>(null);
  const [place, setPlace] = useState(0);
  const ids = useId();

  useEffect(() => {
    const next = told(arm, given, pose.length === arm.joints.length && given ? pose : first);
    if (next.every((value, i) => Math.abs(value - (pose[i] ?? Infinity)) < 1e-9)) return;
    setWeld(null);
    setPose(next);
  }, [arm, given && JSON.stringify(given)]);

  const state = useMemo(() => stateAt(arm, pose), [arm, pose]);
  const measures = useMemo(() => measuresOf(state), [state]);
  const rested = useRested(state, 700);
  const words = useMemo(() => inWords(arm, rested, sayIn(language)), [arm, rested, language]);
  const journey = useMemo(() => (weld ? journeyOf(arm, weld) : null), [arm, weld?.from, weld?.target]);

  const move = (next: Pose): void => {
    setPose(next);
    onPose?.(Object.fromEntries(arm.joints.map(({ name }, i) => [name, next[i]!])));
  };
  const goTo = (s: number): void => {
    setPlace(s);
    if (journey) move(poseWithin(arm, stationOn(journey, s).pose));
  };
  const changeWeld = (next: Weld): void => {
    setWeld(next);
    setPlace(0);
    move(poseWithin(arm, next.from));
  };
  const open = (next: Sheet): void => {
    setSheet(sheet === next ? null : next);
    if (next === "weld" && !weld && !obstacle(arm)) {
      setWeld(firstWeld(arm, pose, reach));
      setPlace(0);
    }
  };
  const welding = sheet === "weld" && weld && journey ? { weld, journey } : null;
  const blocked = obstacle(arm);
  return (
    <section class="arm" aria-label={say("arm.title", { robot: robot.title })}>
      <div class="arm-panel">
        <div class="arm-main-part">
          <Drawing
            arm={arm}
            state={state}
            reach={reach}
            layers={layers}
            chosen={chosen}
            onChoose={setChosen}
            onPose={move}
            label={say("arm.drawing.label", { robot: robot.title })}
            describedBy={`${ids}words`}
            target={
              welding
                ? { at: welding.weld.target, move: (target) => changeWeld({ ...welding.weld, target }) }
                : undefined
            }
            overlay={
              welding ? (view) => <Route journey={welding.journey} view={view} place={place} /> : undefined
            }
          />
          <fieldset class="arm-layers">
            <legend>{say("arm.layers")}</legend>
            {LAYERS.map((layer) => (
              <label key={layer}>
                <input
                  type="checkbox"
                  checked={layers[layer]}
                  onChange={() => setLayers({ ...layers, [layer]: !layers[layer] })}
                />
                {say(`arm.layer.${layer}`)}
              </label>
            ))}
            <button type="button" onClick={() => move(first)}>
              {say("arm.reset")}
            </button>
          </fieldset>
        </div>
        <div class="arm-side">
          <Figures arm={arm} state={state} measures={measures} rested={rested} />
          <Joints arm={arm} pose={pose} chosen={chosen} onChoose={setChosen} onPose={move} />
          <Lengths robot={robot} symbols={symbols} />
        </div>
        <div class="arm-sheets">
          <div class="arm-tabs">
            {(["map", "weld"] as const).map((name) => (
              <button
                key={name}
                type="button"
                aria-expanded={sheet === name}
                aria-controls={`${ids}${name}`}
                onClick={() => open(name)}
              >
                {say(`arm.${name}.title`)}
              </button>
            ))}
          </div>
          <div id={`${ids}map`} hidden={sheet !== "map"}>
            {sheet === "map" &&
              (arm.joints.length > 1 ? (
                <SingularMap arm={arm} pose={pose} measures={measures} onPose={move} />
              ) : (
                <p>{say("arm.map.one")}</p>
              ))}
          </div>
          <div id={`${ids}weld`} hidden={sheet !== "weld"}>
            {welding && (
              <Welding
                arm={arm}
                pose={pose}
                reach={reach}
                place={place}
                onWeld={changeWeld}
                onPlace={goTo}
                {...welding}
              />
            )}
            {blocked && <p>{say(`arm.weld.not-${blocked}`)}</p>}
          </div>
        </div>
        <details class="arm-words">
          <summary>{say("arm.words.title")}</summary>
          <p>{words}</p>
        </details>
      </div>
      <p id={`${ids}words`} class="arm-unseen" role="status" aria-live="polite">
        {words}
      </p>
    </section>
  );
}

/** The robot with the lengths and angles that a counterexample tells for the letters of its table. */
function withLetters(robot: Robot, given: NamedPose | undefined): Robot {
  const values = Object.entries(robot.values).map(([name, value]) => [name, given?.[name] ?? value] as const);
  return { ...robot, values: Object.fromEntries(values) };
}

/** A told pose, joints that it leaves out as in the first one. */
function told(arm: Model, given: NamedPose | undefined, first: Pose): Pose {
  return poseWithin(
    arm,
    arm.joints.map(({ name }, i) => given?.[name] ?? first[i]!),
  );
}
