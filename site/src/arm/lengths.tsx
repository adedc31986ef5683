// The lengths and angles with which an arm is drawn: those that its problem leaves symbolic, and given numbers.

import type { JSX } from "preact";
import { useContext } from "preact/hooks";

import type { Robot, SymbolInfo } from "../bank.js";
import { formatNumber, say } from "../text/text.js";
import { Letters } from "./letters.js";
import { convertAngle, roundToDecimals, InRadians } from "./number-format.js";

type LengthsProps = { readonly robot: Robot; readonly symbols: Readonly<Record<string, SymbolInfo>> };

type Length = readonly [name: string, role: string, value: number];

export function Lengths({ robot, symbols }: LengthsProps): JSX.Element | null {
  const inRadians = useContext(InRadians);
  const numericLengths = Object.entries(symbols).flatMap(([name, { role, value }]): Length[] =>
    (role === "length" || role === "angle") && value !== undefined ? [[name, role, value]] : [],
  );
  const roleOf = (name: string): string => symbols[name]?.role ?? "length";
  const symbolicLengths = Object.entries(robot.values).map(([name, value]): Length => [name, roleOf(name), value]);
  const lengths = [...symbolicLengths, ...numericLengths].sort(([a], [b]) => (a < b ? -1 : 1));
  if (lengths.length === 0) return null;
  return (
    <p class="arm-lengths">
      {say("arm.lengths")}{" "}
      {lengths.map(([name, role, value], i) => (
        <span key={name}>
          {i > 0 && ", "}
          <Letters name={name} />
          {" = "}
          {role === "angle"
            ? `${formatNumber(convertAngle(inRadians, value))}${inRadians ? " rad" : "°"}`
            : `${formatNumber(roundToDecimals(value, 3))} m`}
        </span>
      ))}
    </p>
  );
}
