// A slider and a number for each joint: native inputs, in degrees and metres.

import type { JSX } from "preact";

import { Letters, plainLetters } from "./letters.js";
import type { Arm, Pose } from "./model.js";
import { rangeOf, within } from "./ranges.js";
import { decimals, useSay } from "./speech.js";

export interface JointsProps {
  readonly arm: Arm;
  readonly pose: Pose;
  readonly chosen: number;
  readonly onChoose: (joint: number) => void;
  readonly onPose: (pose: Pose) => void;
}

export function Joints({ arm, pose, chosen, onChoose, onPose }: JointsProps): JSX.Element {
  const say = useSay();
  return (
    <fieldset class="arm-joints">
      <legend>{say("arm.joints")}</legend>
      {arm.joints.map((joint, i) => {
        const turns = joint.kind === "R";
        const unit = turns ? Math.PI / 180 : 1;
        const { low, high } = rangeOf(arm, i);
        const shown = decimals(pose[i]! / unit, turns ? 1 : 3);
        const name = plainLetters(joint.name);
        const set = (text: string): void => {
          const value = Number(text);
          if (text.trim() === "" || !Number.isFinite(value)) return;
          onPose(pose.map((old, k) => (k === i ? within(arm, i, value * unit) : old)));
        };
        const common = {
          min: low / unit,
          max: high / unit,
          value: shown,
          onFocus: () => onChoose(i),
        };
        return (
          <div
            key={joint.name}
            class={`arm-joint-row arm-j${(i % 7) + 1}${chosen === i ? " arm-chosen" : ""}`}
          >
            <span class="arm-joint-name" aria-hidden="true">
              <Letters name={joint.name} />
            </span>
            <input
              type="range"
              step={turns ? 0.5 : 0.005}
              {...common}
              aria-label={say(turns ? "arm.joint.turn" : "arm.joint.slide", { joint: name })}
              aria-valuetext={say(turns ? "arm.value.degrees" : "arm.value.metres", { value: shown })}
              onInput={(event) => set(event.currentTarget.value)}
            />
            <input
              type="number"
              step={turns ? 1 : 0.01}
              {...common}
              aria-label={say(turns ? "arm.joint.degrees" : "arm.joint.metres", { joint: name })}
              onChange={(event) => set(event.currentTarget.value)}
            />
            <span class="arm-unit" aria-hidden="true">
              {turns ? "°" : "m"}
            </span>
          </div>
        );
      })}
    </fieldset>
  );
}
