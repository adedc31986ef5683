// @vitest-environment happy-dom
// The whole panel on a page: sliders move the arm, a given pose is drawn, and descriptions are updated.

import { h, render } from "preact";
import { act } from "preact/test-utils";
import { beforeEach, describe, expect, it, vi } from "vitest";

import type { NamedPose } from "../../src/bank.js";
import { Arm, type ArmProps } from "../../src/arm/panel.js";
import { onSchemeChange } from "../../src/arm/space.js";
import { showArm } from "../../src/pages/live.js";
import { PLAIN, ROBOTS, SIX } from "./robots.js";

// All at once: what is shown is tested here, not when.
vi.mock("../../src/scheduling.js", async (real) => ({
  ...(await real<typeof import("../../src/scheduling.js")>()),
  useSteps: (last: number) => last,
}));

const symbols = {};

function show(props: Partial<ArmProps>): void {
  void act(() => render(h(Arm, { robot: PLAIN, symbols, ...props }), document.body));
}

const press = (button: string): void => void act(() => document.querySelector<HTMLButtonElement>(button)!.click());
const lengths = (): string => document.querySelector(".arm-lengths")?.textContent ?? "";

function numbers(): string[] {
  return [...document.querySelectorAll<HTMLInputElement>(".arm-joint-row input[type=number]")].map((i) => i.value);
}

/** Where a disc is moved to, by the group that it is in. */
function placeOf(disc: Element): [number, number] {
  const [, x, y] = /^translate\((\S+) (\S+)\)$/.exec(disc.parentElement!.getAttribute("transform")!)!;
  return [Number(x), Number(y)];
}

describe("the panel", () => {
  beforeEach(() => {
    render(null, document.body);
  });

  it("rotates the view for a pose in which the arm would point at the reader, and back", () => {
    const turns = (...degrees: number[]): NamedPose =>
      Object.fromEntries(degrees.map((angle, i) => [`theta${i + 1}`, (angle * Math.PI) / 180]));
    /** How far the links go on the page (pixels). */
    const spread = (): number => {
      const places = [...document.querySelectorAll(".arm-grip")].flatMap((link) =>
        link
          .getAttribute("points")!
          .split(" ")
          .map((place) => place.split(",").map(Number) as [number, number]),
      );
      return Math.max(...places.flatMap((a) => places.map((b) => Math.hypot(a[0] - b[0], a[1] - b[1]))));
    };
    const [firstPose, endOn] = [turns(36, 24, 90, 0, 30, 0), turns(36, 24, 90, 10, 30, 0)];
    show({ robot: SIX, firstPose });
    expect(spread()).toBeLessThan(20); // as its figure shows it
    show({ robot: SIX, firstPose, pose: endOn });
    expect(spread()).toBeGreaterThan(80);
    press(".arm-reset");
    expect(spread()).toBeLessThan(20);
  });

  it("shows J before a lesson introduces det J, but nothing that comes from det J", () => {
    const text = (): string => document.querySelector(".arm")!.textContent!;
    show({ pane: "jacobian" });
    expect(text()).toMatch(/det\sJ.*singular/s);
    render(null, document.body);
    show({ pane: "jacobian", layers: { frames: false } });
    expect(text()).toContain("Angle of"); // as of an arm of six joints, whose frames are not drawn at first
    render(null, document.body);
    show({ pane: "jacobian", unknown: "determinant" });
    expect(text()).toContain("P = (");
    expect(text()).not.toMatch(/det\sJ|singular/);
    expect(document.querySelector(".arm-jacobian")).not.toBeNull();
    render(null, document.body);
    show({ unknown: "jacobian" });
    expect(document.querySelector(".arm-jacobian")).toBeNull();
  });

  it("shows neither det J nor its map nor a lost direction if they would answer the question", () => {
    const text = (): string => document.querySelector(".arm")!.textContent!;
    const firstPose = { theta1: 0.5, theta2: 0 };
    show({ firstPose, isDeterminantHidden: true });
    expect(document.querySelector(".arm-map-frame, .arm-factors, .arm-readout, .arm-lost")).toBeNull();
    expect(text()).toContain("They appear once your answer is right");
    expect(text()).not.toMatch(/det\sJ =|Singular|determinant/);
    show({ firstPose, isDeterminantHidden: true, pose: { theta2: 0 } }); // a counterexample
    expect(document.querySelector(".arm-lost")).not.toBeNull();
    show({ firstPose, isDeterminantHidden: false });
    expect(document.querySelectorAll(".arm-map-frame, .arm-factors, .arm-lost")).toHaveLength(3);
  });

  it("shows a short column of J beside the disc of P, and explains the dotted line", () => {
    show({ pose: { theta1: 0.5, theta2: Math.PI } });
    const shaft = document.querySelector(".arm-column.arm-j1 .arm-shaft")!.getAttribute("points")!;
    const [x0, y0, x1, y1] = shaft.split(/[ ,]/).map(Number);
    const disc = document.querySelector(".arm-point-ring")!;
    const [[x, y], r] = [placeOf(disc), Number(disc.getAttribute("r"))];
    expect(Math.hypot(x0! - x!, y0! - y!)).toBeGreaterThan(r!);
    expect(Math.hypot(x1! - x!, y1! - y!)).toBeGreaterThan(r! + 1);
    const labels = [...document.querySelectorAll(".arm-letter-layer .arm-j1 text")].map((one) => one.textContent);
    expect(labels.some((label) => label!.startsWith("J"))).toBe(true);
    expect(document.querySelector(".arm-lost")).not.toBeNull();
    expect(document.querySelector(".arm-lost-words")!.textContent).toContain("can't be moved along this line");
    show({ pose: { theta1: 0.5, theta2: 1 } });
    expect([document.querySelector(".arm-lost"), document.querySelector(".arm-lost-words")]).toEqual([null, null]);
  });

  it("draws a given pose, and the next one", () => {
    show({ pose: { theta1: Math.PI / 6, theta2: 1, a1: 3 } });
    expect(numbers()).toEqual(["30", "57.3"]);
    expect(document.querySelector(".arm-lengths")?.textContent).toContain("a1 = 3 m");
    show({ pose: { theta1: 0, theta2: -Math.PI / 2 } });
    expect(numbers()).toEqual(["0", "-90"]);
    expect(document.querySelector(".arm-figures")?.textContent).toContain("−0.2");
  });

  it("takes a number when it is complete; a minus sign alone stays", () => {
    show({ pose: { theta1: Math.PI / 6, theta2: 1, a1: 3 } });
    const field = document.querySelectorAll<HTMLInputElement>(".arm-joint-row input[type=number]")[1]!;
    const typed = (value: string, event: string): void =>
      void act(() => {
        field.value = value;
        field.dispatchEvent(new Event(event, { bubbles: true }));
      });
    typed("", "input");
    expect(numbers()).toEqual(["30", ""]);
    typed("-4", "input");
    typed("-40", "input");
    typed("-40", "change");
    expect(numbers()).toEqual(["30", "-40"]);
  });

  it("has the lengths and joint values of its question, also after a counterexample", () => {
    const firstPose = { theta1: Math.PI / 6, theta2: 1, a1: 3 };
    show({ firstPose });
    expect(numbers()).toEqual(["30", "57.3"]);
    expect(lengths()).toContain("a1 = 3 m");
    show({ firstPose, pose: { theta1: 0, theta2: -Math.PI / 2, a1: 7 } });
    expect(numbers()).toEqual(["0", "-90"]);
    expect(lengths()).toContain("a1 = 7 m");
    press(".arm-reset");
    expect(numbers()).toEqual(["30", "57.3"]);
    expect(lengths()).toContain("a1 = 3 m");
    show({ firstPose, pose: { theta1: 1, theta2: 1 } });
    expect(numbers()).toEqual(["57.3", "57.3"]);
  });

  it("undoes and redoes moves: all between one press of a key and the next are one", () => {
    const firstPose = { theta1: 0, theta2: 1 };
    show({ firstPose });
    const slider = (): HTMLInputElement =>
      document.querySelector<HTMLInputElement>(".arm-joint-row input[type=range]")!;
    const slide = (...values: number[]): void =>
      void act(() => {
        slider().dispatchEvent(new Event("pointerdown", { bubbles: true }));
        for (const value of values) {
          slider().value = String(value);
          slider().dispatchEvent(new Event("input", { bubbles: true }));
        }
        slider().dispatchEvent(new Event("pointerup", { bubbles: true }));
      });
    const pressInDrawing = (init: KeyboardEventInit): void =>
      void act(() => {
        const event = new KeyboardEvent("keydown", { bubbles: true, ...init });
        document.querySelector(".arm-box")!.dispatchEvent(event);
      });
    const isEnabled = (way: string): boolean =>
      document.querySelector(`.arm-${way}`)!.getAttribute("aria-disabled") === "false";
    expect([isEnabled("undo"), isEnabled("redo")]).toEqual([false, false]);
    slide(10, 20, 30);
    slide(40, 50);
    press(".arm-reset");
    expect(numbers()[0]).toBe("0");
    press(".arm-undo");
    expect(numbers()[0]).toBe("50");
    pressInDrawing({ key: "z", ctrlKey: true });
    expect(numbers()[0]).toBe("30");
    press(".arm-undo");
    expect([numbers()[0], isEnabled("undo")]).toEqual(["0", false]);
    press(".arm-undo");
    pressInDrawing({ key: "y", ctrlKey: true });
    pressInDrawing({ key: "Z", metaKey: true, shiftKey: true });
    expect(numbers()[0]).toBe("50");
    slide(60);
    expect(isEnabled("redo")).toBe(false);
  });

  it("has sliders for symbolic lengths; they change the arm, and the pose stays", () => {
    const firstPose = { theta1: Math.PI / 6, theta2: Math.PI / 2 };
    show({ firstPose });
    void act(() => {
      const slider = document.querySelectorAll<HTMLInputElement>(".arm-lengths input")[0]!;
      slider.value = "0.8";
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    expect(lengths()).toContain("a1 = 0.8 m");
    expect(numbers()).toEqual(["30", "90"]);
    expect(document.querySelector(".arm-figures")!.textContent).toContain("det J0.32");
    press(".arm-reset");
    expect(lengths()).toContain("a1 = 0.5 m");
  });

  it("shows a prismatic joint at its question's value, even beyond its usual range", () => {
    const robot = ROBOTS["scara"]!;
    const slide = robot.joints.findIndex(({ kind }) => kind === "P");
    const name = `d${slide + 1}`;
    const told = Object.fromEntries(
      robot.joints.map(({ kind }, i) => [`${kind === "R" ? "theta" : "d"}${i + 1}`, 0.5]),
    );
    for (const value of [9.5, -8.25]) {
      render(null, document.body);
      show({ robot, firstPose: { ...told, [name]: value } });
      expect(numbers()[slide]).toBe(String(value));
    }
  });

  it("hides J while it would answer the question", () => {
    const firstPose = { theta1: 0, theta2: 0 };
    const told = (): string => document.querySelector(".arm")!.textContent!;
    show({ firstPose, isConcealed: true });
    expect(document.querySelector(".arm-jacobian, .arm-factors, .arm-column, .arm-ellipse, .arm-lost")).toBeNull();
    expect(told().split("once you have answered")).toHaveLength(2); // once, though map and numbers are both in sight
    press('.arm-tabs button[aria-expanded="true"]');
    expect(told().split("once you have answered")).toHaveLength(2);
    expect(told()).not.toMatch(/ingular|determinant/);
    show({ firstPose, isConcealed: false });
    expect(document.querySelectorAll(".arm-jacobian, .arm-column, .arm-ellipse, .arm-lost").length).toBeGreaterThan(3);
    expect(told()).toContain("Singular");
  });

  it("draws the dot of a rate, and contains it as text for screen readers", () => {
    show({});
    const heads = [...document.querySelectorAll(".arm-jacobian thead th .dotted")];
    expect(heads.map((head) => head.textContent)).toEqual(["θ˙", "θ˙"]);
    expect(document.querySelector(".arm-joints .dotted")).toBeNull();
  });

  it("describes the new pose after a slider is moved", () => {
    const onPose = vi.fn();
    show({ pose: { theta1: 0, theta2: 1 }, onPose });
    const slider = document.querySelector<HTMLInputElement>("input[type=range]")!;
    slider.value = "45";
    void act(() => {
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    expect(onPose).toHaveBeenCalledOnce();
    expect(onPose.mock.calls[0]![0].theta1).toBeCloseTo(Math.PI / 4);
    expect(onPose.mock.calls[0]![0].theta2).toBeCloseTo(1);
  });

  it("moves by keys on the drawing and on the map", () => {
    show({ pose: { theta1: 0, theta2: 1 } });
    const press = (element: string, key: string): void => {
      const event = new KeyboardEvent("keydown", { key, bubbles: true });
      void act(() => {
        document.querySelector(element)!.dispatchEvent(event);
      });
    };
    press(".arm-box", "ArrowRight");
    expect(numbers()).toEqual(["2", "57.3"]);
    press(".arm-box", "2");
    press(".arm-box", "ArrowLeft");
    expect(numbers()).toEqual(["2", "55.3"]);
    press(".arm-map-frame", "ArrowUp");
    expect(numbers()).toEqual(["2", "57.3"]);
  });

  it("moves P by the arrow keys, equally far in each direction", () => {
    let pose: NamedPose = { theta1: 0.3, theta2: 1 };
    const point = (): [number, number] => [
      0.5 * Math.cos(pose.theta1!) + 0.4 * Math.cos(pose.theta1! + pose.theta2!),
      0.5 * Math.sin(pose.theta1!) + 0.4 * Math.sin(pose.theta1! + pose.theta2!),
    ];
    const onPose = (next: NamedPose): void => void (pose = next);
    show({ pose, onPose });
    const press = (key: string): [number, number] => {
      const [x, y] = point();
      void act(() => {
        document.querySelector(".arm-box")!.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      });
      return [point()[0] - x, point()[1] - y];
    };
    press("p");
    const right = press("ArrowRight");
    const up = press("ArrowUp");
    expect(right[0]).toBeGreaterThan(0.001);
    expect(right[1]).toBeCloseTo(0, 4);
    expect(up[0]).toBeCloseTo(0, 4);
    expect(up[1]).toBeCloseTo(right[0], 4);
  });

  it("marks the pose on the map", () => {
    const of = (selector: string, name: string): number => Number(document.querySelector(selector)!.getAttribute(name));
    const [across, up] = [Math.PI / 2, -Math.PI / 4];
    show({ pose: { theta1: across, theta2: up } });
    const box = ["x", "y", "width", "height"].map((name) => of(".arm-map-edge", name));
    const here = placeOf(document.querySelector(".arm-here")!);
    expect(here[0]).toBeCloseTo(box[0]! + (across / (2 * Math.PI) + 0.5) * box[2]!);
    expect(here[1]).toBeCloseTo(box[1]! + (0.5 - up / (2 * Math.PI)) * box[3]!);
  });

  it("labels everything that can be used", () => {
    show({});
    for (const input of document.querySelectorAll("input, select")) {
      expect(input.getAttribute("aria-label") ?? input.closest("label")?.textContent).toBeTruthy();
    }
    for (const one of document.querySelectorAll("[role=application]")) {
      expect(one.getAttribute("tabindex")).toBe("0");
      expect(one.getAttribute("aria-label")).toBeTruthy();
    }
  });
});

it("is painted again when the system changes to its dark scheme", () => {
  const system = Object.assign(new EventTarget(), { matches: false });
  const query = vi.spyOn(globalThis, "matchMedia").mockReturnValue(system as unknown as MediaQueryList);
  const changed = vi.fn();
  const stop = onSchemeChange(changed);
  system.dispatchEvent(new Event("change"));
  stop();
  system.dispatchEvent(new Event("change"));
  expect(query).toHaveBeenCalledWith("(prefers-color-scheme: dark)");
  expect(changed).toHaveBeenCalledTimes(1);
  query.mockRestore();
});

it("begins in the pose of the figure in a page of text", () => {
  render(null, document.body);
  const element = document.createElement("div");
  document.body.append(element);
  element.dataset["arm"] = JSON.stringify({ robot: PLAIN, symbols, pose: { theta1: 0.5, theta2: 1 } });
  void act(() => showArm(element));
  expect(numbers()).toEqual(["28.6", "57.3"]);
  render(null, element);
  element.remove();
});
