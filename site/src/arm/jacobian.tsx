// Show the numeric Jacobian, each column in its joint's colour, and det J with a bar for each factor.

import type { JSX } from "preact";

import { ROWS } from "../bank.js";
import { withPace } from "../pace.js";
import { decimalSign, formatNumber, say } from "../text/text.js";
import { jointClass, Letters, Words } from "./letters.js";
import type { Arm, State } from "./model.js";
import { roundToDecimals, roundToDigits } from "./number-format.js";
import type { Stage } from "./stage.js";
import { classifyNearness, sizeKey } from "./descriptions.js";

interface TableProps {
  readonly arm: Arm;
  readonly state: State;
  /** Format an entry. */
  readonly format: (value: number) => string;
  readonly className?: string;
  /** 0 if the table may be wider than its place: keys can then scroll it. */
  readonly tabIndex?: 0 | undefined;
  readonly classOfColumn?: (column: number) => string;
  /** Called with the column under the pointer. */
  readonly onColumn?: (column: number | null) => void;
}

/** The rows of J that the task counts, with the names of rows and columns. */
export function JacobianTable(props: TableProps): JSX.Element {
  const { arm, state, format, className, tabIndex, classOfColumn, onColumn } = props;
  /** Report the column under the pointer; the first cell of a row is its name. */
  const reportColumn = ({ target }: PointerEvent): void => {
    const index = (target as Element).closest<HTMLTableCellElement>("td, th")?.cellIndex ?? 0;
    onColumn?.(index > 0 ? index - 1 : null);
  };
  return (
    <table
      class={className}
      tabIndex={tabIndex}
      data-rows={arm.task.length}
      data-columns={arm.joints.length}
      onPointerOver={reportColumn}
      onPointerLeave={() => onColumn?.(null)}
    >
      <caption class="arm-unseen">{say("arm.jacobian.title")}</caption>
      <thead>
        <tr>
          <th scope="col">
            <i>J</i>
          </th>
          {arm.joints.map(({ name }, i) => (
            <th key={name} scope="col" class={classOfColumn?.(i)}>
              <Letters name={name} hasDot />
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {arm.task.map((row, k) => (
          <tr key={row}>
            <th scope="row">
              <Letters name={rowName(row)} />
            </th>
            {state.taskJacobian[k]!.map((value, i) => (
              <td key={i} class={classOfColumn?.(i)}>
                {format(value)}
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export const Jacobian = withPace(
  ({
    arm,
    state,
    highlightedJoint,
    highlight,
  }: Pick<Stage, "arm" | "state" | "highlightedJoint" | "highlight">): JSX.Element => (
    <JacobianTable
      arm={arm}
      state={state}
      format={arm.joints.length > MANY_JOINTS ? toTwoDecimals : toThreeDecimals}
      className="arm-jacobian"
      classOfColumn={(i) => `${jointClass(i)}${highlightedJoint === i ? " arm-lit" : ""}`}
      onColumn={highlight}
    />
  ),
  { atOnce: ["arm", "highlightedJoint", "highlight"], inTurn: ["state"] },
);

/** Return the name of a row of J as `Letters` takes it: v_x, ω_z. */
export function rowName(row: number): string {
  const [letter, axis] = ROWS[row]!;
  return `${letter === "w" ? "ω" : "v"}_${axis}`;
}

/** With more joints, entries have two decimals: J is as wide as the column. */
const MANY_JOINTS = 7;

/** Format with a fixed number of decimals, so that nothing jumps while the arm moves, and without "−0". */
const toDecimals =
  (count: number) =>
  (value: number): string =>
    roundToDecimals(value, count).toFixed(count).replace("-", "−").replace(".", decimalSign());
const [toTwoDecimals, toThreeDecimals] = [toDecimals(2), toDecimals(3)];

/** Below this share of its maximum absolute value, a factor is marked as vanishing. */
const VANISHING_SHARE = 0.06;

/** det J, or the product of singular values, and the factors of det J if they may be shown. */
export function Determinant(props: Pick<Stage, "arm" | "state" | "measures" | "sizes">): JSX.Element {
  const { arm, state, measures, sizes } = props;
  const nearness = classifyNearness(arm, measures);
  const { maxDeterminant, factors } = sizes();
  const size = measures.det ?? measures.volume;
  return (
    <dl class="arm-factors">
      <div>
        <dt>
          <Words text={say(sizeKey(arm))} />
        </dt>
        <dd>{formatNumber(roundToDigits(size))}</dd>
        <Bar share={Math.abs(size) / maxDeterminant} isLow={nearness !== "regular"} />
      </div>
      {factors.map(({ html, valueAt, maxSize }) => {
        const value = valueAt(state.pose);
        const share = Math.min(1, Math.abs(value) / maxSize);
        return (
          <div key={html} class={share < VANISHING_SHARE ? "arm-vanishing" : ""}>
            <dt dangerouslySetInnerHTML={{ __html: html }} />
            <dd>{formatNumber(roundToDecimals(value, 3))}</dd>
            <Bar share={share} isLow={share < VANISHING_SHARE} />
          </div>
        );
      })}
    </dl>
  );
}

function Bar({ share, isLow }: { share: number; isLow: boolean }): JSX.Element {
  return (
    <dd class="arm-bar" aria-hidden="true">
      <svg viewBox="0 0 100 6" preserveAspectRatio="none">
        <rect class="arm-meter-all" width={100} height={6} />
        <rect
          class={`arm-meter-now${isLow ? " arm-low" : ""}`}
          width={Math.max(0.8, 100 * Math.min(1, share))}
          height={6}
        />
      </svg>
    </dd>
  );
}
