// J, its determinant and its singular values in numbers, with a button that copies all digits.

import type { JSX } from "preact";

import { JacobianTable } from "../arm/jacobian.js";
import { Letters, Words } from "../arm/letters.js";
import type { Stage } from "../arm/stage.js";
import { sizeKey } from "../arm/descriptions.js";
import { ROWS } from "../bank.js";
import { CopyButton } from "../pages/copy-button.js";
import { formatNumber, numberSeparator, say } from "../text/text.js";

/** Format with six significant digits, a true minus sign, and 0 for rounding errors relative to `largest`. */
function formatOrZero(value: number, largest: number): string {
  return formatNumber(Math.abs(value) < 1e-12 * Math.max(1, largest) ? 0 : value);
}

/** On a phone, J of more joints is scrolled sideways. */
const FITTING_JOINTS = 3;

export function Figures({ stage }: { stage: Stage }): JSX.Element {
  const { arm, state, measures } = stage;
  const largestEntry = Math.max(...state.jacobian.flat().map(Math.abs));
  const { det, volume, sigma, minSigma } = measures;
  const [largest] = sigma;
  return (
    <section class="own-figures" aria-label={say("own.figures")}>
      <h3>{say("own.figures")}</h3>
      <JacobianTable
        arm={arm}
        state={state}
        format={(value) => formatOrZero(value, largestEntry)}
        tabIndex={arm.joints.length > FITTING_JOINTS ? 0 : undefined}
      />
      <dl>
        <dt>
          <Words text={say(sizeKey(arm))} />
        </dt>
        <dd>{formatOrZero(det ?? volume, largest ?? 1)}</dd>
        <dt>
          <Letters name="sigma" />
        </dt>
        <dd>{sigma.map((value) => formatOrZero(value, largest ?? 1)).join(numberSeparator())}</dd>
        <dt>
          <Letters name="sigma_min" />
        </dt>
        <dd>
          {formatOrZero(minSigma, largest ?? 1)}
          {minSigma > 1e-12 * (largest ?? 1)
            ? ` (${say("own.condition", { value: Number((largest! / minSigma).toPrecision(4)) })})`
            : ""}
        </dd>
      </dl>
      <CopyButton text={writePython(stage)} label={say("own.copy-numbers")} />
    </section>
  );
}

/** Return all digits as Python code. */
function writePython({ arm, pose, state, measures }: Stage): string {
  const rows = state.taskJacobian.map((row) => `    [${row.join(", ")}],`);
  const task = arm.task.map((row) => ROWS[row]).join(", ");
  return [
    `q = [${pose.join(", ")}]  # rad, m`,
    `J = [  # ${task}`,
    ...rows,
    "]",
    ...(measures.det === null ? [] : [`det_J = ${measures.det}`]),
    `sigma = [${measures.sigma.join(", ")}]`,
    "",
  ].join("\n");
}
