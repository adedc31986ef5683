// Show the numbers of a pose: det J with its factors, the point, and how near a singularity is.

import type { JSX } from "preact";
import { useContext } from "preact/hooks";

import { withPace } from "../pace.js";
import { formatNumber, numberSeparator, say } from "../text/text.js";
import { Determinant } from "./jacobian.js";
import { Letters, Words } from "./letters.js";
import { mixesUnits } from "./model.js";
import { convertAngle, InRadians, roundToDecimals } from "./number-format.js";
import { angleInPlane, rotationAnglesOf } from "./orientation.js";
import type { Stage } from "./stage.js";
import { kindOfSingularity, classifyNearness } from "./descriptions.js";

interface FiguresProps extends Pick<
  Stage,
  "arm" | "state" | "measures" | "settledState" | "sizes" | "isConcealed" | "layers"
> {
  /** Whether the pane beside already says that J is concealed. */
  readonly isExplainedBeside?: boolean;
  /** Whether nothing of J is shown, because a lesson has not introduced its determinant yet. */
  readonly isOfPoseOnly?: boolean;
}

export const Figures = withPace(
  (props: FiguresProps): JSX.Element => {
    const { arm, state, measures, settledState, sizes, isConcealed, isExplainedBeside, isOfPoseOnly, layers } = props;
    const nearness = classifyNearness(arm, measures);
    const kind = nearness === "singular" && settledState === state ? kindOfSingularity(arm, state) : null;
    const point = (
      <>
        <i>P</i> = ({state.point.map((value) => formatNumber(roundToDecimals(value, 3))).join(numberSeparator())}) m.
      </>
    );
    const isHidden = isOfPoseOnly && !layers.frames; // a first lesson names no axis that is not drawn
    const orientation = isHidden ? null : <Orientation arm={arm} state={state} />;
    if (isConcealed || isOfPoseOnly)
      return (
        <div class="arm-figures">
          {isExplainedBeside || isOfPoseOnly ? null : (
            <p class="arm-concealed">
              <Words text={say("arm.concealed")} />
            </p>
          )}
          <p class="arm-nearness">
            {point} {orientation}
          </p>
        </div>
      );
    return (
      <div class={`arm-figures arm-${nearness}-pose`}>
        <Determinant arm={arm} state={state} measures={measures} sizes={sizes} />
        <p class="arm-nearness">
          {point} {orientation}{" "}
          {nearness === "singular" // and the smallest singular value is zero
            ? null
            : say(mixesUnits(arm) ? "arm.figures.ratio-shares" : "arm.figures.ratio", {
                percent: roundToDecimals(100 * measures.ratio, 1),
              })}{" "}
          <strong>{say(`arm.words.${nearness}`)}</strong> {kind && say(`arm.words.${kind}`)}
        </p>
      </div>
    );
  },
  {
    atOnce: ["arm", "sizes", "isConcealed", "isExplainedBeside", "isOfPoseOnly", "layers"],
    inTurn: ["state", "measures", "settledState"],
  },
);

/** The orientation of the last frame: the angle of its x axis in the plane, or its rotation in space. */
function Orientation({ arm, state }: Pick<Stage, "arm" | "state">): JSX.Element {
  const inRadians = useContext(InRadians);
  const write = (angle: number): string => `${formatNumber(convertAngle(inRadians, angle))}${inRadians ? " rad" : "°"}`;
  const last = arm.joints.length;
  const frame = state.frames[last]!;
  const angle = angleInPlane(arm, frame);
  if (angle !== null)
    return (
      <span>
        {say("arm.figures.angle-of")} <Letters name={`x${last}`} />: {write(angle)}.
      </span>
    );
  const { yaw, pitch, roll } = rotationAnglesOf(frame);
  const angles = { yaw: write(yaw), pitch: write(pitch), roll: write(roll) };
  return <span>{say("arm.figures.rotation", { frame: last, ...angles })}</span>;
}
