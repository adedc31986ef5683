// The numbers of the pose: det J, singular values, the point, and a verdict on nearness to a singularity.

import type { JSX } from "preact";

import { Letters } from "./letters.js";
import type { Arm, Measures, State } from "./model.js";
import { decimals, digits, useDigits, useSay } from "./speech.js";
import { kindHere, nearness, sizeName } from "./words.js";

export interface FiguresProps {
  readonly arm: Arm;
  readonly state: State;
  readonly measures: Measures;
  /** The pose once it rests, of which the kind of singularity is told. */
  readonly rested: State;
}

export function Figures({ arm, state, measures, rested }: FiguresProps): JSX.Element {
  const say = useSay();
  const signed = useDigits();
  const near = nearness(arm, measures);
  const kind = near === "singular" && rested === state ? kindHere(arm, state) : null;
  const { det, volume, least, ratio } = measures;
  return (
    <div class={`arm-figures arm-${near}-pose`}>
      <dl>
        <div>
          <dt>{say(sizeName(arm))}</dt>
          <dd>{signed(digits(det ?? volume))}</dd>
        </div>
        <div>
          <dt>
            <Letters name="sigma_min" />
          </dt>
          <dd>{signed(digits(least))}</dd>
        </div>
        <div>
          <dt>
            <i>P</i>
          </dt>
          <dd>
            {state.point
              .map((value) => signed(decimals(value, 3)))
              .join(signed(0.5).includes(",") ? "; " : ", ")}{" "}
            m
          </dd>
        </div>
      </dl>
      <div class="arm-meter" aria-hidden="true">
        <svg viewBox="0 0 100 6" preserveAspectRatio="none">
          <rect class="arm-meter-all" width={100} height={6} />
          <rect class="arm-meter-now" width={Math.max(0.6, 100 * Math.min(1, ratio))} height={6} />
        </svg>
      </div>
      <p class="arm-nearness">
        {say("arm.figures.ratio", { percent: decimals(100 * ratio, 1) })} {say(`arm.words.${near}`)}{" "}
        {kind && say(`arm.words.${kind}`)}
      </p>
    </div>
  );
}
