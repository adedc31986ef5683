// A slider and a number for each joint: native inputs, in degrees or radians, or in metres.

import type { JSX } from "preact";
import { memo, withPace } from "../pace.js";
import { useCallback, useContext, useRef } from "preact/hooks";

import { say } from "../text/text.js";
import { jointClass, Letters, plainLetters } from "./letters.js";
import type { Arm } from "./model.js";
import type { Stage } from "./stage.js";
import { rangeOf, limitToRange } from "./ranges.js";
import { convertAngle, roundToDecimals, InRadians } from "./number-format.js";

type JointsProps = Pick<Stage, "arm" | "pose" | "chosenJoint" | "choose" | "move">;

export const Joints = withPace(
  (props: JointsProps): JSX.Element => {
    const { arm, pose, chosenJoint, choose } = props;
    const latestProps = useRef(props);
    latestProps.current = props;
    const setJoint = useCallback((joint: number, value: number): void => {
      const { arm, pose, move } = latestProps.current;
      move(pose.with(joint, limitToRange(arm, joint, value)));
    }, []);
    return (
      <fieldset class="arm-joints" data-joints={arm.joints.length}>
        <legend>{say("arm.joints")}</legend>
        {arm.joints.map(({ name }, i) => (
          <Row
            key={name}
            arm={arm}
            index={i}
            value={pose[i]!}
            isChosen={chosenJoint === i}
            onChoose={choose}
            onValue={setJoint}
          />
        ))}
      </fieldset>
    );
  },
  { atOnce: ["arm", "chosenJoint", "choose", "move"], inTurn: ["pose"] },
);

interface RowProps {
  readonly arm: Arm;
  readonly index: number;
  readonly value: number;
  readonly isChosen: boolean;
  readonly onChoose: (joint: number) => void;
  readonly onValue: (joint: number, value: number) => void;
}

// Only joints that move are drawn again: updating an input takes a browser long.
const Row = memo(({ arm, index, value, isChosen, onChoose, onValue }: RowProps): JSX.Element => {
  const joint = arm.joints[index]!;
  const isRevolute = joint.kind === "R";
  const inRadians = useContext(InRadians) && isRevolute;
  const radiansPerUnit = isRevolute && !inRadians ? Math.PI / 180 : 1;
  const { low, high } = rangeOf(arm, index);
  const shownValue = isRevolute ? convertAngle(inRadians, value) : roundToDecimals(value, 3);
  const name = plainLetters(joint.name);
  const setFromText = (text: string): void => {
    const typed = Number(text);
    if (text.trim() !== "" && Number.isFinite(typed)) onValue(index, typed * radiansPerUnit);
  };
  const commonProps = {
    min: low / radiansPerUnit,
    max: high / radiansPerUnit,
    value: shownValue,
    onFocus: () => onChoose(index),
  };
  return (
    <div class={`arm-joint-row ${jointClass(index)}${isChosen ? " arm-chosen" : ""}`}>
      <span class="arm-joint-name" aria-hidden="true">
        <Letters name={joint.name} />
      </span>
      <input
        type="range"
        step={inRadians ? 0.01 : isRevolute ? 0.5 : 0.005}
        {...commonProps}
        aria-label={say(isRevolute ? "arm.joint.turn" : "arm.joint.slide", { joint: name })}
        aria-valuetext={say(inRadians ? "arm.value.radians" : isRevolute ? "arm.value.degrees" : "arm.value.metres", {
          value: shownValue,
        })}
        onInput={(event) => setFromText(event.currentTarget.value)}
      />
      <input
        type="number"
        step={isRevolute && !inRadians ? 1 : 0.01}
        {...commonProps}
        aria-label={say(inRadians ? "arm.joint.radians" : isRevolute ? "arm.joint.degrees" : "arm.joint.metres", {
          joint: name,
        })}
        onChange={({ currentTarget: field }) => {
          const text = field.value;
          field.value = String(shownValue); // shown again if nothing valid was typed, or the same angle
          setFromText(text);
        }}
      />
      <span class="arm-unit" aria-hidden="true">
        {inRadians ? "rad" : isRevolute ? "°" : "m"}
      </span>
    </div>
  );
});
