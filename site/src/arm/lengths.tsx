// The lengths and angles with which an arm is drawn: sliders for those that its problem leaves symbolic, given numbers.

import type { JSX } from "preact";
import { useContext, useRef } from "preact/hooks";

import type { Robot, SymbolInfo } from "../bank.js";
import { formatNumber, say } from "../text/text.js";
import { Letters, plainLetters } from "./letters.js";
import { convertAngle, roundToDecimals, InRadians } from "./number-format.js";

interface LengthsProps {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  readonly onLength: (name: string, value: number) => void;
}

type Range = { readonly min: number; readonly max: number };

type Length = readonly [name: string, role: string, value: number];

/** A slider ends at this multiple of the length with which it began, but not below this length (m). */
const [MAX_FACTOR, MIN_LENGTH] = [2, 0.05];

/** Return the range of a slider for a symbolic length or angle that begins with a value (m or rad). */
function sliderRange(role: string, value: number): Range {
  if (role === "angle") return { min: -Math.PI, max: Math.PI };
  const size = Math.max(MIN_LENGTH, Math.abs(value));
  const [least, most] = [Math.min(MIN_LENGTH, size / 2), Math.ceil(20 * MAX_FACTOR * size) / 20];
  return value < 0 ? { min: -most, max: -least } : { min: least, max: most };
}

export function Lengths({ robot, symbols, onLength }: LengthsProps): JSX.Element | null {
  const inRadians = useContext(InRadians);
  const numericLengths = Object.entries(symbols).flatMap(([name, { role, value }]): Length[] =>
    (role === "length" || role === "angle") && value !== undefined ? [[name, role, value]] : [],
  );
  const roleOf = (name: string): string => symbols[name]?.role ?? "length";
  const symbolicLengths = Object.entries(robot.values).map(([name, value]): Length => [name, roleOf(name), value]);
  const lengths = [...symbolicLengths, ...numericLengths].sort(([a], [b]) => (a < b ? -1 : 1));
  const ranges = useRef<Record<string, Range>>({}); // they stay while a slider moves
  if (lengths.length === 0) return null;
  return (
    <div class="arm-lengths">
      <span class="arm-lengths-title">{say("arm.lengths")} </span>
      {lengths.map(([name, role, value], i) => {
        const number = formatNumber(role === "angle" ? convertAngle(inRadians, value) : roundToDecimals(value, 3));
        const text = `${number}${role !== "angle" ? " m" : inRadians ? " rad" : "°"}`;
        const lastRange = ranges.current[name];
        const isInRange = lastRange && value >= lastRange.min && value <= lastRange.max;
        const { min, max } = (ranges.current[name] = isInRange ? lastRange : sliderRange(role, value));
        const shown = (
          <span>
            <Letters name={name} />
            {` = ${text}`}
          </span>
        );
        if (!(name in robot.values))
          return (
            <span key={name}>
              {shown}
              {i < lengths.length - 1 && ", "}
            </span>
          );
        return (
          <label key={name}>
            {shown}
            <input
              type="range"
              {...{ min, max }}
              step={role === "angle" ? Math.PI / 360 : 0.005}
              value={value}
              aria-label={say(role === "angle" ? "arm.angle.value" : "arm.length.value", { name: plainLetters(name) })}
              aria-valuetext={text}
              onInput={(event) => onLength(name, Number(event.currentTarget.value))}
            />
          </label>
        );
      })}
    </div>
  );
}
