// A page for development: the sample arms one below the other, and a pose that is set from outside.

import "./arm.css";

import { render } from "preact";

import { Arm } from "../src/arm/panel.js";
import type { Robot, SymbolInfo } from "../src/bank.js";
import elbow from "./elbow-3r.json";
import planar2 from "./planar-2r.json";
import planar3 from "./planar-3r.json";
import scara from "./scara.json";

interface Sample {
  readonly id: string;
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
}

const SAMPLES = [planar2, planar3, elbow, scara] as unknown as readonly Sample[];

const wanted = new URLSearchParams(location.search).get("arm");
const shown = SAMPLES.filter(({ id }) => wanted === null || id.startsWith(wanted));

render(
  <>
    {shown.map(({ id, robot, symbols }) => (
      <Arm key={id} robot={robot} symbols={symbols} />
    ))}
  </>,
  document.getElementById("arms")!,
);
