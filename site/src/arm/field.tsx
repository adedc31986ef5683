// A number with its letter and unit, typed or stepped.

import type { ComponentChildren, JSX } from "preact";

import { decimals } from "./speech.js";

export interface FieldProps {
  readonly label: ComponentChildren;
  readonly say: string;
  readonly unit: string;
  readonly value: number;
  readonly step: number;
  readonly least?: number;
  readonly most?: number;
  readonly onSet: (value: number) => void;
}

export function Field({
  label,
  say,
  unit,
  value,
  step,
  least = -20,
  most = 20,
  onSet,
}: FieldProps): JSX.Element {
  return (
    <label class="arm-field">
      <span aria-hidden="true">
        <i>{label}</i>
      </span>
      <input
        type="number"
        aria-label={say}
        title={say}
        value={decimals(value, 3)}
        step={step}
        min={least}
        max={most}
        onChange={(event) => {
          const next = event.currentTarget.valueAsNumber;
          if (Number.isFinite(next)) onSet(Math.min(most, Math.max(least, next)));
        }}
      />
      <span class="arm-unit" aria-hidden="true">
        {unit}
      </span>
    </label>
  );
}
