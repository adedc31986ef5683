// The stage of the page: the arm with layers, numbers, map of det J and welding path. CSS sets its height by --stage.

import "./arm.css";

import type { ComponentChildren, JSX } from "preact";
import { useSteps } from "../scheduling.js";
import { memo } from "../pace.js";
import { useId, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";

import type { SymbolInfo } from "../bank.js";
import type { State } from "./model.js";
import { formatNumber, say, type TextKey } from "../text/text.js";
import { TermLinks } from "./term-links.js";
import { Drawing } from "./drawing.js";
import { Figures } from "./figures.js";
import { Jacobian } from "./jacobian.js";
import { Joints } from "./joints.js";
import { Lengths } from "./lengths.js";
import { Words } from "./letters.js";
import { SingularMap } from "./map.js";
import { LAYERS, type Layers } from "./marks.js";
import { whyNoPath, pointOn } from "./path.js";
import { onPull } from "./pull.js";
import { drawingScale, useSize } from "./size.js";
import { roundToDigits, InRadians } from "./number-format.js";
import { type Pane, type Stage, type StageRequest, useStage } from "./stage.js";
import type { Vec3 } from "./vector.js";
import type { View } from "./view.js";
import { Route, Welding } from "./weld.js";
import { describeArm, classifyNearness, describePose, sizeKey } from "./descriptions.js";

export interface ArmProps extends StageRequest {
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  /** Whether sliders, map and the spoken pose use radians. */
  readonly inRadians?: boolean | undefined;
  /** What the reader doesn't know yet, and everything that needs it: it is not shown. */
  readonly unknown?: Unknown | undefined;
  /** The pane that is open first, by default the map. */
  readonly pane?: Pane | null | undefined;
  /** The joint rates at a state of the arm, if the page sets them. */
  readonly rates?: ((state: State) => readonly number[]) | undefined;
  /** Called with the stage after each change. */
  readonly onStage?: ((stage: Stage) => void) | undefined;
  readonly overlay?: Overlay | undefined;
}

/** What a page draws over the arm, and its lines at a state of the arm: they must be visible, and labels avoid them. */
export interface Overlay {
  readonly draw: (stage: Stage, view: View) => ComponentChildren;
  readonly linesAt: (stage: OverlayStage) => readonly (readonly Vec3[])[];
}

export type OverlayStage = Pick<Stage, "arm" | "robot" | "reach" | "state">;

/** What a lesson has not introduced yet: J with everything that comes from it, or only its determinant. */
export type Unknown = "jacobian" | "determinant";

export const Arm = memo((props: ArmProps): JSX.Element => (
  <InRadians.Provider value={props.inRadians ?? false}>
    <Panel {...props} />
  </InRadians.Provider>
));

/** From this width (pixels) on, numbers and sliders stand beside the map or path; else one pane is open at a time. */
const MIN_WIDE_PANEL = 600;

const TITLES: Readonly<Record<Pane, TextKey>> = {
  joints: "arm.joints",
  jacobian: "arm.jacobian.tab",
  map: "arm.map.tab",
  weld: "arm.weld.tab",
  layers: "arm.layers",
};

function Panel(props: ArmProps): JSX.Element {
  const { inRadians = false, symbols, isDeterminantHidden = false } = props;
  const box = useRef<HTMLElement>(null);
  const [width] = useSize(box, [720, 600]);
  const emptyScene = useRef<HTMLDivElement>(null); // an empty element, measured before the drawing is in it
  const [sceneSize, setSceneSize] = useState<readonly [number, number]>();
  useLayoutEffect(() => {
    const { clientWidth = 0, clientHeight = 0 } = emptyScene.current ?? {};
    if (clientWidth > 0 && clientHeight > 0)
      setSceneSize([clientWidth / drawingScale(), clientHeight / drawingScale()]);
  }, []);
  const isWide = width >= MIN_WIDE_PANEL;
  const { unknown } = props;
  const isOfPoseOnly = unknown !== undefined || isDeterminantHidden; // the numbers, without det J
  const needsPane = unknown === "determinant" && props.pane === "jacobian"; // J is small, and what the text is about
  const [firstPane] = useState(() => (isNarrowPage() && !needsPane ? null : (props.pane ?? "map")));
  const stage = useStage(unknown === "jacobian" ? { ...props, isConcealed: true } : props, firstPane);
  const { onStage, overlay } = props;
  // In the same frame as the drawing.
  useLayoutEffect(() => onStage?.(stage), [stage.state, stage.settledState, stage.welding?.place, stage.welding?.weld]);
  const { arm, robot, settledState, welding, isConcealed } = stage;
  const { layers, toggle, reset, travel, canTravel } = stage;
  const [firstLayers] = useState(layers);
  const offered = LAYERS.filter(
    (layer) =>
      !(isConcealed && LAYERS_OF_J.has(layer)) &&
      !(unknown && LAYERS_OF_LATER_LESSONS.has(layer) && !firstLayers[layer]),
  );
  const layerProps = { layers, offered, toggle, reset, travel, canTravel };
  const [isFolded, setFolded] = useState(false);
  const startPull = onPull((way) => setFolded(way === "up"));
  const description = useMemo(() => {
    const describe = isConcealed || isOfPoseOnly ? describePose : describeArm;
    return describe(arm, settledState, inRadians);
  }, [arm, settledState, inRadians, isConcealed, isOfPoseOnly]);
  const ids = useId();
  const allPanes: Pane[] = isWide ? ["map", "weld"] : ["joints", "jacobian", "map", "weld", "layers"];
  const panes = allPanes.filter((pane) => !unknown || !PANES_OF_UNKNOWN[unknown].has(pane));
  const openPane = isWide && !panes.includes(stage.pane!) ? null : stage.pane; // sliders and J are always shown
  const lengths = <Lengths robot={robot} symbols={symbols} onLength={stage.setLength} />;
  const sliders = (
    <>
      <Joints {...stage} />
      <Figures {...stage} isExplainedBeside={isWide && openPane === "map"} isOfPoseOnly={isOfPoseOnly} />
      {isWide ? null : lengths}
    </>
  );
  const step = useSteps(1); // first the arm's title and room, then everything else
  if (step === 0)
    return (
      <section ref={box} class="arm" aria-busy="true">
        <div class="arm-panel">
          <div ref={emptyScene} class="arm-scene" />
        </div>
      </section>
    );
  return (
    <>
      <section
        ref={box}
        class="arm"
        aria-label={say("arm.title", { robot: robot.title })}
        data-pane={openPane ?? ""}
        data-wide={isWide ? "" : undefined}
        data-folded={isFolded ? "" : undefined}
      >
        <div class="arm-panel">
          {isWide ? <LayerControls {...layerProps} /> : null}
          <div class="arm-scene">
            <Drawing
              {...stage}
              knownSize={sceneSize}
              isEnlarged
              isConcealed={isConcealed || (isDeterminantHidden && !stage.isRequested)} // feedback shows the lost direction
              readout={isWide || isConcealed || isOfPoseOnly ? null : <Readout {...stage} />}
              label={say("arm.drawing.label", { robot: robot.title })}
              describedBy={`${ids}words`}
              target={
                welding
                  ? {
                      start: pointOn(welding.journey.path, 0),
                      end: welding.weld.target,
                      move: (target) => welding.changeWeld({ ...welding.weld, target }),
                    }
                  : undefined
              }
              overlay={(view) => (
                <>
                  {welding ? <Route journey={welding.journey} view={view} place={welding.place} /> : null}
                  {overlay?.draw(stage, view)}
                </>
              )}
              overlayLinesAt={overlay && ((state) => overlay.linesAt({ ...stage, state }))}
            />
          </div>
          <div class="arm-strip">
            {isWide ? (
              <div class="arm-side">
                {isConcealed ? null : <Jacobian {...stage} />}
                {sliders}
              </div>
            ) : null}
            <div class="arm-sheets">
              <div class="arm-tabs" onPointerDown={isWide ? undefined : startPull}>
                {panes.map((name) => (
                  <button
                    key={name}
                    type="button"
                    aria-expanded={openPane === name}
                    aria-controls={`${ids}pane`}
                    onClick={() => stage.setPane(openPane === name ? null : name)}
                  >
                    {say(TITLES[name])}
                  </button>
                ))}
                {isWide ? null : (
                  <button type="button" class="arm-fold" aria-expanded={!isFolded} onClick={() => setFolded(!isFolded)}>
                    {isFolded ? (
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
              <div id={`${ids}pane`} class="arm-pane" hidden={openPane === null}>
                {openPane === "joints" ? sliders : null}
                {openPane === "jacobian" ? <Numbers stage={stage} isOfPoseOnly={isOfPoseOnly} /> : null}
                {openPane === "map" ? <Map stage={stage} isHidden={isDeterminantHidden} /> : null}
                {openPane === "weld" ? <Path stage={stage} /> : null}
                {openPane === "layers" ? <LayerControls {...layerProps} /> : null}
              </div>
            </div>
            {isWide ? lengths : null}
          </div>
        </div>
        <p id={`${ids}words`} class="arm-unseen" role="status" aria-live="polite">
          {description}
        </p>
      </section>
      <TermLinks stage={stage} inRadians={inRadians} rates={props.rates} />
    </>
  );
}

/** Return whether the arm is above the text, so that an open pane would cover the text. */
const isNarrowPage = (): boolean => typeof matchMedia === "function" && matchMedia("(max-width: 56.24rem)").matches;

type LayerControlsProps = Pick<Stage, "layers" | "toggle" | "reset" | "travel" | "canTravel"> & {
  readonly offered: readonly (keyof Layers)[];
};

/** The layers of the drawing, and buttons that undo or redo a move and return to the first pose. */
const LayerControls = memo((props: LayerControlsProps): JSX.Element => {
  const { layers, offered, toggle, reset, travel, canTravel } = props;
  return (
    <div class="arm-layers" role="group" aria-label={say("arm.layers")}>
      {offered.map((layer) => (
        <label key={layer}>
          <input type="checkbox" checked={layers[layer]} onChange={() => toggle(layer)} />
          <Words text={say(`arm.layer.${layer}`)} />
        </label>
      ))}
      <span class="arm-moves">
        {(["undo", "redo"] as const).map((way) => (
          <button
            key={way}
            type="button"
            class={`arm-${way}`}
            aria-disabled={!canTravel[way]} // a disabled button would lose the focus
            aria-label={say(`arm.${way}`)}
            aria-keyshortcuts={way === "undo" ? "Control+Z" : "Control+Y"}
            title={say(`arm.${way}`)}
            onClick={() => travel(way)}
          >
            {way === "undo" ? "↶" : "↷"}
          </button>
        ))}
        <button type="button" class="arm-reset" onClick={reset}>
          {say("arm.reset")}
        </button>
      </span>
    </div>
  );
});

/** Panes that need what is unknown, and layers that show J. */
const PANES_OF_UNKNOWN: Readonly<Record<Unknown, ReadonlySet<Pane>>> = {
  jacobian: new Set(["jacobian", "map", "weld"]),
  determinant: new Set(["map", "weld"]),
};
const LAYERS_OF_J: ReadonlySet<keyof Layers> = new Set(["columns", "ellipse"]);
/** Layers that are offered once everything is known, or if a lesson is about them. */
const LAYERS_OF_LATER_LESSONS: ReadonlySet<keyof Layers> = new Set(["vectors", "ellipse"]);

/** det J in a line over the drawing, because its pane may be closed. */
function Readout({ arm, measures }: Stage): JSX.Element {
  const value = formatNumber(roundToDigits(measures.det ?? measures.volume));
  return (
    <p class={`arm-readout arm-${classifyNearness(arm, measures)}-pose`} aria-hidden="true">
      <Words text={say(sizeKey(arm))} /> = {value}
    </p>
  );
}

function Numbers({ stage, isOfPoseOnly }: { stage: Stage; isOfPoseOnly: boolean }): JSX.Element {
  return (
    <div class="arm-numbers">
      {stage.isConcealed ? null : <Jacobian {...stage} />}
      <Figures {...stage} isOfPoseOnly={isOfPoseOnly} />
    </div>
  );
}

function Map({ stage, isHidden }: { stage: Stage; isHidden: boolean }): JSX.Element {
  if (isHidden)
    return (
      <p class="arm-concealed">
        <Words text={say("arm.map.hidden")} />
      </p>
    );
  if (stage.isConcealed)
    return (
      <p class="arm-concealed">
        <Words text={say("arm.concealed")} />
      </p>
    );
  if (stage.arm.joints.length < 2) return <p>{say("arm.map.one")}</p>;
  return <SingularMap {...stage} />;
}

function Path({ stage }: { stage: Stage }): JSX.Element {
  const { arm, welding } = stage;
  const reason = whyNoPath(arm);
  return (
    <>
      {welding ? <Welding {...stage} {...welding} /> : null}
      {reason ? <p>{say(`arm.weld.not-${reason}`)}</p> : null}
    </>
  );
}
