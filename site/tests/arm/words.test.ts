// Descriptions of the arm at a regular pose, near a singularity, and at one.

import { describe, expect, it } from "vitest";

import { plainLetters } from "../../src/arm/letters.js";
import { type Arm, armOf, measuresOf, stateAt } from "../../src/arm/model.js";
import { describeArm, kindOfSingularity, classifyNearness } from "../../src/arm/descriptions.js";
import { scaleVector } from "../../src/arm/vector.js";
import { PLAIN, PUMA, ROBOTS, SIX } from "./robots.js";

describe("the planar arm in words", () => {
  const arm = armOf(PLAIN);
  const told = (pose: number[]): string => describeArm(arm, stateAt(arm, pose), false);

  it("contains pose, point and determinant", () => {
    expect(told([Math.PI / 6, -Math.PI / 2])).toBe(
      "Joints: θ1 30 degrees, θ2 −90 degrees. The point P is at x 0.633, y −0.096, z 0 metres. " +
        "The determinant of J is −0.2. The smallest singular value is 0.286, 41 percent of the largest. " +
        "Far from singularities.",
    );
  });

  it("has angles in radians if radians are chosen", () => {
    const text = describeArm(arm, stateAt(arm, [Math.PI / 6, -Math.PI / 2]), true);
    expect(text).toContain("Joints: θ1 0.524 radians, θ2 −1.571 radians. The point P");
    expect(text).not.toContain("degrees");
  });

  it("is slow near a singularity, along the direction that is lost there", () => {
    const text = told([0, 0.08]);
    expect(text).toContain("Near a singularity.");
    expect(text).toMatch(
      /slowest in the direction \(−?1, −?0\.0\d, 0\)|slowest in the direction \(−?0\.9\d, −?0\.\d+, 0\)/,
    );
  });

  it("says that the boundary is reached", () => {
    const state = stateAt(arm, [0.5, 0]);
    expect(classifyNearness(arm, measuresOf(arm, state))).toBe("singular");
    expect(kindOfSingularity(arm, state)).toBe("boundary");
    expect(describeArm(arm, state, false)).toContain("At the boundary of the workspace. The point can't be moved");
  });
});

describe("other arms in words", () => {
  it.each([SIX, PUMA, ROBOTS["scara"]!])("are as near to a singularity in millimetres: $name", (robot) => {
    const arm = armOf(robot);
    const inMillimetres: Arm = {
      ...arm,
      joints: arm.joints.map((joint) => ({
        ...{ ...joint, a: 1000 * joint.a },
        ...(joint.kind === "P" ? { offset: 1000 * joint.offset } : { otherConstant: 1000 * joint.otherConstant }),
      })),
      point: { ...arm.point, offset: scaleVector(arm.point.offset, 1000) },
    };
    const pose = [0.5, 0.8, 0.3, 0.6, 0.9, 1.2].slice(0, arm.joints.length);
    const poseInMillimetres = pose.map((value, i) => (arm.joints[i]!.kind === "P" ? 1000 * value : value));
    const { ratio } = measuresOf(inMillimetres, stateAt(inMillimetres, poseInMillimetres));
    expect(ratio).toBeCloseTo(measuresOf(arm, stateAt(arm, pose)).ratio, 10);
    expect(ratio).toBeGreaterThan(0.004);
  });

  it("have no determinant if J is not square", () => {
    const arm = armOf(ROBOTS["planar-3r"]!);
    expect(describeArm(arm, stateAt(arm, [0.3, 0.4, 0.5]), false)).toContain("J is not square");
  });

  it("have values of prismatic joints in metres", () => {
    const arm = armOf(ROBOTS["scara"]!);
    expect(describeArm(arm, stateAt(arm, [0, 0, 0.25, 0]), false)).toContain("d3 0.25 metres");
  });

  it("have symbols as letters", () => {
    expect(["theta12", "d3", "p*0", "P", "sigma_min"].map(plainLetters)).toEqual(["θ12", "d3", "p*0", "P", "σmin"]);
  });
});
