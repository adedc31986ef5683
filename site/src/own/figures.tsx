// J, its determinant and its singular values in numbers, as precise as is worth reading, and to be copied as they are.

import type { JSX } from "preact";

import { JacobianTable } from "../arm/jacobian.js";
import { Letters } from "../arm/letters.js";
import { ROWS } from "../arm/model.js";
import type { Stage } from "../arm/stage.js";
import { sizeName } from "../arm/words.js";
import { Copied } from "../pages/copied.js";
import { inDigits, say } from "../text/text.js";

/** Six significant digits, a true minus sign, and no rounding errors beside what is in the matrix. */
function shown(value: number, most: number): string {
  return inDigits(Math.abs(value) < 1e-12 * Math.max(1, most) ? 0 : value);
}

export function Figures({ stage }: { stage: Stage }): JSX.Element {
  const { arm, state, measures } = stage;
  const most = Math.max(...state.jacobian.flat().map(Math.abs));
  const { det, volume, sigma, least } = measures;
  const [largest] = sigma;
  const between = say("number.point") === "," ? "; " : ", ";
  return (
    <section class="own-figures" aria-label={say("own.figures")}>
      <h3>{say("own.figures")}</h3>
      <JacobianTable arm={arm} state={state} written={(value) => shown(value, most)} />
      <dl>
        <dt>{say(sizeName(arm))}</dt>
        <dd>{shown(det ?? volume, largest ?? 1)}</dd>
        <dt>
          <Letters name="sigma" />
        </dt>
        <dd>{sigma.map((value) => shown(value, largest ?? 1)).join(between)}</dd>
        <dt>
          <Letters name="sigma_min" />
        </dt>
        <dd>
          {shown(least, largest ?? 1)}
          {least > 1e-12 * (largest ?? 1)
            ? ` (${say("own.condition", { value: Number((largest! / least).toPrecision(4)) })})`
            : ""}
        </dd>
      </dl>
      <Copied text={asPython(stage)} label={say("own.copy-numbers")} />
    </section>
  );
}

/** All digits, as Python and NumPy take them. */
function asPython({ arm, pose, state, measures }: Stage): string {
  const rows = state.counted.map((row) => `    [${row.join(", ")}],`);
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
