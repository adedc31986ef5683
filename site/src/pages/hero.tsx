// The arm that greets: its drawing, and det J with its factor, without all else that the stage has.

import "../arm/arm.css";

import type { JSX } from "preact";
import { useId, useMemo } from "preact/hooks";

import { Drawing } from "../arm/drawing.js";
import { Figures } from "../arm/figures.js";
import type { Layers } from "../arm/marks.js";
import { type Arm, type Pose, stateAt } from "../arm/model.js";
import { type StageWish, useStage } from "../arm/stage.js";
import { along, norm, subtract, type Vec3 } from "../arm/vector.js";
import { inWords } from "../arm/words.js";
import { useSteps } from "../later.js";
import { say } from "../text/text.js";

const LAYERS: Layers = { frames: false, lengths: true, vectors: false, columns: true, ellipse: true };

/** Where P is once it is pulled straight out, as the page asks for: as far as the arm reaches. */
function pulledOut(arm: Arm, home: Pose, reach: number): Vec3 {
  const out = subtract(stateAt(arm, home).point, arm.base.o);
  return along(arm.base.o, out, reach / norm(out));
}

export function Hero(wish: StageWish): JSX.Element {
  const stage = useStage(wish, null);
  const { arm, rested, robot } = stage;
  const words = useMemo(() => inWords(arm, rested, false), [arm, rested]);
  const stretched = useMemo(() => [pulledOut(arm, stage.home, stage.reach)], [arm, stage.home, stage.reach]);
  const id = useId();
  const step = useSteps(2); // what the arm is, its drawing, its numbers: no piece of work holds up a phone for long
  if (step === 0) return <div class="arm" />;
  return (
    <div class="arm">
      <Drawing
        {...stage}
        layers={LAYERS}
        near
        besides={stretched}
        label={say("arm.drawing.label", { robot: robot.title })}
        describedBy={`${id}words`}
      />
      <div class="hero-side">{step > 1 ? <Figures {...stage} /> : null}</div>
      <p id={`${id}words`} class="arm-unseen" role="status">
        {words}
      </p>
    </div>
  );
}
