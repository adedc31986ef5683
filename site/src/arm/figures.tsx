// Show the numbers of a pose: det J with its factors, the point, and how near a singularity is.

import type { JSX } from "preact";

import { paced } from "../pace.js";
import { inDigits, say } from "../text/text.js";
import { Determinant } from "./jacobian.js";
import { decimals } from "./speech.js";
import type { Stage } from "./stage.js";
import { kindHere, nearness } from "./words.js";

interface FiguresProps extends Pick<Stage, "arm" | "state" | "measures" | "rested" | "sizes" | "concealed"> {
  /** Whether the pane beside says so already. */
  readonly isToldAside?: boolean;
}

export const Figures = paced(
  (props: FiguresProps): JSX.Element => {
    const { arm, state, measures, rested, sizes, concealed, isToldAside } = props;
    const near = nearness(arm, measures);
    const kind = near === "singular" && rested === state ? kindHere(arm, state) : null;
    const between = inDigits(0.5).includes(",") ? "; " : ", ";
    const point = (
      <>
        <i>P</i> = ({state.point.map((value) => inDigits(decimals(value, 3))).join(between)}) m.
      </>
    );
    if (concealed)
      return (
        <div class="arm-figures">
          {isToldAside ? null : <p class="arm-concealed">{say("arm.concealed")}</p>}
          <p class="arm-nearness">{point}</p>
        </div>
      );
    return (
      <div class={`arm-figures arm-${near}-pose`}>
        <Determinant arm={arm} state={state} measures={measures} sizes={sizes} />
        <p class="arm-nearness">
          {point} {say("arm.figures.ratio", { percent: decimals(100 * measures.ratio, 1) })}{" "}
          <strong>{say(`arm.words.${near}`)}</strong> {kind && say(`arm.words.${kind}`)}
        </p>
      </div>
    );
  },
  {
    arm: "at once",
    state: "in turn",
    measures: "in turn",
    rested: "in turn",
    sizes: "at once",
    concealed: "at once",
    isToldAside: "at once",
  },
);
