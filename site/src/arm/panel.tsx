// The stage: the arm with its layers, numbers, map of det J and welding path. Its height is --stage if the page sets
// it.

import "./arm.css";

import type { ComponentChildren, JSX } from "preact";
import { useSteps } from "../later.js";
import { memo } from "../memo.js";
import { useId, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import type { NamedPose, SymbolInfo } from "../bank.js";
import type { State } from "./model.js";
import { inDigits, say, type TextKey } from "../text/text.js";
import { Answering } from "./answering.js";
import { Drawing } from "./drawing.js";
import { Figures } from "./figures.js";
import { Jacobian } from "./jacobian.js";
import { Joints } from "./joints.js";
import { Lengths } from "./lengths.js";
import { SingularMap } from "./map.js";
import { LAYERS, type Layers } from "./marks.js";
import { obstacle, pointOn } from "./path.js";
import { onPull } from "./pull.js";
import { useSize } from "./size.js";
import { digits, InRadians } from "./speech.js";
import { type Pane, type Stage, type StageWish, useStage } from "./stage.js";
import type { View } from "./view.js";
import { Route, Welding } from "./weld.js";
import { inWords, nearness, poseAndPoint, sizeName } from "./words.js";

export type { NamedPose };

export interface ArmProps extends StageWish {
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  /** Whether angles are in radians: of sliders and map, and where the pose is spoken. */
  readonly radians?: boolean | undefined;
  /** The pane that is open first, where that is not as everywhere. */
  readonly pane?: Pane | null | undefined;
  /** The rates of the joints in a pose, where the page has them. */
  readonly rates?: ((state: State) => readonly number[]) | undefined;
  /** Told of the stage whenever something of it has changed. */
  readonly onStage?: ((stage: Stage) => void) | undefined;
  /** What is drawn besides. */
  readonly over?: ((stage: Stage, view: View) => ComponentChildren) | undefined;
}

/** The stage; what is around it may be told of every move, and shows the same arm on. */
export const Arm = memo((props: ArmProps): JSX.Element => (
  <InRadians.Provider value={props.radians ?? false}>
    <Panel {...props} />
  </InRadians.Provider>
));

/** From so many pixels on, numbers and sliders are beside the map or the path; below, one pane is open at a time. */
const WIDE = 600;

const TITLES: Readonly<Record<Pane, TextKey>> = {
  joints: "arm.joints",
  jacobian: "arm.jacobian.tab",
  map: "arm.map.tab",
  weld: "arm.weld.tab",
  layers: "arm.layers",
};

function Panel(props: ArmProps): JSX.Element {
  const { radians = false, symbols } = props;
  const box = useRef<HTMLElement>(null);
  const [width] = useSize(box, [720, 600]);
  const scene = useRef<HTMLDivElement>(null); // the place of the drawing, which is measured before it is there
  const [room, setRoom] = useState<readonly [number, number]>();
  useLayoutEffect(() => {
    const { clientWidth = 0, clientHeight = 0 } = scene.current ?? {};
    if (clientWidth > 0 && clientHeight > 0) setRoom([clientWidth, clientHeight]);
  }, []);
  const wide = width >= WIDE;
  const [first] = useState(() => (isNarrowPage() ? null : (props.pane ?? "map")));
  const stage = useStage(props, first);
  const { onStage, over } = props;
  // In the same frame as the drawing.
  useLayoutEffect(() => onStage?.(stage), [stage.state, stage.rested, stage.welding?.place, stage.welding?.weld]);
  const { arm, robot, rested, welding, concealed } = stage;
  const shown = { layers: stage.layers, concealed, toggle: stage.toggle, reset: stage.reset };
  const [folded, setFolded] = useState(false);
  const pull = onPull((way) => setFolded(way === "up"));
  const words = useMemo(() => {
    return concealed ? poseAndPoint(arm, rested, radians) : inWords(arm, rested, radians);
  }, [arm, rested, radians, concealed]);
  const ids = useId();
  const panes: Pane[] = wide ? ["map", "weld"] : ["joints", "jacobian", "map", "weld", "layers"];
  const open = wide && !panes.includes(stage.pane!) ? null : stage.pane; // sliders and J are there anyway
  const sliders = (
    <>
      <Joints {...stage} />
      <Figures {...stage} isToldAside={wide && open === "map"} />
      <Lengths robot={robot} symbols={symbols} />
    </>
  );
  const step = useSteps(1); // what the arm is, and its room; then all that is shown of it
  if (step === 0)
    return (
      <>
        <section ref={box} class="arm" aria-busy="true">
          <div class="arm-panel">
            <div ref={scene} class="arm-scene" />
          </div>
        </section>
      </>
    );
  return (
    <>
      <section
        ref={box}
        class="arm"
        aria-label={say("arm.title", { robot: robot.title })}
        data-pane={open ?? ""}
        data-wide={wide ? "" : undefined}
        data-folded={folded ? "" : undefined}
      >
        <div class="arm-panel">
          {wide ? <Shown {...shown} /> : null}
          <div class="arm-scene">
            <Drawing
              {...stage}
              room={room}
              near
              readout={wide || concealed ? null : <Readout {...stage} />}
              label={say("arm.drawing.label", { robot: robot.title })}
              describedBy={`${ids}words`}
              target={
                welding
                  ? {
                      from: pointOn(welding.journey.path, 0),
                      at: welding.weld.target,
                      move: (target) => welding.change({ ...welding.weld, target }),
                    }
                  : undefined
              }
              overlay={(view) => (
                <>
                  {welding ? <Route journey={welding.journey} view={view} place={welding.place} /> : null}
                  {over?.(stage, view)}
                </>
              )}
            />
          </div>
          <div class="arm-strip">
            {wide ? (
              <div class="arm-side">
                {concealed ? null : <Jacobian {...stage} />}
                {sliders}
              </div>
            ) : null}
            <div class="arm-sheets">
              <div class="arm-tabs" onPointerDown={wide ? undefined : pull}>
                {panes.map((name) => (
                  <button
                    key={name}
                    type="button"
                    aria-expanded={open === name}
                    aria-controls={`${ids}pane`}
                    onClick={() => stage.open(open === name ? null : name)}
                  >
                    {say(TITLES[name])}
                  </button>
                ))}
                {wide ? null : (
                  <button type="button" class="arm-fold" aria-expanded={!folded} onClick={() => setFolded(!folded)}>
                    {folded ? (
                      say("arm.unfold")
                    ) : (
                      <>
                        <span aria-hidden="true">▴</span>
                        <span class="arm-unseen">{say("arm.fold")}</span>
                      </>
                    )}
                  </button>
                )}
              </div>
              <div id={`${ids}pane`} class="arm-pane" hidden={open === null}>
                {open === "joints" ? sliders : null}
                {open === "jacobian" ? <Numbers stage={stage} /> : null}
                {open === "map" ? <Map stage={stage} /> : null}
                {open === "weld" ? <Path stage={stage} /> : null}
                {open === "layers" ? <Shown {...shown} /> : null}
              </div>
            </div>
          </div>
        </div>
        <p id={`${ids}words`} class="arm-unseen" role="status" aria-live="polite">
          {words}
        </p>
      </section>
      <Answering stage={stage} radians={radians} rates={props.rates} />
    </>
  );
}

/** Whether arm and words are one above the other, where a pane would take the room of the words. */
const isNarrowPage = (): boolean => typeof matchMedia === "function" && matchMedia("(max-width: 56.24rem)").matches;

/** What is shown in the drawing, and the way back to the first pose. */
const Shown = memo((props: Pick<Stage, "layers" | "concealed" | "toggle" | "reset">): JSX.Element => {
  const { layers, concealed, toggle, reset } = props;
  return (
    <div class="arm-layers" role="group" aria-label={say("arm.layers")}>
      {LAYERS.filter((layer) => !concealed || !OF_J.has(layer)).map((layer) => (
        <label key={layer}>
          <input type="checkbox" checked={layers[layer]} onChange={() => toggle(layer)} />
          {say(`arm.layer.${layer}`)}
        </label>
      ))}
      <button type="button" class="arm-reset" onClick={reset}>
        {say("arm.reset")}
      </button>
    </div>
  );
});

/** What is drawn of J. */
const OF_J: ReadonlySet<keyof Layers> = new Set(["columns", "ellipse"]);

/** det J in a line over the drawing, where its pane may be closed. */
function Readout({ arm, measures }: Stage): JSX.Element {
  const value = inDigits(digits(measures.det ?? measures.volume));
  return (
    <p class={`arm-readout arm-${nearness(arm, measures)}-pose`} aria-hidden="true">
      {say(sizeName(arm))} = {value}
    </p>
  );
}

function Numbers({ stage }: { stage: Stage }): JSX.Element {
  return (
    <div class="arm-numbers">
      {stage.concealed ? null : <Jacobian {...stage} />}
      <Figures {...stage} />
    </div>
  );
}

function Map({ stage }: { stage: Stage }): JSX.Element {
  if (stage.concealed) return <p class="arm-concealed">{say("arm.concealed")}</p>;
  if (stage.arm.joints.length < 2) return <p>{say("arm.map.one")}</p>;
  return <SingularMap {...stage} />;
}

function Path({ stage }: { stage: Stage }): JSX.Element {
  const { arm, welding } = stage;
  const blocked = obstacle(arm);
  return (
    <>
      {welding ? <Welding {...stage} {...welding} /> : null}
      {blocked ? <p>{say(`arm.weld.not-${blocked}`)}</p> : null}
    </>
  );
}
