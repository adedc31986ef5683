// The arms that the tests move: real records, and one that is written down here.

import type { Robot } from "../../src/bank.js";
import elbow from "../../dev/elbow-3r.json" with { type: "json" };
import planar2 from "../../dev/planar-2r.json" with { type: "json" };
import planar3 from "../../dev/planar-3r.json" with { type: "json" };
import scara from "../../dev/scara.json" with { type: "json" };

export const ROBOTS: Readonly<Record<string, Robot>> = {
  "planar-2r": planar2.robot as unknown as Robot,
  "planar-3r": planar3.robot as unknown as Robot,
  "elbow-3r": elbow.robot as unknown as Robot,
  scara: scara.robot as unknown as Robot,
};

const row = (a: string, alpha: string, theta: string, d = "0"): Robot["joints"][number] => ({
  kind: "R",
  theta,
  d,
  a,
  alpha,
});

function robot(name: string, joints: Robot["joints"], task: Robot["task"], values: Robot["values"]): Robot {
  return {
    name,
    title: name,
    joints,
    base: { position: ["0", "0", "0"], yaw: "0", tilt: "0" },
    point: { frame: joints.length, offset: ["0", "0", "0"] },
    task,
    values,
  };
}

/** The planar 2R arm of the chapter, no offsets: det J = a1 a2 sin(theta2). */
export const PLAIN = robot("plain", [row("a1", "0", "theta1"), row("a2", "0", "theta2")], ["vx", "vy"], {
  a1: 0.5,
  a2: 0.4,
});

/** An elbow arm without shoulder offset: internal where P is on the first axis, boundary where it is stretched out. */
export const ELBOW = robot(
  "elbow",
  [row("0", "pi/2", "theta1"), row("a2", "0", "theta2"), row("a3", "0", "theta3")],
  ["vx", "vy", "vz"],
  { a2: 0.5, a3: 0.4 },
);

/** A spherical wrist on an elbow arm, all six rows counted: theta5 = 0 is internal. */
export const SIX = robot(
  "six",
  [
    row("0", "pi/2", "theta1"),
    row("a2", "0", "theta2"),
    row("0", "pi/2", "theta3"),
    row("0", "-pi/2", "theta4", "d4"),
    row("0", "pi/2", "theta5"),
    row("0", "0", "theta6"),
  ],
  ["vx", "vy", "vz", "wx", "wy", "wz"],
  { a2: 0.5, d4: 0.4 },
);

/** The PUMA 560, whose second joint is the lowest that is drawn. */
export const PUMA = robot(
  "puma",
  [
    row("0", "pi/2", "theta1"),
    row("a2", "0", "theta2"),
    row("a3", "-pi/2", "theta3", "d3"),
    row("0", "pi/2", "theta4", "d4"),
    row("0", "-pi/2", "theta5"),
    row("0", "0", "theta6"),
  ],
  ["vx", "vy", "vz", "wx", "wy", "wz"],
  { a2: 0.4318, a3: 0.0203, d3: 0.15005, d4: 0.4318 },
);
