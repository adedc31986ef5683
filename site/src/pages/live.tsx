// The live arm in a page of text; its data comes with the element, as Python wrote it.

import { type JSX, render } from "preact";

import { Arm } from "../arm/panel.js";
import type { StageRequest } from "../arm/stage.js";
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
  const request: StageRequest = { robot, firstPose: pose, factors };
  const liveArm: JSX.Element = arm ? <Arm {...request} symbols={symbols} pane="joints" /> : <Hero {...request} />;
  element.textContent = "";
  element.lang = getLanguageCode();
  render(liveArm, element);
}
