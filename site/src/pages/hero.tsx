// The arm that greets: its drawing, a slider for each joint and its numbers, without all else that the panel has.

import "../arm/arm.css";

import type { JSX } from "preact";
import { useId, useMemo, useState } from "preact/hooks";

import { Drawing } from "../arm/drawing.js";
import { Figures } from "../arm/figures.js";
import { Joints } from "../arm/joints.js";
import type { Layers } from "../arm/marks.js";
import { type Arm, measuresOf, type Pose, reachOf, stateAt } from "../arm/model.js";
import { useRested } from "../arm/size.js";
import { sayIn, Spoken, useSay } from "../arm/speech.js";
import { inWords } from "../arm/words.js";
import { useSteps } from "../later.js";
import type { Language } from "../text/text.js";

const LAYERS: Layers = { frames: false, vectors: false, columns: true, ellipse: true };

interface HeroProps {
  readonly title: string;
  readonly arm: Arm;
  readonly first: Pose;
  readonly language: Language;
}

export function Hero(props: HeroProps): JSX.Element {
  return (
    <Spoken.Provider value={props.language}>
      <Shown {...props} />
    </Spoken.Provider>
  );
}

function Shown({ title, arm, first, language }: HeroProps): JSX.Element {
  const say = useSay();
  const drawn = useSteps(1) > 0;
  const reach = useMemo(() => reachOf(arm), [arm]);
  const [pose, setPose] = useState<Pose>(first);
  const [chosen, setChosen] = useState(0);
  const state = useMemo(() => stateAt(arm, pose), [arm, pose]);
  const measures = useMemo(() => measuresOf(state), [state]);
  const rested = useRested(state, 700);
  const words = useMemo(() => inWords(arm, rested, sayIn(language)), [arm, rested, language]);
  const id = useId();
  return (
    <div class="arm">
      <Drawing
        arm={arm}
        state={state}
        reach={reach}
        layers={LAYERS}
        chosen={chosen}
        onChoose={setChosen}
        onPose={setPose}
        label={say("arm.drawing.label", { robot: title })}
        describedBy={`${id}words`}
      />
      {drawn ? (
        <div class="hero-side">
          <Figures arm={arm} state={state} measures={measures} rested={rested} />
          <Joints arm={arm} pose={pose} chosen={chosen} onChoose={setChosen} onPose={setPose} />
        </div>
      ) : null}
      <p id={`${id}words`} class="arm-unseen" role="status">
        {words}
      </p>
    </div>
  );
}
