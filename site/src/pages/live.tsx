// The live arm in a page of text; its data comes with the element, as Python wrote it.

import { type JSX, render } from "preact";

import { Arm } from "../arm/panel.js";
import type { Factor, NamedPose, Robot, SymbolInfo } from "../bank.js";
import { getLanguageCode } from "../text/languages.js";
import { Hero } from "./hero.js";

/** The data of an arm, as `arm_record` of exercises/site/record.py writes it. */
export interface ArmRecord {
  readonly robot: Robot;
  readonly symbols: Readonly<Record<string, SymbolInfo>>;
  readonly pose: NamedPose;
  readonly factors?: readonly Factor[];
}

/** Show the arm that an element describes: `data-arm` with the whole stage, `data-hero` with drawing and numbers. */
export function showArm(element: HTMLElement): void {
  const { arm, hero } = element.dataset;
  const { robot, symbols, pose, factors } = JSON.parse(arm ?? hero!) as ArmRecord;
  const wish = { robot, first: pose, factors };
  const liveArm: JSX.Element = arm ? <Arm {...wish} symbols={symbols} pane="joints" /> : <Hero {...wish} />;
  element.textContent = "";
  element.lang = getLanguageCode();
  render(liveArm, element);
}
