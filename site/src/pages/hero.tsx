// The arm on the first page: its drawing, and det J with its factors, without the other parts of the stage.

import "../arm/arm.css";

import type { JSX } from "preact";
import { useId, useMemo } from "preact/hooks";

import { Drawing } from "../arm/drawing.js";
import { Figures } from "../arm/figures.js";
import type { Layers } from "../arm/marks.js";
import { stateAt } from "../arm/model.js";
import { type StageRequest, useStage } from "../arm/stage.js";
import { addScaled, norm, subtract } from "../arm/vector.js";
import { describeArm } from "../arm/descriptions.js";
import { useSteps } from "../scheduling.js";
import { say } from "../text/text.js";

const LAYERS: Layers = { frames: false, lengths: true, vectors: false, columns: true, ellipse: true, trace: false };

export function Hero(wish: StageRequest): JSX.Element {
  const stage = useStage(wish, null);
  const { arm, home, reach, settledState, robot } = stage;
  const description = useMemo(() => describeArm(arm, settledState, false), [arm, settledState]);
  // The page suggests pulling P straight out: its place at full reach must be visible.
  const stretchedPoints = useMemo(() => {
    const direction = subtract(stateAt(arm, home).point, arm.base.o);
    return [addScaled(arm.base.o, direction, reach / norm(direction))];
  }, [arm, home, reach]);
  const id = useId();
  const step = useSteps(2); // title, drawing, numbers: no step blocks a phone for long
  if (step === 0) return <div class="arm" />;
  return (
    <div class="arm">
      <Drawing
        {...stage}
        layers={LAYERS}
        isEnlarged
        extraPoints={stretchedPoints}
        label={say("arm.drawing.label", { robot: robot.title })}
        describedBy={`${id}words`}
      />
      <div class="hero-side">{step > 1 ? <Figures {...stage} /> : null}</div>
      <p id={`${id}words`} class="arm-unseen" role="status">
        {description}
      </p>
    </div>
  );
}
