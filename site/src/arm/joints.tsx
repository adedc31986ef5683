// A slider and a number for each joint: native inputs, in degrees or radians, or in metres.

import type { JSX } from "preact";
import { memo, withPace } from "../pace.js";
import { useCallback, useContext, useRef } from "preact/hooks";

import { say } from "../text/text.js";
import { jointClass, Letters, plainLetters } from "./letters.js";
import type { Arm } from "./model.js";
import type { Stage } from "./stage.js";
import { rangeOf, within } from "./ranges.js";
import { angleIn, decimals, InRadians } from "./number-format.js";

type JointsProps = Pick<Stage, "arm" | "pose" | "chosen" | "choose" | "move">;

export const Joints = withPace(
  (props: JointsProps): JSX.Element => {
    const { arm, pose, chosen, choose } = props;
    const now = useRef(props);
    now.current = props;
    const set = useCallback((joint: number, value: number): void => {
      const { arm, pose, move } = now.current;
      move(pose.with(joint, within(arm, joint, value)));
    }, []);
    return (
      <fieldset class="arm-joints" data-joints={arm.joints.length}>
        <legend>{say("arm.joints")}</legend>
        {arm.joints.map(({ name }, i) => (
          <Row key={name} arm={arm} index={i} value={pose[i]!} chosen={chosen === i} onChoose={choose} onValue={set} />
        ))}
      </fieldset>
    );
  },
  { atOnce: ["arm", "chosen", "choose", "move"], inTurn: ["pose"] },
);

interface RowProps {
  readonly arm: Arm;
  readonly index: number;
  readonly value: number;
  readonly chosen: boolean;
  readonly onChoose: (joint: number) => void;
  readonly onValue: (joint: number, value: number) => void;
}

// Only joints that move are drawn again: updating an input takes a browser long.
const Row = memo(({ arm, index, value, chosen, onChoose, onValue }: RowProps): JSX.Element => {
  const joint = arm.joints[index]!;
  const isRevolute = joint.kind === "R";
  const radians = useContext(InRadians) && isRevolute;
  const unit = isRevolute && !radians ? Math.PI / 180 : 1;
  const { low, high } = rangeOf(arm, index);
  const shown = isRevolute ? angleIn(radians, value) : decimals(value, 3);
  const name = plainLetters(joint.name);
  const set = (text: string): void => {
    const typed = Number(text);
    if (text.trim() !== "" && Number.isFinite(typed)) onValue(index, typed * unit);
  };
  const common = { min: low / unit, max: high / unit, value: shown, onFocus: () => onChoose(index) };
  return (
    <div class={`arm-joint-row ${jointClass(index)}${chosen ? " arm-chosen" : ""}`}>
      <span class="arm-joint-name" aria-hidden="true">
        <Letters name={joint.name} />
      </span>
      <input
        type="range"
        step={radians ? 0.01 : isRevolute ? 0.5 : 0.005}
        {...common}
        aria-label={say(isRevolute ? "arm.joint.turn" : "arm.joint.slide", { joint: name })}
        aria-valuetext={say(radians ? "arm.value.radians" : isRevolute ? "arm.value.degrees" : "arm.value.metres", {
          value: shown,
        })}
        onInput={(event) => set(event.currentTarget.value)}
      />
      <input
        type="number"
        step={isRevolute && !radians ? 1 : 0.01}
        {...common}
        aria-label={say(radians ? "arm.joint.radians" : isRevolute ? "arm.joint.degrees" : "arm.joint.metres", {
          joint: name,
        })}
        onChange={({ currentTarget: field }) => {
          const text = field.value;
          field.value = String(shown); // shown again if nothing valid was typed, or the same angle
          set(text);
        }}
      />
      <span class="arm-unit" aria-hidden="true">
        {radians ? "rad" : isRevolute ? "°" : "m"}
      </span>
    </div>
  );
});
